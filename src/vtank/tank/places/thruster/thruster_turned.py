"""A thruster does not push in the direction that the vehicle file has."""

from __future__ import annotations

import numpy as np

from ....plant.vehicle import Vehicle
from ..effect import Number, PlacedEffect, Values, part, with_part


def turned(vehicle: Vehicle, name: str, p: Values) -> Vehicle:
    """Mounted at another angle: yaw about z, then pitch about y, of the body's axes."""
    x, y, z = part(vehicle, "thrusters", name).direction
    c, s = np.cos(p["yaw"]), np.sin(p["yaw"])
    x, y = c * x - s * y, s * x + c * y
    c, s = np.cos(p["pitch"]), np.sin(p["pitch"])
    x, z = c * x + s * z, c * z - s * x
    return with_part(vehicle, "thrusters", name, direction=(float(x), float(y), float(z)))


EFFECT = PlacedEffect(
    "thruster_turned",
    "thruster",
    "direction -> R_y(pitch) R_z(yaw) direction",
    (
        Number("yaw", ("_rad",), "about the body's z", 0.0, -3.2, 3.2, usual=lambda _: 0.3, slot="yawed"),
        Number("pitch", ("_rad",), "about the body's y", 0.0, -3.2, 3.2, usual=lambda _: 0.2, slot="pitched"),
    ),
    changes=turned,
    order=13,
)
