"""Where a vehicle was, from its start on, and how it is set there in a model."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from .model import vehicle_body

Array = NDArray[np.float64]
UP = np.diag([1.0, -1.0, -1.0])  # from axes z down to axes z up, x ahead in both


@dataclass(frozen=True, eq=False)
class Poses:
    """Places and attitudes of a vehicle.

    Attributes:
        time_s: shape (T,) [s].
        place_m: north, east and down of the start, shape (T, 3) [m].
        attitude_rad: roll, pitch and heading, which goes on beyond a turn, shape (T, 3) [rad].
    """

    time_s: Array
    place_m: Array
    attitude_rad: Array

    def at(self, time_s: float) -> tuple[Array, Array]:
        """Place and attitude at a time, shape (3,) each; those of the first or last sample beyond them."""
        place, attitude = (
            np.array([np.interp(time_s, self.time_s, column) for column in values.T])
            for values in (self.place_m, self.attitude_rad)
        )
        return place, attitude


def set_pose(model: mujoco.MjModel, data: mujoco.MjData, poses: Poses, time_s: float) -> None:
    """Set the vehicle where it was at a time, seen from the start pose of the model, which is level."""
    joint = model.body_jntadr[vehicle_body(model)]
    first = model.jnt_qposadr[joint]
    (place, (roll, pitch, heading)) = poses.at(time_s)
    turn, start, quaternion = np.zeros(9), np.zeros(9), np.zeros(4)
    mujoco.mju_euler2Quat(quaternion, np.array([heading, pitch, roll]), "zyx")
    mujoco.mju_quat2Mat(turn, quaternion)
    mujoco.mju_quat2Mat(start, model.qpos0[first + 3 : first + 7])
    turned = UP @ turn.reshape(3, 3) @ UP @ start.reshape(3, 3)
    mujoco.mju_mat2Quat(quaternion, turned.ravel())
    data.qpos[first : first + 3] = model.qpos0[first : first + 3] + UP @ place
    data.qpos[first + 3 : first + 7] = quaternion
    mujoco.mj_forward(model, data)
