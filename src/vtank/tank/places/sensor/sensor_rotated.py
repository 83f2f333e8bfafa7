"""It is mounted at other angles than the vehicle file has."""

from __future__ import annotations

import numpy as np

from ....plant.sensor import Sensor, matrix_of
from ..effect import Number, PlacedEffect, Values
from .change import change

ANGLE = -3.2, 3.2  # [rad] admissible


def rotated(sensor: Sensor, p: Values) -> tuple[float, float, float]:
    """Roll, pitch and yaw [deg] of a sensor that is turned in its own axes from where the file has it."""
    turn = sensor.rotation @ matrix_of(np.array([p["roll"], p["pitch"], p["yaw"]]))
    angles = np.arctan2(turn[2, 1], turn[2, 2]), -np.arcsin(np.clip(turn[2, 0], -1.0, 1.0)), np.arctan2(*turn[1::-1, 0])
    roll, pitch, yaw = np.degrees(angles)
    return float(roll), float(pitch), float(yaw)


EFFECT = PlacedEffect(
    "sensor_rotated",
    "sensor",
    "R -> R R(roll, pitch, yaw)",
    tuple(
        Number(axis, ("_rad",), f"{axis} in its own axes", 0.0, *ANGLE, usual=lambda _: 0.15)
        for axis in ("roll", "pitch", "yaw")
    ),
    changes=change(rotation_deg=rotated),
    order=8,
)
