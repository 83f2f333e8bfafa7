"""The centre of buoyancy is not where the vehicle file has it."""

from __future__ import annotations

from dataclasses import replace

from ....plant.vehicle import Vehicle
from ..effect import VEHICLE, PlacedEffect, Values
from .offset import xyz


def buoyed_elsewhere(vehicle: Vehicle, place: str, p: Values) -> Vehicle:
    """The centre of buoyancy shifted."""
    return replace(vehicle, centre_of_buoyancy_m=vehicle.centre_of_buoyancy_m + (p["x"], p["y"], p["z"]))


EFFECT = PlacedEffect(
    "centre_of_buoyancy",
    VEHICLE,
    "r_B -> r_B + (x, y, z)",
    xyz(),
    changes=buoyed_elsewhere,
    order=2,
)
