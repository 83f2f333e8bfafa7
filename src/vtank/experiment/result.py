"""What a simulation leaves: the run as it was recorded, and apart from it what was true."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..plant.law import SLOTS
from ..plant.parameters import NAMES
from ..record import Run
from .clearance import check_motion
from .excited import columns, place
from .flight import READING, SPEED, SPEED_READING, Flight
from .plan import Plan

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Result:
    """One simulated run.

    Attributes:
        run: what was recorded: n_rev_s by the tachometer, range_m by the sonar.
        plan: what was simulated.
        true: channel -> values at the ticks, shape (T,): position_m made good ahead, surge_m_s, n_rev_s, range_m,
            and on the tank the pose of the other axes, the water's velocity in waves, and where another axis than
            surge is excited, thrust_N: what the thrusters made along it [N or N m].
        room: lowest and highest place along an excited axis other than surge that walls, floor and surface leave [m].
    """

    run: Run
    plan: Plan
    true: dict[str, Array]
    room: tuple[float, float] = (-np.inf, np.inf)

    def check_clearance(self) -> None:
        """InputError where the motion ran away, or the vehicle struck a wall."""
        scenario, motion = self.plan.scenario, ("position_m", "surge_m_s")
        moves = np.all([np.isfinite(values) for name, values in self.true.items() if name in motion], axis=0)
        if not moves.all():
            last = f"the motion diverged after {self.run.time_s[max(int(np.argmin(moves)) - 1, 0)]:g} s"
            why = "its parameters or inputs are out of range"
            raise InputError(f"{scenario.path}: run {self.plan.name}: {last}; {why}")
        check_motion(scenario, self.true["position_m"])
        if scenario.excitation.axis != "surge":
            where, (low, high) = place(self.plan, self.true), self.room
            if where.min() < low or where.max() > high:
                found = f"moved {where.min():+.2f} to {where.max():+.2f}, room is {low:+.2f} to {high:+.2f} m"
                raise InputError(f"{scenario.path}: excitation: the simulated {scenario.excitation.axis} {found}")

    def truth(self, channels: bool = True) -> dict[str, Any]:
        """All that a reader of the run must not know, for the truth file; `channels` adds the true motion."""
        plan = self.plan
        nominal = dict(zip(NAMES, plan.truth.vector(), strict=True)) | {"standoff": plan.parameters["standoff"]}
        truth: dict[str, Any] = {
            "run": plan.name,
            "scenario": plan.scenario.name,
            "truth": plan.truth.name,
            "seed": plan.seed,
            "run_number": plan.run,
            "parameters": {
                name: value
                for name, value in plan.parameters.items()
                if np.isfinite(value) and (value or name not in SLOTS)
            },
            "effects": {name: value for name, value in plan.parameters.items() if value != nominal[name]},
            "noise": {
                "sonar_m": plan.scenario.sonar.noise_m,
                "resolution_m": plan.scenario.sonar.resolution_m,
                "tachometer_rev_s": plan.scenario.tachometer.noise_rev_s,
                "turbulence_m_s2": plan.scenario.turbulence.acceleration_m_s2,
            },
        }
        return truth | ({"true": {name: np.round(values, 9) for name, values in self.true.items()}} if channels else {})


def result(
    plan: Plan, flight: Flight, i: int, true: dict[str, Array], room: tuple[float, float] = (-np.inf, np.inf)
) -> Result:
    """The result of run i; `true` holds what only the plant knows, over at least the ticks of the record."""
    time = plan.scenario.time_s
    record, length = flight.record[i], time.size
    known = {"n_rev_s": record[SPEED], "range_m": flight.history[i, 0]} | true
    known = {name: values[:length].copy() for name, values in known.items()}
    if plan.scenario.excitation.axis == "surge":
        recorded = {"n_rev_s": record[SPEED_READING, :length].copy(), "range_m": record[READING, :length].copy()}
    else:
        recorded = columns(plan, known)
    return Result(Run(plan.name, time, recorded), plan, known, room)
