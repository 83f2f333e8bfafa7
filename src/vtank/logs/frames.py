"""Axes of logs turned into those of vtank: earth north, east, down; body x forward, y starboard, z down.

ROS has earth axes east, north, up (ENU) and body axes forward, left, up (FLU), REP-103; autopilots have north, east,
down (NED) and forward, right, down (FRD).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
EARTH = {"NED": np.eye(3), "ENU": np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])}  # to NED
BODY = {"FRD": np.eye(3), "FLU": np.diag([1.0, -1.0, -1.0])}  # to FRD
ATTITUDE = {"NED-FRD": ("NED", "FRD"), "ENU-FLU": ("ENU", "FLU")}
DOWN = {"ENU": "NED", "FLU": "FRD", "ENU-FLU": "NED-FRD"}  # the same with z down
SEMI_MAJOR_M, ECCENTRICITY2 = 6378137.0, 6.69437999014e-3  # of the ellipsoid WGS 84
LENGTH_OFF = 0.05  # by which a quaternion may be longer or shorter than 1 and still be one; a choice


def vector(values: Array, frame: str) -> Array:
    """Vectors, shape (3, K), in vtank's axes of the same kind: earth for NED and ENU, body for FRD and FLU."""
    return np.asarray((EARTH | BODY)[frame] @ values)


def angles(quaternion: Array, frame: str) -> Array:
    """Roll, pitch, heading [rad], shape (3, K), of quaternions w, x, y, z, shape (4, K), that turn body into earth.

    NaN where a quaternion is not of length 1.
    """
    earth, body = ATTITUDE[frame]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        length = np.linalg.norm(quaternion, axis=0)
        w, x, y, z = np.where(np.abs(length - 1.0) <= LENGTH_OFF, quaternion / length, np.nan)
    turn = np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
    r = np.einsum("ij,jkt,lk->ilt", EARTH[earth], turn, BODY[body])
    return np.array(
        [np.arctan2(r[2, 1], r[2, 2]), -np.arcsin(np.clip(r[2, 0], -1.0, 1.0)), np.arctan2(r[1, 0], r[0, 0])]
    )


def to_body(values: Array, attitude: Array) -> Array:
    """Vectors in earth axes north, east, down in body axes, by roll, pitch and heading; all shapes (3, K)."""
    (cr, cp, ch), (sr, sp, sh) = np.cos(attitude), np.sin(attitude)
    north, east, down = values
    ahead, across = ch * north + sh * east, ch * east - sh * north
    lower = sp * ahead + cp * down
    return np.array([cp * ahead - sp * down, cr * across + sr * lower, cr * lower - sr * across])


def local(latitude_rad: Array, longitude_rad: Array) -> Array:
    """Places north and east of the first [m], shape (2, K), flat about it: to 1e-4 within some km."""
    first = latitude_rad[0]
    bend = 1.0 - ECCENTRICITY2 * np.sin(first) ** 2
    meridian, normal = SEMI_MAJOR_M * (1.0 - ECCENTRICITY2) / bend**1.5, SEMI_MAJOR_M / np.sqrt(bend)
    return np.array([meridian * (latitude_rad - first), normal * np.cos(first) * (longitude_rad - longitude_rad[0])])
