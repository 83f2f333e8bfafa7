"""The vehicle is lighter or heavier in water than its file has it."""

from __future__ import annotations

from dataclasses import replace

from ....plant.vehicle import Vehicle
from ..effect import VEHICLE, Number, PlacedEffect, Values


def lighter(vehicle: Vehicle, place: str, p: Values) -> Vehicle:
    """More buoyancy."""
    return replace(vehicle, buoyancy_N=vehicle.buoyancy_N + p["B"])


EFFECT = PlacedEffect(
    "buoyancy",
    VEHICLE,
    "B -> B + B",
    (Number("B", ("_N",), "more buoyancy", usual=lambda s: 0.005 * s.weight),),
    changes=lighter,
    order=3,
)
