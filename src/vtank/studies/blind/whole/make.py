"""`vtank blind make --vehicles`: cases of whole vehicles, flown and sealed as those of one axis."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any

from ....errors import InputError
from ....record import Run, new_folder, refuse_loss, sha256
from ....record.writer import run_bytes
from ...processes import processes
from ...stage import Stage, silent
from ..seal import VEHICLES_SCHEMA, Entry, digest, finite, seal_truth, write_index
from .case import WholeCase, draw_whole

ROUNDS = 30  # times that a case which cannot be flown, or whose cause nobody could see, is drawn anew


def make_whole(trials: int, seed: int, out: Path, truth_out: Path, threads: int, stage: Stage = silent) -> None:
    """Write the cases to `out` and the truths to `truth_out`, which appear whole or not at all.

    The nominal of a case, in the index, is the name of its vehicle file.
    """
    for folder in (out, truth_out):
        refuse_loss(folder)
    cases_at, truth_at = out.resolve(), truth_out.resolve()
    if cases_at in (truth_at, *truth_at.parents) or truth_at in cases_at.parents:
        raise InputError(f"{truth_out}: expected a folder for the truth that lies apart from {out}")
    with new_folder(out) as cases, new_folder(truth_out) as sealed:
        entries = []
        with processes(threads) as work, stage("making cases", trials) as advance:
            for number, (case, attempt) in enumerate(work(partial(_made, seed), range(trials)), 1):
                entries.append(_write(cases, sealed, f"case_{number:04d}", case, attempt))
                advance("")
        write_index(cases, sealed, entries, {"trials": trials, "seed": seed, "vehicles": True})


def _made(seed: int, number: int) -> tuple[WholeCase, int]:
    for attempt in range(ROUNDS):
        case = draw_whole(seed, number, attempt)
        if case is not None and finite(dict(case.truth)):
            return case, attempt
    raise InputError(f"case {number}: nothing that can be flown and seen in {ROUNDS} attempts")


def _write(cases: Path, sealed: Path, name: str, case: WholeCase, attempt: int) -> Entry:
    hashes = _write_runs(cases / name, case.runs[: case.given])
    held = _write_runs(sealed / "held_out" / name, case.runs[case.given :])
    plain = _write_runs(sealed / "plain" / name, case.plain)
    truth: dict[str, Any] = {**case.truth, "schema": VEHICLES_SCHEMA, "case": name, "attempt": attempt,
                             "data": digest(hashes), "held_out_files": held, "plain_files": plain}  # fmt: skip
    return Entry(name, case.vehicle, hashes, (), seal_truth(sealed / f"{name}.json", truth))


def _write_runs(folder: Path, runs: Iterable[Run]) -> dict[str, str]:
    folder.mkdir(parents=True)
    contents = {f"run_{k}.csv": run_bytes(run) for k, run in enumerate(runs, 1)}
    for file, data in contents.items():
        (folder / file).write_bytes(data)
    return {file: sha256(data) for file, data in contents.items()}
