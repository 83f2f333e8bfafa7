"""The force follows more slowly than the vehicle file has it."""

from __future__ import annotations

from ....plant.vehicle import Vehicle
from ..effect import Number, PlacedEffect, Values, part, with_part


def slower(vehicle: Vehicle, name: str, p: Values) -> Vehicle:
    """Longer lag."""
    return with_part(vehicle, "thrusters", name, lag_s=part(vehicle, "thrusters", name).lag_s + p["tau"])


EFFECT = PlacedEffect(
    "thrust_lag",
    "thruster",
    "lag_s -> lag_s + tau",
    (Number("tau", ("_s",), "more time constant", low=0.0, high=60.0, usual=lambda _: 0.4, slot="slower"),),
    changes=slower,
    order=5,
)
