"""How much the compiled callback costs, and how the batch scales with threads; both as ratios within one run.

The machine's speed wanders, so the two sides of a ratio are timed in turns and the best time of each counts.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

import mujoco
import numpy as np
import pytest

from vtank.dynamics.truth import load_truth
from vtank.dynamics.vehicle import load_vehicle
from vtank.tank import Tank, load_model

SIMULATIONS = 16
STEPS = 400
ROUNDS = 60  # some 5 s: longer than most bursts of load by other programs
OVERHEAD_LIMIT = 1.1
SPEEDUP_LIMIT = 1.7


def moving_tank(nthread: int = 1) -> Tank:
    """Vehicles under way, no two alike."""
    truths = np.tile(load_truth("paper-ii").vector(), (SIMULATIONS, 1))
    return Tank(load_model(), load_vehicle(), truths, nthread=nthread)


def start(tank: Tank) -> None:
    """The same motion every round: inputs set, turning in all axes."""
    tank.reset()
    tank.qvel[:] = 0.05 * np.random.default_rng(1).normal(size=tank.qvel.shape)
    tank.propeller_rev_s[:] = 10.0
    tank.tunnel_N[:] = 0.5


def seconds(tank: Tank, step: Callable[..., None]) -> float:
    """Time [s] of one round."""
    start(tank)
    begin = perf_counter()
    step(nstep=STEPS)
    return perf_counter() - begin


def compare(first: Callable[[], float], second: Callable[[], float]) -> tuple[float, float]:
    """Best time of each [s], timed in turns."""
    times = np.array([(first(), second()) for _ in range(ROUNDS)])
    return float(times[:, 0].min()), float(times[:, 1].min())


@pytest.mark.benchmark(group="tank")
def test_step_with_and_without_forces(benchmark) -> None:  # type: ignore[no-untyped-def]
    """The tank's steps, and in the same run those of the bare model: ratio at most 1.1."""
    tank = moving_tank()

    def with_forces() -> float:
        with tank:
            return seconds(tank, tank.batch.step)

    def bare() -> float:
        assert mujoco.get_mjcb_control() is None
        return seconds(tank, tank.batch.step)

    with_forces(), bare()
    loaded, empty = compare(with_forces, bare)
    benchmark.pedantic(with_forces, rounds=5)
    benchmark.extra_info["ratio to the bare model"] = round(loaded / empty, 3)
    steps = SIMULATIONS * STEPS
    print(f"\ntank {steps / loaded:,.0f} steps/s, bare {steps / empty:,.0f}: ratio {loaded / empty:.3f}")
    assert loaded / empty <= OVERHEAD_LIMIT


@pytest.mark.benchmark(group="tank")
def test_two_threads_against_one(benchmark) -> None:  # type: ignore[no-untyped-def]
    """The batch on two threads against one: at least 1.7 times the steps."""
    single, double = moving_tank(1), moving_tank(2)
    with single, double:
        one, two = compare(lambda: seconds(single, single.step), lambda: seconds(double, double.step))
        benchmark.pedantic(lambda: seconds(double, double.step), rounds=5)
    benchmark.extra_info["speed-up"] = round(one / two, 3)
    steps = SIMULATIONS * STEPS
    print(f"\none thread {steps / one:,.0f} steps/s, two {steps / two:,.0f}: {one / two:.2f} times")
    assert one / two >= SPEEDUP_LIMIT
