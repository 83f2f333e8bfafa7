"""How far it is to the walls: MuJoCo's ray, compiled into one loop over the rays of many simulations.

Walls stand still, so that one MjData holds them for all simulations, whose own need not be brought up to date.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..compiled import law
from ..water.library import ray
from .model import HEARD

Array = NDArray[np.float64]


class Walls:
    """The walls and the floor of a model."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        mujoco.mj_kinematics(model, self.data)

    def distances(self, points: Array, directions: Array, count: int) -> Array:
        """Distances from points along unit directions, both broadcast to (count, K, 3), shape (count, K) [m].

        Infinite where there is nothing, NaN along no direction, where MuJoCo would end the process.
        """
        shape = np.broadcast_shapes((count, 1, 3), points.shape, directions.shape)
        starts, along = (np.array(np.broadcast_to(rows, shape), order="C") for rows in (points, directions))
        return np.asarray(_distances(self.model._address, self.data._address, starts, along, HEARD))


@law
def _distances(model: int, data: int, points: Array, directions: Array, groups: NDArray[np.uint8]) -> Array:
    found: Array = np.empty(points.shape[:2])
    for i in range(found.shape[0]):
        for j in range(found.shape[1]):
            found[i, j] = np.nan
            start, along = points[i, j].ctypes.data, directions[i, j].ctypes.data
            if directions[i, j, 0] != 0.0 or directions[i, j, 1] != 0.0 or directions[i, j, 2] != 0.0:
                distance = ray(model, data, start, along, groups.ctypes.data, True, -1, 0, 0)
                found[i, j] = distance if distance >= 0.0 else np.inf
    return found
