"""Runs on the surge model: one axis, the same pilot, thousands of runs per second."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from ..compiled import law
from ..errors import InputError
from ..plant.surge import CURRENT, STANDOFF, SURGE
from .flight import RANGE, RANGE_RATE, Flight, moves, prepare, ticks
from .noise import TURBULENCE
from .plan import Plan
from .result import Result, result
from .tick import acting_speed, stamp, switch_time, tick

Array = NDArray[np.float64]
advance, fades = SURGE.laws["advance"], SURGE.laws["fades"]
STEP_S = 0.05  # [s] longest step: errors up to 4e-7 m in 120 s (tests/test_simulate_surge.py)
CHUNK = 256  # runs prepared together, for memory; the results do not depend on it
POSITION, SPEED = range(2)


@law
def drive(f: Flight, i: int, k: int, steps: int, state: Array) -> None:
    """Advance run i from tick k to tick k + 1; state is (x, u, z, wake), in place."""
    h, t = f.setting[i].period_s, k * f.setting[i].period_s
    switch = switch_time(f, i)
    p, drift, gain = f.p[i], f.p[i, CURRENT], 0.0
    if f.water.shape[2] > 0:
        gain = (f.water[i, 0, k + 1] - f.water[i, 0, k]) / h
    s = state[0], state[1], state[2], state[3]
    for start, end in ((0.0, switch), (switch, h)):
        if end > start:
            n = acting_speed(f, i, t + 0.5 * (start + end))
            count = int(np.ceil((end - start) / h * steps))
            step = (end - start) / count
            fade = fades(step, p)
            for j in range(count):
                if f.water.shape[2] > 0:  # waves: the water's mean velocity over the step, and its acceleration
                    p[CURRENT] = drift + f.water[i, 0, k] + gain * (start + (j + 0.5) * step)
                disturbance = f.noise[i, TURBULENCE, k] + gain
                s = advance(t + start + j * step, step, s, (n,), (disturbance,), fade, p)
    p[CURRENT] = drift
    state[0], state[1], state[2], state[3] = s


@law
def fly(f: Flight, i: int, steps: int, motion: Array) -> None:
    """Run i from rest, `steps` steps of the surge model to a tick; fills motion (2, K): position [m], speed [m/s]."""
    state = np.zeros(4)
    for k in range(motion.shape[1]):
        motion[POSITION, k] = state[0]
        motion[SPEED, k] = state[1]
        f.history[i, RANGE, k] = f.p[i, STANDOFF] - state[0]
        f.history[i, RANGE_RATE, k] = -state[1]
        tick(f, i, k)
        drive(f, i, k, steps, state)


def simulate_surge(
    plans: Sequence[Plan],
    nthread: int = 1,
    progress: Callable[[float], None] | None = None,
    step_s: float = STEP_S,
) -> list[Result]:
    """Results in the order of the plans; the same on any number of threads and in any company.

    progress: called now and then with the share of the work that is done, 0 to 1.
    """
    for plan in plans:
        if plan.scenario.excitation.axis != "surge":
            axis = plan.scenario.excitation.axis
            raise InputError(f"{plan.scenario.path}: excitation.axis: the surge model has no {axis}; use the tank")
    chunks = [plans[start : start + CHUNK] for start in range(0, len(plans), CHUNK)]

    results: list[Result] = []
    with ThreadPoolExecutor(nthread) as pool:
        for some in pool.map(lambda chunk: _chunk(chunk, step_s), chunks):
            results += some
            if progress is not None:
                progress(len(results) / len(plans))
    return results


def _chunk(plans: Sequence[Plan], step_s: float) -> list[Result]:
    flight = prepare(plans)
    results = []
    for i, plan in enumerate(plans):
        motion = np.empty((2, ticks(plan)))
        steps = int(np.ceil(plan.scenario.period_s / step_s - 1e-9))
        fly(flight, i, steps, motion)
        stamp(flight, i, plan.scenario.samples)
        true = {"position_m": motion[POSITION], "surge_m_s": motion[SPEED]}
        results.append(result(plan, flight, i, true | ({"water_m_s": flight.water[i, 0]} if moves(plan) else {})))
    return results
