"""Scenarios flown from their names to a data set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal

from ..record import write_dataset
from .plan import Plan, plan_run
from .result import Result
from .scenario import load_scenario
from .surge_model import simulate_surge
from .written import provenance

Simulator = Literal["tank", "surge"]


def plan_all(
    scenarios: Sequence[str | Path], settings: Sequence[str] = (), seed: int | None = None, truth: str | None = None
) -> list[Plan]:
    """One plan for each scenario, in order, all with one seed; a scenario given twice makes two different runs.

    settings: KEY=VALUE, overrides of all scenarios. seed: by default the first scenario's; truth: each scenario's.
    """
    loaded = [load_scenario(name, settings) for name in scenarios]
    seed = loaded[0].seed if seed is None else seed
    names = _names([scenario.name for scenario in loaded])
    pairs = zip(loaded, names, strict=True)
    return [plan_run(scenario, i, seed, truth, name) for i, (scenario, name) in enumerate(pairs)]


def fly(
    plans: Sequence[Plan],
    simulator: Simulator = "tank",
    threads: int = 1,
    progress: Callable[[float], None] | None = None,
) -> list[Result]:
    """Results of all plans, in order, on the MuJoCo tank or on the surge equation alone.

    threads do not change the results; progress is told the share that is done, 0 to 1. InputError where the vehicle
    struck a wall.
    """
    if simulator == "tank":
        from .tank_model import simulate_tank  # MuJoCo takes a while to load

        results = simulate_tank(plans, threads, progress)
    else:
        results = simulate_surge(plans, threads, progress)
    for result in results:
        result.check_clearance()
    return results


def write_results(
    out: Path | str, results: Sequence[Result], simulator: Simulator = "tank", settings: Sequence[str] = ()
) -> None:
    """Write the recordings as a data set with the truth in a file of its own; InputError for an unfit folder."""
    write_dataset(out, [result.run for result in results], *provenance(results, simulator, settings))


def _names(names: list[str]) -> list[str]:
    """The names, numbered where one appears more than once."""
    numbers = [names[: i + 1].count(name) for i, name in enumerate(names)]
    pairs = zip(names, numbers, strict=True)
    return [f"{name}-{number}" if names.count(name) > 1 else name for name, number in pairs]
