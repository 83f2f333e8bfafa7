"""The sonar's beam as rays: the nearest echo anywhere in the beam is the range.

A wall at right angles to a world axis is nearest, within a beam, along the direction of the beam that lies closest to
that axis. In a tank of such walls a few rays therefore find the nearest echo exactly: the beam's centre and, of all
directions in the beam, those closest to ahead, to either side, up and down.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..compiled import law

Array = NDArray[np.float64]

ACROSS_RAD = math.radians(0.5)  # [rad] half width of a sector beam across its fan: 1 deg (shared drawing of the ST725)
TARGETS = 6  # rays of a beam with a width


@law
def rotation(quaternion: Array) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Body axes from a unit quaternion (w, x, y, z): nine numbers of the matrix that takes body to world, by rows."""
    w, x, y, z = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    return (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )


@law
def into_cone(x: float, y: float, z: float, half: float) -> tuple[float, float, float]:
    """The direction within `half` [rad] of the body's x axis that is closest to the unit vector (x, y, z)."""
    side = math.hypot(y, z)
    angle = min(math.atan2(side, x), half)
    scale = math.sin(angle) / side if side > 0.0 else 0.0
    return math.cos(angle), scale * y, scale * z


@law
def into_fan(x: float, y: float, z: float, half: float) -> tuple[float, float, float]:
    """The direction within the fan, `half` [rad] up and down, that is closest to the unit vector (x, y, z)."""
    azimuth = min(max(math.atan2(y, x), -ACROSS_RAD), ACROSS_RAD)
    level = x * math.cos(azimuth) + y * math.sin(azimuth)  # what (x, y, z) has along that azimuth
    elevation = min(max(math.atan2(z, level), -half), half)
    return math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)


@law
def aim(quaternion: Array, fan: bool, half: float, directions: Array) -> None:
    """Fill the rays' world directions, shape (1 or TARGETS, 3), of a beam along the body's x axis."""
    a, b, c, d, e, f, g, h, i = rotation(quaternion)
    axes = ((a, b, c), (d, e, f), (g, h, i))
    directions[0, 0], directions[0, 1], directions[0, 2] = a, d, g
    for ray in range(1, directions.shape[0]):
        x, y, z = axes[ray // 2]  # ahead, port, starboard, up, down in body axes
        if ray == 3 or ray == 5:
            x, y, z = -x, -y, -z
        x, y, z = into_fan(x, y, z, half) if fan else into_cone(x, y, z, half)
        directions[ray, 0] = a * x + b * y + c * z
        directions[ray, 1] = d * x + e * y + f * z
        directions[ray, 2] = g * x + h * y + i * z
