"""A thruster makes only part of its force, or none."""

from __future__ import annotations

from ....plant.vehicle import Vehicle
from ..effect import Array, Number, PlacedEffect, Values


def weak(time_s: Array, n: Array, force: Array, p: Values) -> Array:
    """What is left of it."""
    return force * (1.0 - p["share"])


def lost(vehicle: Vehicle, name: str) -> dict[str, float] | None:
    """By the corrections: 1 of all of it, 2 where it pushes the other way instead."""
    share = vehicle.corrections.get(f"lost@{name}", 0.0)
    share = share if share <= 1.0 else 2.0 - share
    return {"share": share} if share else None


EFFECT = PlacedEffect(
    "thruster_dead",
    "thruster",
    "F -> (1 - share) F",
    (Number("share", ("",), "of its force that is lost", 1.0, 0.0, 1.0, usual=lambda _: 0.5),),
    thrust=weak,
    of=lost,
    order=10,
)
