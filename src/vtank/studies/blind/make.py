"""`vtank blind make`: draw the cases, fly them in the tank, seal the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ...errors import InputError
from ...experiment import Result
from ...record import Run, current_versions, new_folder, refuse_loss, sha256
from ..processes import processes
from .case import KINDS, NOMINAL, Case, Frequencies, draw_frequencies
from .cause import RUNS
from .fly import Trip, fly_tank
from .held_out import HeldOut
from .seal import (
    INDEX,
    SEAL,
    SEAL_SCHEMA,
    Entry,
    as_written,
    case_name,
    commitment,
    digest,
    fixed_csv,
    index_bytes,
    json_bytes,
    level_times,
    new_salt,
)
from .sizing import ready_case
from .truth import truth_of

T = TypeVar("T")
Stage = Callable[[str, int], Callable[[str], None]]  # label and total -> to be called after each piece
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
    kinds: tuple[str, ...] = KINDS
    effects: tuple[str, ...] | None = None
    familiar: bool = False
    separations: bool = True
    threads: int = 2


@dataclass(frozen=True)
class Made:
    """A case that was flown: what it is, the attempt that gave it, and all its runs."""

    case: Case
    attempt: int
    results: tuple[Result, ...]


def make(order: Order, out: Path, truth_out: Path, stage: Stage = lambda label, total: lambda note: None) -> None:
    """Write the cases to `out` and the truths to `truth_out`, which appear whole or not at all."""
    for folder in (out, truth_out):
        refuse_loss(folder)
    cases_at, truth_at = out.resolve(), truth_out.resolve()
    if cases_at in (truth_at, *truth_at.parents) or truth_at in cases_at.parents:
        raise InputError(f"{truth_out}: expected a folder for the truth that lies apart from {out}")
    with processes(order.threads) as work:
        made = fly_all(order, work, stage)
        said = stage("what is true", order.trials)
        truths = [_tell(pair, said) for pair in work(partial(_truth, order.separations), made)]
    with ExitStack() as stack:
        cases, sealed = stack.enter_context(new_folder(out)), stack.enter_context(new_folder(truth_out))
        pairs = zip(made, truths, strict=True)
        entries = [_write(cases, sealed, number, one, *truth) for number, (one, truth) in enumerate(pairs, 1)]
        index = index_bytes(NOMINAL, entries)
        (cases / INDEX).write_bytes(index)
        seal = {"schema": SEAL_SCHEMA, "index": sha256(index), "seed": order.seed, "order": _plain(order),
                "versions": current_versions()}  # fmt: skip
        (sealed / SEAL).write_bytes(json_bytes(seal))
        level_times(cases)
        level_times(sealed)


def fly_all(order: Order, work: Callable[..., Iterator[Any]], stage: Stage) -> list[Made]:
    """All cases, flown; those that hit a wall in the tank are drawn anew."""
    frequencies = draw_frequencies(order.seed, order.kinds, order.effects)
    made: dict[int, Made] = {}
    first = dict.fromkeys(range(order.trials), 0)
    for _ in range(ROUNDS):
        missing = [number for number in first if number not in made]
        said = stage("drawing cases", len(missing))
        jobs = [(number, first[number]) for number in missing]
        drawn = [_tell(pair, said) for pair in work(partial(_ready, order, frequencies), jobs)]
        trips = [trip for case, _ in drawn for trip in trips_of(case)]
        results = _fly(trips, order.threads, stage)
        each = len(results) // len(drawn)
        for i, (number, (case, attempt)) in enumerate(zip(missing, drawn, strict=True)):
            mine = tuple(results[i * each : (i + 1) * each])
            if all(map(_sound, mine)):
                made[number] = Made(case, attempt, mine)
            first[number] = attempt + 1
        if len(made) == order.trials:
            return [made[number] for number in range(order.trials)]
    raise InputError(f"{order.trials - len(made)} cases hit a wall in every one of {ROUNDS} attempts")


def trips_of(case: Case) -> list[Trip]:
    """All runs of a case, held-out ones last."""
    plans = [case.plan(k) for k in range(len(case.experiment.scenarios))]
    return [Trip(plan, case.causes, case.experiment.sonar_memory_s) for plan in plans]


def _fly(trips: Sequence[Trip], threads: int, stage: Stage) -> list[Result]:
    said, shown = stage("flying, percent", 100), 0

    def report(share: float) -> None:
        nonlocal shown
        while shown < int(100.0 * share + 1e-9):
            shown += 1
            said("")

    return [_rounded(result) for result in fly_tank(trips, threads, report)]


def _rounded(result: Result) -> Result:
    """The run as a reader of its file gets it, and of what is true only what the truth needs."""
    run = result.run
    columns = {name: as_written(values, name) for name, values in run.columns.items()}
    true = {name: result.true[name] for name in ("position_m", "n_rev_s")}
    return replace(result, run=Run(run.name, np.round(run.time_s, 6), columns), true=true)


def _sound(result: Result) -> bool:
    try:
        result.check_clearance()
    except InputError:
        return False
    return all(np.isfinite(values).any() for values in result.run.columns.values())


def _ready(order: Order, frequencies: Frequencies, job: tuple[int, int]) -> tuple[Case, int]:
    return ready_case(order.seed, job[0], frequencies, order.familiar, job[1])


def _truth(separations: bool, made: Made) -> tuple[dict[str, Any], list[HeldOut]]:
    return truth_of(made.case, made.results, separations)


def _write(cases: Path, sealed: Path, number: int, made: Made, truth: dict[str, Any], kept: list[HeldOut]) -> Entry:
    name, hashes, held = case_name(number), dict[str, str](), dict[str, str]()
    (cases / name).mkdir()
    (sealed / "held_out" / name).mkdir(parents=True)
    for k, result in enumerate(made.results):
        given = k < RUNS
        file = f"run_{k + 1 if given else k - RUNS + 1}.csv"
        run = result.run if given else replace(result.run, columns=result.run.columns | kept[k - RUNS].sealed)
        data = fixed_csv(run)
        ((cases if given else sealed / "held_out") / name / file).write_bytes(data)
        (hashes if given else held)[file] = sha256(data)
    truth = truth | {"case": name, "data": digest(hashes), "held_out_files": held, "attempt": made.attempt}
    salt = new_salt()
    (sealed / f"{name}.json").write_bytes(json_bytes({"salt": salt, "truth": truth}))
    return Entry(name, hashes, made.case.withheld, commitment(salt, truth))


def _plain(order: Order) -> dict[str, Any]:
    return {key: list(value) if isinstance(value, tuple) else value for key, value in vars(order).items()}


def _tell(result: T, said: Callable[[str], None]) -> T:
    said("")
    return result
