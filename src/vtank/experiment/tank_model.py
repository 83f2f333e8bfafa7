"""Runs in the MuJoCo tank: all axes, N runs stepped together, the pilot on board of each."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compiled import law
from ..errors import InputError
from ..plant.vehicle import AXES
from ..tank.model import site, sonars
from ..tank.tank import Diverged, Tank
from ..tank.world import load_world
from .beam import TARGETS, aim, rotation
from .clearance import MARGIN_M, vehicle_at, vehicle_of, vehicle_path, walls_path
from .excited import room
from .flight import RANGE, RANGE_RATE, Flight, moves, orders, prepare, ticks
from .hold import AS_IT_WAS, NAMES, allocation, attitude, hold
from .hold import AXES as HELD
from .noise import TURBULENCE
from .plan import Plan
from .result import Result, result
from .tick import DELAY, acting_speed, stamp, switch_time, tick

Array = NDArray[np.float64]
CHUNK = 64  # runs stepped together, for memory and the processor's cache; the results do not depend on it
SONAR = {"pencil": 0, "sector": -1}  # which of the vehicle's sonars: the first or the last
CHANNELS = ("position_m", "surge_m_s", "sway_m", "depth_m", "roll_rad", "pitch_rad", "heading_rad")
WATER = ("water_m_s", "water_up_m_s")


def simulate_tank(
    plans: Sequence[Plan],
    nthread: int = 1,
    progress: Callable[[float], None] | None = None,
    batch: type[Chunk] | None = None,
) -> list[Result]:
    """Results in the order of the plans; the same on any number of threads and in any company.

    progress: called now and then with the share of the work that is done, 0 to 1. batch: flies some plans together.
    """
    results: dict[int, Result] = {}
    total = sum(map(ticks, plans))
    done = 0

    def report(piece: int) -> None:
        nonlocal done
        done += piece
        if progress is not None:
            progress(done / total)

    for chosen in chunks(plans):
        chunk = (batch or Chunk)([plans[i] for i in chosen], nthread)
        results.update(zip(chosen, chunk.run(report), strict=True))
    return [results[i] for i in range(len(plans))]


def chunks(plans: Sequence[Plan]) -> Iterator[list[int]]:
    """Numbers of the plans that are stepped together: alike in what all simulations of a batch must share."""
    groups: dict[tuple[object, ...], list[int]] = {}
    for i, plan in enumerate(plans):
        s = plan.scenario
        files, axis = (s.vehicle, s.walls), s.excitation.axis
        late = plan.p[DELAY] > 0.0  # delayed commands are stepped more finely, which the others need not be
        alike = (ticks(plan), s.period_s, s.hold, s.sonar.beam, s.sonar.width_deg, files, axis, late)
        groups.setdefault(alike, []).append(i)
    for group in groups.values():
        for start in range(0, len(group), CHUNK):
            yield group[start : start + CHUNK]


@functools.cache
def world(vehicle: Path, walls: Path, period_s: float) -> Any:
    """The MuJoCo model that is flown, by the files' paths, without what is there for the eye."""
    return load_world(vehicle_at(vehicle), walls, period_s, look=False)


class Chunk:
    """Some runs in one batch of the tank."""

    def __init__(self, plans: Sequence[Plan], nthread: int) -> None:
        self.plans, self.flight = plans, prepare(plans)
        scenario, axis = plans[0].scenario, plans[0].scenario.excitation.axis
        held = [other for other in AXES if other != axis] if scenario.hold == "rigid" else []
        model = world(vehicle_path(scenario.vehicle), walls_path(scenario), scenario.period_s)
        self.tank = Tank(model, vehicle_of(scenario.vehicle), self.flight.p, nthread, held)
        self.steps = round(scenario.period_s / self.tank.model.opt.timestep)
        delayed = any(switch_time(self.flight, i) > 0.0 for i in range(len(plans)))
        self.parts = self.steps if delayed else 1  # of a tick, each with a propeller speed of its own
        self.fan, self.half = scenario.sonar.beam == "sector", math.radians(scenario.sonar.width_deg) / 2.0
        self.points = np.zeros((len(plans), 1, 3))
        self.directions = np.zeros((len(plans), TARGETS if self.half > 0.0 else 1, 3))
        length = self.flight.history.shape[2]
        self.true = np.empty((len(plans), len(CHANNELS), length))
        self.orders, self.effort = np.tile(AS_IT_WAS, (len(plans), 4, 1)), np.zeros((len(plans), length))
        moved = [NAMES.index(axis)] if axis in NAMES else []  # of the held axes
        self.wanted = {row: np.array([orders(plan, length) for plan in plans]) for row in moved}
        self._place(scenario.sonar.beam)
        self.room = room(axis, self.tank, self.points)
        self._hold(scenario.hold == "thrusters" or bool(moved))

    def _place(self, beam: str) -> None:
        """Put the vehicles at depth, and the tank around them so that the sonar is at stand-off from the wall ahead."""
        tank, model = self.tank, self.tank.model
        if not (names := sonars(model)):
            raise InputError(f"{tank.vehicle.mjcf}: no sonar: expected a site whose name begins with 'sonar'")
        self.sonar = site(model, names[SONAR[beam]])
        tank.qpos[:, 2] = [-plan.scenario.depth_m for plan in self.plans]
        standoff = np.array([plan.scenario.standoff_m for plan in self.plans])
        self.shift = np.zeros(len(self.plans))
        aim_all(tank.qpos, self.sonar, self.shift, self.fan, self.half, self.points, self.directions)
        ahead, down = tank.ray(self.points, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])).T
        self.shift = ahead - standoff
        for plan, water in zip(self.plans, down, strict=True):
            if not MARGIN_M <= water < np.inf:
                raise InputError(f"{plan.scenario.path}: depth_m: expected a depth above the tank's floor")
        tank.sonar_m[:], tank.wall_m[:] = self.sonar, self.points[:, 0, 0] + standoff

    def _hold(self, active: bool) -> None:
        """Gains and allocation of the controllers of the axes but surge."""
        vehicle = self.tank.vehicle
        self.inertia = np.diagonal(self.tank.mass)[list(HELD)].copy()
        self.wrenches = self.tank.wrenches
        self.allocation = allocation(self.wrenches)
        self.limit = np.array([thruster.limit_N for thruster in vehicle.steering])
        flown = [(plan.scenario, plan.scenario.control) for plan in self.plans]
        self.hold = np.array([(s.depth_m, c.hold_rad_s if active else 0.0, c.hold_damping) for s, c in flown])

    def run(self, report: Callable[[int], None]) -> list[Result]:
        """Fly all runs from rest to the end."""
        flight, tank = self.flight, self.tank
        with tank:
            for k in range(flight.history.shape[2]):
                self._tick(k)
                for j in range(self.parts):
                    act(flight, k, j, self.parts, tank.propeller_rev_s)
                    self._step(self.steps // self.parts)
                report(len(self.plans))
        return [self._result(i) for i in range(len(self.plans))]

    def _step(self, steps: int) -> None:
        try:
            self.tank.step(steps)
        except Diverged as lost:
            plan = self.plans[lost.number]
            raise InputError(f"{plan.scenario.path}: run {plan.name}: {lost}") from None

    def _tick(self, k: int) -> None:
        tank = self.tank
        aim_all(tank.qpos, self.sonar, self.shift, self.fan, self.half, self.points, self.directions)
        echoes = tank.ray(self.points, self.directions)
        on_board(self.flight, k, tank.qpos, tank.qvel, self.sonar, echoes, self.true)
        for row, wanted in self.wanted.items():
            self.orders[:, row] = wanted[:, k]
        hold(tank.qpos, tank.qvel, self.hold, self.inertia, self.allocation, self.limit, self.orders, tank.tunnel_N)
        for row in self.wanted:
            self.effort[:, k] = tank.tunnel_N @ self.wrenches[:, HELD[row]].copy()
        tank.disturbance_m_s2[:] = self.flight.noise[:, TURBULENCE, k]
        if (water := self.flight.water).shape[2]:  # linear from tick to tick: 1 mm of 0.3 m in waves of 2.5 s
            now, then = (np.insert(water[:, :, at], 1, 0.0, axis=1) for at in (k, k + 1))
            tank.set_water(now, (then - now) / self.plans[0].scenario.period_s)

    def _result(self, i: int) -> Result:
        plan, true = self.plans[i], dict(zip(CHANNELS, self.true[i], strict=True))
        stamp(self.flight, i, plan.scenario.samples)
        if moves(plan):
            true |= dict(zip(WATER, self.flight.water[i], strict=True))
        if self.wanted:
            true["thrust_N"] = self.effort[i]
        return result(plan, self.flight, i, true, (float(self.room[i, 0]), float(self.room[i, 1])))


@law
def aim_all(qpos: Array, sonar: Array, shift: Array, fan: bool, half: float, points: Array, directions: Array) -> None:
    """Fill the rays of N sonars: points (N, 1, 3) [m], shifted along x, and directions (N, R, 3)."""
    for i in range(qpos.shape[0]):
        a, b, c, d, e, f, g, h, j = rotation(qpos[i, 3:7])
        points[i, 0, 0] = qpos[i, 0] + a * sonar[0] + b * sonar[1] + c * sonar[2] + shift[i]
        points[i, 0, 1] = qpos[i, 1] + d * sonar[0] + e * sonar[1] + f * sonar[2]
        points[i, 0, 2] = qpos[i, 2] + g * sonar[0] + h * sonar[1] + j * sonar[2]
        aim(qpos[i, 3:7], fan, half, directions[i])


@law
def on_board(flight: Flight, k: int, qpos: Array, qvel: Array, sonar: Array, echoes: Array, true: Array) -> None:
    """Tick k of N runs: true range and motion into the history, then the pilot."""
    for i in range(qpos.shape[0]):
        a, b, c, d, e, f, g, h, j = rotation(qpos[i, 3:7])
        p, q, r = qvel[i, 3], qvel[i, 4], qvel[i, 5]
        sway, heave, yaw = q * sonar[2] - r * sonar[1], r * sonar[0] - p * sonar[2], p * sonar[1] - q * sonar[0]
        flight.history[i, RANGE, k] = echoes[i].min()
        flight.history[i, RANGE_RATE, k] = -(qvel[i, 0] + a * sway + b * heave + c * yaw)
        true[i, 0, k] = qpos[i, 0]
        true[i, 1, k] = a * qvel[i, 0] + d * qvel[i, 1] + g * qvel[i, 2]
        true[i, 2, k] = -qpos[i, 1]
        true[i, 3, k] = -qpos[i, 2]
        true[i, 4, k], true[i, 5, k], true[i, 6, k] = attitude(qpos[i, 3:7])
        tick(flight, i, k)


@law
def act(flight: Flight, k: int, j: int, steps: int, propeller_rev_s: Array) -> None:
    """Propeller speed of N runs over step j of `steps` in tick k: that of equal mean n|n| where it changes within."""
    for i in range(propeller_rev_s.size):
        h = flight.setting[i].period_s
        t, switch = k * h, switch_time(flight, i)
        share = min(max(switch / h * steps - j, 0.0), 1.0)
        after = acting_speed(flight, i, t + 0.5 * (switch + h)) if share < 1.0 else 0.0
        before = acting_speed(flight, i, t + 0.5 * switch) if share > 0.0 else 0.0
        if share == 0.0 or share == 1.0:
            propeller_rev_s[i] = before + after
        else:
            square = share * before * abs(before) + (1.0 - share) * after * abs(after)
            propeller_rev_s[i] = math.copysign(math.sqrt(abs(square)), square)
