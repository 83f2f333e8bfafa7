"""The excited axis of a run, where it is another than surge: the room along it, the place there and its record."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from . import noise as streams
from .plan import Plan
from .scenario import SHALLOWEST_M

if TYPE_CHECKING:  # a quarter of a second, and the surge model needs no tank
    from ..tank.tank import Tank

Array = NDArray[np.float64]
HALF_BREADTH_M = 0.3  # [m] what the hull needs to either side of its centre, and below it; a choice, generous
PLACE = {"sway": "sway_m", "heave": "depth_m", "pitch": "pitch_rad", "yaw": "heading_rad"}  # axis -> channel


def room(axis: str, tank: Tank, points: Array) -> Array:
    """(Lowest, highest) place along an axis that the walls leave to each run, shape (N, 2) [m].

    points: the sonars' places at the start, shape (N, 1, 3) [m].
    """
    port, starboard, down = tank.ray(points, np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])).T
    if axis == "sway":
        return np.transpose([HALF_BREADTH_M - port, starboard - HALF_BREADTH_M])
    if axis == "heave":
        return np.transpose([SHALLOWEST_M + points[:, 0, 2], down - HALF_BREADTH_M])
    return np.tile([-np.inf, np.inf], (len(points), 1))


def place(plan: Plan, true: dict[str, Array]) -> Array:
    """Place along the excited axis, counted from the start [m or rad], beyond half a turn too."""
    axis = plan.scenario.excitation.axis
    start = plan.scenario.depth_m if axis == "heave" else 0.0
    return np.unwrap(true[PLACE[axis]]) if axis == "yaw" else true[PLACE[axis]] - start


def columns(plan: Plan, true: dict[str, Array]) -> dict[str, Array]:
    """What is recorded: thrust_N, held to the next tick, and position_m, as if the axis were surge.

    A turning axis is recorded as the force and the arc at 1 m from it. The axis's own sensor has the sonar's noise and
    resolution (a guess), with random numbers of its own.
    """
    sonar, where = plan.scenario.sonar, place(plan, true)
    reading = where + streams.normal(plan.seed, plan.run, streams.AXIS, sonar.noise_m, where.size)
    if sonar.resolution_m > 0.0:
        reading = np.floor(reading / sonar.resolution_m + 0.5) * sonar.resolution_m
    return {"thrust_N": true["thrust_N"], "position_m": reading}
