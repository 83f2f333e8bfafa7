"""Sway, depth, pitch and heading held or moved by the thrusters, on the true pose: a perfect gyro and depth cell.

Proportional and damping gains are natural frequency and damping ratio of each axis by itself; they are guesses, as the
paper only says that these thrusters "were under active control". An order to one of the axes moves the place where it
is held, or replaces its controller by a force.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..compiled import law
from .beam import rotation

Array = NDArray[np.float64]
AXES = (1, 2, 4, 5)  # sway, heave, pitch, yaw of (u, v, w, p, q, r)
NAMES = ("sway", "heave", "pitch", "yaw")
PLACE, RATE, FORCE = range(3)  # columns of orders: [m or rad], [m/s or rad/s], [N or N m]
AS_IT_WAS = (0.0, 0.0, math.nan)  # hold the axis where it started


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
    gains: Array,
    inertia: Array,
    allocation: Array,
    limit_N: Array,
    orders: Array,
    out_N: Array,
) -> None:
    """Set the thrusters' forces of N runs, out_N (N, K) [N].

    qpos (N, 7) and qvel (N, 6) as MuJoCo's; gains (N, 3): depth [m], natural frequency [rad/s], damping; inertia (4,):
    mass or moment of inertia of AXES with added mass [kg, kg m2]; allocation (K, 4); limit_N (K,); orders (N, 4, 3):
    PLACE, RATE and FORCE of AXES, FORCE NaN where the axis is held.
    """
    force = np.empty(4)
    for i in range(qpos.shape[0]):
        depth_m, rad_s, damping = gains[i, 0], gains[i, 1], gains[i, 2]
        stiffness, damper = rad_s * rad_s, 2.0 * damping * rad_s
        _, pitch, yaw = attitude(qpos[i, 3:7])
        place = -qpos[i, 1], -qpos[i, 2] - depth_m, pitch, yaw  # along AXES, in the body's senses
        rate = -qvel[i, 1], -qvel[i, 2], qvel[i, 4], qvel[i, 5]
        for axis in range(4):
            lag, slip = place[axis] - orders[i, axis, PLACE], rate[axis] - orders[i, axis, RATE]
            held = -inertia[axis] * (stiffness * lag + damper * slip)
            force[axis] = held if math.isnan(orders[i, axis, FORCE]) else orders[i, axis, FORCE]
        for j in range(limit_N.size):
            share = allocation[j, 0] * force[0] + allocation[j, 1] * force[1]
            share = share + allocation[j, 2] * force[2] + allocation[j, 3] * force[3]
            out_N[i, j] = min(max(share, -limit_N[j]), limit_N[j])
