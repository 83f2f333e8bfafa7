"""Memory stays as it is however long is flown; `make soak` flies a million seconds on the surge model."""

from __future__ import annotations

import gc
import os
import resource
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


@pytest.mark.slow
@pytest.mark.parametrize("model", FLIGHTS)
def test_memory_does_not_grow_with_the_seconds_flown(model: str) -> None:
    simulate, length_s = FLIGHTS[model]
    scenario = load_scenario("paper-ds1", (f"duration_s={RUN_S:g}",))
    runs = round(MORE * length_s / RUN_S)

    def fly(seed: int) -> float:
        (result,) = simulate([plan_run(scenario, seed=seed)])
        assert np.isfinite(result.run.columns["n_rev_s"]).all()
        return resident_MB()

    for seed in range(3):  # compiled, and as large as a run needs
        fly(seed)
    before = resident_MB()
    used = np.array([fly(seed) for seed in range(runs)])
    print(
        f"{model}: {runs * RUN_S:.3g} s, {before:.1f} MB before, {used[-1]:.1f} MB after, {used.max():.1f} MB at most"
    )
    assert used.max() - before < GROWTH_MB
