"""A gyro turns where nothing turns."""

from __future__ import annotations

from ..effect import Number, PlacedEffect
from .change import biased

GYRO = {"roll": "roll_rate_rad_s", "pitch": "pitch_rate_rad_s", "yaw": "yaw_rate_rad_s"}


EFFECT = PlacedEffect(
    "gyro_bias",
    "sensor",
    "z -> z + b",
    tuple(
        Number(axis, ("_rad_s",), f"bias in {axis}", 0.0, -10.0, 10.0, name, usual=lambda _: 0.02)
        for axis, name in GYRO.items()
    ),
    channels=tuple(GYRO.values()),
    changes=biased(GYRO),
    order=10,
)
