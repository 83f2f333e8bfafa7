"""What the water costs, and what a second thread gains: ratios of sides that are timed in turns, as the tank's."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter, thread_time

import mujoco
import mujoco.batch
import numpy as np
import pytest

from vtank import water
from vtank.plant.vehicle import load_vehicle
from vtank.resources import models_dir
from vtank.water.body import of_vehicle
from vtank.waves import Waves

ROUNDS, STEPS, VEHICLES = 60, 400, 1000
COST_LIMIT, SPEEDUP_LIMIT = 1.10, 1.9
HULL = {"cross_flow": (-1.1, 1.1, 60.0, 120.0)}
SEA = Waves("regular", 0.1, 4.0)
SETS = {
    "added mass, drag, buoyancy, current": ({}, {}),
    "and cross-flow": (HULL, {}),
    "and a regular wave": (HULL, {"waves": SEA}),
}


def phoenix(hull: dict[str, object], sea: dict[str, object]) -> mujoco.MjModel:
    """The Phoenix adrift in a current."""
    spec = mujoco.MjSpec.from_file(str(models_dir() / "phoenix.xml"))
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    body = of_vehicle(load_vehicle("phoenix"), 9.80665)
    return water.add(spec, {"phoenix": water.Body(**{**vars(body), **hull})}, current_m_s=(0.1, 0.2, 0.0), **sea)


def round_of(batch: mujoco.batch.Batch, steps: int, clock: Callable[[], float]) -> float:
    """Time [s] of the same motion every round, turning in all axes."""
    batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE)
    batch.qvel[:] = 0.05 * np.random.default_rng(1).normal(size=batch.qvel.shape)
    begin = clock()
    batch.step(nstep=steps)
    return clock() - begin


def in_turns(batches: list[mujoco.batch.Batch], steps: int, rounds: int, clock: Callable[[], float]) -> np.ndarray:
    """Times [s], shape (rounds, batches, 2): in water, and as rigid bodies."""
    times = np.empty((rounds, len(batches), 2))
    for row in times:
        for batch, pair in zip(batches, row, strict=True):
            with water.forces():
                pair[0] = round_of(batch, steps, clock)
            pair[1] = round_of(batch, steps, clock)
    return times


@pytest.mark.parametrize("name", SETS)
def test_a_step_in_water_against_the_bare_step(name: str, note: Callable[..., None]) -> None:
    """RK4: at most 1.10, with cross-flow and waves too."""
    batch = mujoco.batch.Batch(phoenix(*SETS[name]), 8, nthread=1)
    times = in_turns([batch], STEPS, ROUNDS, thread_time)[:, 0]
    ratio = float(np.median(times[:, 0] / times[:, 1]))
    note(f"RK4 step, {name}", f"{ratio:.3f}", "bare step", f"{COST_LIMIT}")
    assert ratio <= COST_LIMIT


def test_a_thousand_vehicles_on_two_threads(note: Callable[..., None]) -> None:
    """At least 1.9 times one thread; open where the machine gives no second core to the bare model either."""
    model = phoenix(*SETS["and cross-flow"])
    one, two = (mujoco.batch.Batch(model, VEHICLES, nthread=nthread) for nthread in (1, 2))
    (wet_one, bare_one), (wet_two, bare_two) = in_turns([one, two], 50, 20, perf_counter).min(axis=0)
    assert one.state.tobytes() == two.state.tobytes()
    gain, bare = wet_one / wet_two, bare_one / bare_two
    note(f"{VEHICLES} vehicles, two threads", f"{gain:.2f}", f"bare {bare:.2f}", f"{SPEEDUP_LIMIT}")
    if gain < SPEEDUP_LIMIT and bare < SPEEDUP_LIMIT:
        pytest.skip(f"the machine gives no second core now: the bare model gains {bare:.2f} times")
    assert gain >= SPEEDUP_LIMIT
