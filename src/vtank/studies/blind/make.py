"""`vtank blind make`: draw the cases, fly them in the tank, seal the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...experiment import Result, simulate_tank
from ...record import Run
from ..stage import Stage, silent
from .case import KINDS, Case, Frequencies, draw_frequencies
from .fly import TripChunk
from .seal import Entry, as_written, digest, finite, seal_truth, write_runs
from .sealing import make_sealed
from .sizing import ready_case
from .truth import truth_of
from .vehicles import FLEET

LEAST = 0.3  # [-] share of samples that a run must have
ROUNDS = 20  # times that a case which hits a wall in the tank is drawn anew


@dataclass(frozen=True)
class Order:
    """What is asked for.

    Attributes:
        trials, seed: number of cases and the seed of all that is drawn, which is to be kept secret.
        kinds, effects: what may come up.
        familiar: closed-loop sinusoids and white sonar noise only.
        separations: whether to fit every rival, which the ceiling and the leftovers need.
        threads: number of processes.
    """

    trials: int
    seed: int
    kinds: tuple[str, ...] = tuple(KINDS)
    effects: tuple[str, ...] | None = None
    familiar: bool = False
    separations: bool = True
    threads: int = 2


@dataclass(frozen=True)
class Made:
    """A case that was flown: its given and held-out runs, its truth, and what the index says of it."""

    runs: list[Run]
    held: list[Run]
    truth: dict[str, Any]
    nominal: str
    withheld: tuple[str, ...]


def make(order: Order, out: Path, truth_out: Path, stage: Stage = silent) -> None:
    """Write the cases to `out` and the truths to `truth_out`; as `make_sealed`."""
    frequencies = draw_frequencies(order.seed, order.kinds, order.effects)
    vehicles = {Path(craft.nominal) for craft in FLEET.values()}
    make_sealed(
        out, truth_out, order=vars(order), count=order.trials, threads=order.threads,
        made=partial(_made, order, frequencies), write=_write, stage=stage,
        beside=sorted(path for path in vehicles if path.is_file()),
    )  # fmt: skip


def _made(order: Order, frequencies: Frequencies, number: int) -> Made:
    """Case `number`, flown; one that hits a wall in the tank, or whose law or refit runs away, is drawn anew."""
    attempt = -1
    for _ in range(ROUNDS):
        case, attempt = ready_case(order.seed, number, frequencies, order.familiar, attempt + 1)
        results = _flown(case)
        if results is None:
            continue
        truth, held = truth_of(case, results, order.separations)
        if finite(truth):  # no model runs away on its runs
            given = [result.run for result in results[: case.experiment.given]]
            nominal = Path(FLEET[case.craft].nominal).name
            return Made(given, [h.run for h in held], truth | {"attempt": attempt}, nominal, case.withheld)
    raise InputError(f"case {number} hit a wall in every one of {ROUNDS} attempts")


def _flown(case: Case) -> list[Result] | None:
    """All runs of a case from the tank; None where one of them is no recording."""
    plans = [case.plan(k) for k in range(len(case.experiment.scenarios))]
    try:
        results = [_rounded(result) for result in simulate_tank(plans, batch=TripChunk)]
    except InputError:
        return None
    return results if all(map(_sound, results)) else None


def _rounded(result: Result) -> Result:
    """The run as a reader of its file gets it, and of what is true only what the truth needs."""
    run = result.run
    columns = {name: as_written(values, name) for name, values in run.columns.items()}
    true = {name: result.true[name] for name in ("position_m", "n_rev_s", "range_m")}
    return replace(result, run=Run(run.name, as_written(run.time_s, "time_s"), columns), true=true)


def _sound(result: Result) -> bool:
    try:
        result.check_clearance()
    except InputError:
        return False
    return all(np.isfinite(values).mean() > LEAST for values in result.run.columns.values())


def _write(cases: Path, sealed: Path, name: str, made: Made) -> Entry:
    hashes = write_runs(cases / name, made.runs)
    held = write_runs(sealed / "held_out" / name, made.held)
    truth = made.truth | {"case": name, "data": digest(hashes), "held_out_files": held}
    return Entry(name, made.nominal, hashes, made.withheld, seal_truth(sealed / f"{name}.json", truth))
