"""Memory stays as it is however long is flown; `make soak` flies a million seconds on the surge model."""

from __future__ import annotations

import gc
import os
import resource
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

from vtank.experiment import plan_run, simulate_surge, simulate_tank
from vtank.experiment.scenario import load_scenario

MORE = int(os.environ.get("VTANK_SOAK", "1"))  # times the length
GROWTH_MB = 8.0  # of a process of some 300 MB; a choice
RUN_S = 120.0
FLIGHTS = {"surge": (simulate_surge, 50_000.0), "tank": (simulate_tank, 2_500.0)}  # and seconds of a test


def resident_MB() -> float:
    """Memory of this process that is in use now."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1e6


def flown(model: str, runs: int) -> np.ndarray:
    """Memory after each of some runs [MB], shape (1 + runs,); the first is before them, compiled and used to runs."""
    simulate, scenario = FLIGHTS[model][0], load_scenario("paper-ds1", (f"duration_s={RUN_S:g}",))

    def fly(seed: int) -> float:
        (result,) = simulate([plan_run(scenario, seed=seed)])
        assert np.isfinite(result.run.columns["n_rev_s"]).all()
        return resident_MB()

    for seed in range(3):
        fly(seed)
    return np.array([resident_MB(), *(fly(seed) for seed in range(runs))])


@pytest.mark.slow
@pytest.mark.parametrize("model", FLIGHTS)
def test_memory_does_not_grow_with_the_seconds_flown(model: str) -> None:
    """In a process of its own: one that other tests have left with gigabytes grows by what it cannot use again."""
    runs = round(MORE * FLIGHTS[model][1] / RUN_S)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as alone:
        before, *used = alone.submit(flown, model, runs).result()
    print(f"{model}: {runs * RUN_S:.3g} s, {before:.1f} MB before, {used[-1]:.1f} MB after, {max(used):.1f} MB at most")
    assert max(used) - before < GROWTH_MB
