"""An accelerometer reads what is not there."""

from __future__ import annotations

from ..effect import Number, PlacedEffect
from .change import biased

ACCELEROMETER = {axis: f"accel_{axis}_m_s2" for axis in "xyz"}


EFFECT = PlacedEffect(
    "accelerometer_bias",
    "sensor",
    "z -> z + b",
    tuple(
        Number(x, ("_m_s2",), f"bias along {x}", 0.0, -100.0, 100.0, name, usual=lambda _: 0.1)
        for x, name in ACCELEROMETER.items()
    ),
    channels=tuple(ACCELEROMETER.values()),
    changes=biased(ACCELEROMETER),
    order=11,
)
