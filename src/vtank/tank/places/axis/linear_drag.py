"""Drag that grows with speed itself, which the vehicle file has not."""

from __future__ import annotations

from dataclasses import replace

from ....plant.vehicle import AXES, Vehicle
from ..effect import Number, PlacedEffect, Values


def slower(vehicle: Vehicle, axis: str, p: Values) -> Vehicle:
    """The vehicle with more linear drag along an axis."""
    drag = vehicle.linear_drag.copy()
    drag[AXES.index(axis)] += p["c"]
    return replace(vehicle, linear_drag=drag)


EFFECT = PlacedEffect(
    "linear_drag",
    "axis",
    "F = -c u_r",
    (Number("c", ("_N_s_per_m", "_N_m_s_per_rad"), "drag per speed", low=0.0, usual=lambda s: 0.5 * s.force / s.u),),
    changes=slower,
    order=1,
)
