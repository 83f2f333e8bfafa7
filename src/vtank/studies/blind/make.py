"""`vtank blind make`: draw the cases, fly them in the tank, seal the truth."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...experiment import Result, simulate_tank
from ...record import Run, new_folder, refuse_loss
from ..processes import processes
from ..stage import Shares, Stage, silent
from .case import KINDS, Case, Frequencies, draw_frequencies
from .fly import TripChunk
from .held_out import HeldOut
from .seal import Entry, as_written, digest, seal_truth, write_index, write_runs
from .sizing import ready_case
from .truth import truth_of
from .vehicles import FLEET

LEAST = 0.3  # [-] share of samples that a run must have
ROUNDS = 10  # times that cases which hit a wall in the tank are drawn anew


@dataclass(frozen=True)
class Order:
    """What is asked for.

    Attributes:
        trials, seed: number of cases and the seed of all that is drawn, which is to be kept secret.
        kinds, effects: what may come up.
        familiar: closed-loop sinusoids and white sonar noise only.
        separations: whether to fit every rival, which the ceiling and the leftovers need.
        threads: of the tank; also the number of processes.
    """

    trials: int
    seed: int
    kinds: tuple[str, ...] = tuple(KINDS)
    effects: tuple[str, ...] | None = None
    familiar: bool = False
    separations: bool = True
    threads: int = 2


Made = tuple[Case, int, list[Result]]  # a case that was flown, the attempt that gave it, and all its runs


def make(order: Order, out: Path, truth_out: Path, stage: Stage = silent, shares: Shares = silent) -> None:
    """Write the cases to `out` and the truths to `truth_out`, which appear whole or not at all."""
    for folder in (out, truth_out):
        refuse_loss(folder)
    cases_at, truth_at = out.resolve(), truth_out.resolve()
    if cases_at in (truth_at, *truth_at.parents) or truth_at in cases_at.parents:
        raise InputError(f"{truth_out}: expected a folder for the truth that lies apart from {out}")
    with processes(order.threads) as work:
        made = fly_all(order, work, stage, shares)
        cases, _, results = zip(*made, strict=True)
        found = work(partial(truth_of, separations=order.separations), cases, results)
        truths = _counted(found, stage, "what is true", order.trials)
    with new_folder(out) as cases_in, new_folder(truth_out) as sealed:
        pairs = zip(made, truths, strict=True)
        entries = [_write(cases_in, sealed, number, one, *truth) for number, (one, truth) in enumerate(pairs, 1)]
        for craft in FLEET.values():
            if (path := Path(craft.nominal)).is_file():
                shutil.copyfile(path, cases_in / path.name)
        write_index(cases_in, sealed, entries, vars(order))


def fly_all(order: Order, work: Callable[..., Iterator[Any]], stage: Stage, shares: Shares) -> list[Made]:
    """All cases, flown; those that hit a wall in the tank are drawn anew."""
    frequencies = draw_frequencies(order.seed, order.kinds, order.effects)
    made: dict[int, Made] = {}
    missing = dict.fromkeys(range(order.trials), 0)  # case -> attempt to begin with
    for _ in range(ROUNDS):
        numbers = list(missing)
        found = work(partial(_ready, order, frequencies), numbers, missing.values())
        drawn = _counted(found, stage, "drawing cases", len(numbers))
        plans = [case.plan(k) for case, _ in drawn for k in range(len(case.experiment.scenarios))]
        with shares("flying") as report:
            flown = map(_rounded, simulate_tank(plans, order.threads, report, TripChunk))
        for number, (case, attempt) in zip(numbers, drawn, strict=True):
            results = list(islice(flown, len(case.experiment.scenarios)))
            missing[number] = attempt + 1
            if all(map(_sound, results)):
                made[number] = case, attempt, results
                del missing[number]
        if not missing:
            return [made[number] for number in range(order.trials)]
    raise InputError(f"{len(missing)} cases hit a wall in every one of {ROUNDS} attempts")


def _counted(results: Iterator[Any], stage: Stage, label: str, total: int) -> list[Any]:
    """The results, each told as it comes."""
    found = []
    with stage(label, total) as advance:
        for result in results:
            found.append(result)
            advance("")
    return found


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


def _ready(order: Order, frequencies: Frequencies, number: int, first: int) -> tuple[Case, int]:
    return ready_case(order.seed, number, frequencies, order.familiar, first)


def _write(cases: Path, sealed: Path, number: int, made: Made, truth: dict[str, Any], kept: list[HeldOut]) -> Entry:
    (case, attempt, results), name = made, f"case_{number:04d}"
    hashes = write_runs(cases / name, [result.run for result in results[: case.experiment.given]])
    held = write_runs(sealed / "held_out" / name, [held.run for held in kept])
    truth = truth | {"case": name, "data": digest(hashes), "held_out_files": held, "attempt": attempt}
    return Entry(
        name, Path(FLEET[case.craft].nominal).name, hashes, case.withheld, seal_truth(sealed / f"{name}.json", truth)
    )
