"""Depth, heading, pitch and sway held by the tunnel thrusters, on the true pose: a perfect gyro and depth cell.

Proportional and damping gains are natural frequency and damping ratio of each axis by itself; they are guesses, as the
paper only says that these thrusters "were under active control".
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..compiled import law
from .beam import rotation

Array = NDArray[np.float64]
AXES = (1, 2, 4, 5)  # sway, heave, pitch, yaw of (u, v, w, p, q, r)


def allocation(wrenches: Array) -> Array:
    """Thruster forces that make a wanted sway and heave force, pitch and yaw moment, shape (K, 4).

    wrenches: of each thruster at 1 N, shape (K, 6). The least-squares solution where the thrusters cannot make it all.
    """
    return np.asarray(np.linalg.pinv(wrenches[:, AXES].T), dtype=np.float64)


@law
def attitude(quaternion: Array) -> tuple[float, float, float]:
    """Roll, pitch, yaw [rad] of body axes x forward, y starboard, z down, in the world x ahead, y port, z up."""
    a, b, c, d, e, f, g, h, i = rotation(quaternion)
    return math.atan2(-h, -i), math.asin(min(max(g, -1.0), 1.0)), math.atan2(-d, a)


@law
def hold(
    qpos: Array,
    qvel: Array,
    depth_m: float,
    rad_s: float,
    damping: float,
    inertia: Array,
    allocation: Array,
    limit_N: Array,
    thruster_N: Array,
) -> None:
    """Set the thrusters' forces (K,) [N].

    qpos (7,) and qvel (6,) as MuJoCo's; inertia (4,): mass or moment of inertia of AXES with added mass [kg, kg m2];
    allocation (K, 4); limit_N (K,).
    """
    _, pitch, yaw = attitude(qpos[3:7])
    stiffness, damper = rad_s * rad_s, 2.0 * damping * rad_s
    sway = -inertia[0] * (stiffness * -qpos[1] + damper * -qvel[1])
    heave = -inertia[1] * (stiffness * (-qpos[2] - depth_m) + damper * -qvel[2])
    trim = -inertia[2] * (stiffness * pitch + damper * qvel[4])
    turn = -inertia[3] * (stiffness * yaw + damper * qvel[5])
    for j in range(thruster_N.size):
        force = allocation[j, 0] * sway + allocation[j, 1] * heave + allocation[j, 2] * trim + allocation[j, 3] * turn
        thruster_N[j] = min(max(force, -limit_N[j]), limit_N[j])
