"""A slack cable pulls back to where the run began, along this axis of the vehicle."""

from __future__ import annotations

from ....plant.vehicle import AXES
from ..effect import Array, Moving, Number, PlacedEffect, Values, along


def spring(s: Moving, axis: str, p: Values) -> Array:
    """Back to where the run began."""
    return along(axis, -p["k"] * float(s.away[AXES.index(axis)]))


EFFECT = PlacedEffect(
    "tether",
    "axis",
    "F = -k x",
    (Number("k", ("_N_per_m", "_N_m_per_rad"), "stiffness", low=0.0, usual=lambda s: 0.3 * s.force, slot="spring"),),
    wrench=spring,
    order=5,
)
