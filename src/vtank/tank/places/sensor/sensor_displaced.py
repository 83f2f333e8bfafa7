"""It sits elsewhere than the vehicle file has it."""

from __future__ import annotations

from ....plant.sensor import Sensor
from ..effect import Number, PlacedEffect, Values
from .change import change

ARM = -100.0, 100.0  # [m] admissible


def displaced(sensor: Sensor, p: Values) -> tuple[float, float, float]:
    """Place [m] of a sensor that sits elsewhere."""
    x, y, z = sensor.position_m
    return x + p["x"], y + p["y"], z + p["z"]


EFFECT = PlacedEffect(
    "sensor_displaced",
    "sensor",
    "r -> r + (x, y, z)",
    tuple(
        Number(axis, ("_m",), f"along the body's {axis}", 0.0, *ARM, usual=lambda s: 0.05 * s.hull) for axis in "xyz"
    ),
    changes=change(position_m=displaced),
    order=9,
)
