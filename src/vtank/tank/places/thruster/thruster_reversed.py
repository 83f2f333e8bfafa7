"""A thruster pushes the other way: wires or blades are the wrong way round."""

from __future__ import annotations

from ....plant.vehicle import Vehicle
from ..effect import Array, PlacedEffect, Values


def reversed_(time_s: Array, n: Array, force: Array, p: Values) -> Array:
    """The other way."""
    return -force


def more_than_lost(vehicle: Vehicle, name: str) -> dict[str, float] | None:
    """Where the corrections take more than all of its force."""
    return {} if vehicle.corrections.get(f"lost@{name}", 0.0) > 1.0 else None


EFFECT = PlacedEffect(
    "thruster_reversed",
    "thruster",
    "F -> -F",
    thrust=reversed_,
    of=more_than_lost,
    order=11,
)
