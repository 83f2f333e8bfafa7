"""`vtank blind make --vehicles`: cases of whole vehicles, flown and sealed as those of one axis."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from ....errors import InputError
from ....record.writer import run_bytes
from ...stage import Stage, silent
from ..seal import VEHICLES_SCHEMA, Entry, digest, finite, seal_truth, write_runs
from ..sealing import make_sealed
from .case import WholeCase, draw_whole

ROUNDS = 30  # times that a case which cannot be flown, or whose cause nobody could see, is drawn anew


def make_whole(trials: int, seed: int, out: Path, truth_out: Path, threads: int, stage: Stage = silent) -> None:
    """Write the cases to `out` and the truths to `truth_out`; as `make_sealed`.

    The nominal of a case, in the index, is the name of its vehicle file.
    """
    order = {"trials": trials, "seed": seed, "vehicles": True}
    make_sealed(
        out, truth_out, order=order, count=trials, threads=threads, made=partial(_made, seed), write=_write, stage=stage
    )


def _made(seed: int, number: int) -> tuple[WholeCase, int]:
    for attempt in range(ROUNDS):
        case = draw_whole(seed, number, attempt)
        if case is not None and finite(dict(case.truth)):
            return case, attempt
    raise InputError(f"case {number}: nothing that can be flown and seen in {ROUNDS} attempts")


def _write(cases: Path, sealed: Path, name: str, made: tuple[WholeCase, int]) -> Entry:
    case, attempt = made
    hashes = write_runs(cases / name, case.runs[: case.given], run_bytes)
    held = write_runs(sealed / "held_out" / name, case.runs[case.given :], run_bytes)
    plain = write_runs(sealed / "plain" / name, case.plain, run_bytes)
    truth: dict[str, Any] = {**case.truth, "schema": VEHICLES_SCHEMA, "case": name, "attempt": attempt,
                             "data": digest(hashes), "held_out_files": held, "plain_files": plain}  # fmt: skip
    return Entry(name, case.vehicle, hashes, (), seal_truth(sealed / f"{name}.json", truth))
