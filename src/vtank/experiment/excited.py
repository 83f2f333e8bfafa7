"""The excited axis of some runs, where it is another than surge: orders to its thrusters, their effort, its record."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..tank.tank import Tank
from . import noise as streams
from .flight import orders
from .hold import AXES, NAMES
from .plan import Plan
from .scenario import SHALLOWEST_M

Array = NDArray[np.float64]
HALF_BREADTH_M = 0.3  # [m] what the hull needs to either side of its centre, and below it; a choice, generous
PLACE = {"sway": "sway_m", "heave": "depth_m", "pitch": "pitch_rad", "yaw": "heading_rad"}  # axis -> channel


class Excited:
    """Orders to one axis of N runs over K ticks.

    Attributes:
        row, wrench: which of the held axes it is; what each thruster makes along it at 1 N, shape (J,) [-] or [m].
        wanted: orders at the ticks, shape (N, K, 3), as those of `hold`.
        effort: what the thrusters made along the axis, shape (N, K) [N or N m].
        room: (lowest, highest) place along it that the walls leave to each run, shape (N, 2) [m].
    """

    def __init__(self, plans: Sequence[Plan], length: int, wrenches: Array) -> None:
        """wrenches: of the thrusters at 1 N, shape (J, 6)."""
        moved = NAMES.index(plans[0].scenario.excitation.axis)
        self.row, self.wrench = moved, wrenches[:, AXES[moved]].copy()
        self.wanted = np.array([orders(plan, length) for plan in plans])
        self.effort = np.zeros((len(plans), length))
        self.room = np.tile([-np.inf, np.inf], (len(plans), 1))

    def look_around(self, tank: Tank, points: Array) -> None:
        """Measure the room from the sonars' places at the start, shape (N, 1, 3) [m]."""
        port, starboard, down = tank.ray(points, np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])).T
        if NAMES[self.row] == "sway":
            self.room = np.transpose([HALF_BREADTH_M - port, starboard - HALF_BREADTH_M])
        elif NAMES[self.row] == "heave":
            self.room = np.transpose([SHALLOWEST_M + points[:, 0, 2], down - HALF_BREADTH_M])


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
