"""Two folders that are made together: the cases, and their truths sealed."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from ...errors import InputError
from ...record import new_folder, refuse_loss
from ...record.files import resolved
from ..processes import processes
from ..stage import Stage
from .seal import Entry, ended, write_index

T = TypeVar("T")


def make_sealed(
    out: Path, truth_out: Path, order: Mapping[str, Any], count: int, threads: int, made: Callable[[int], T],
    write: Callable[[Path, Path, str, T], Entry], stage: Stage, beside: Iterable[Path] = (),
) -> None:  # fmt: skip
    """Write the cases to `out` and the truths to `truth_out`, which appear whole or not at all.

    The truths first: a go that was killed between the two is ended by the next with the same order. made: case of a
    number, in any process. write: its files, by both folders and its name. beside: files that are copied to the cases.
    """
    if ended(out, truth_out, order):
        return
    for folder in (out, truth_out):
        refuse_loss(folder)
    cases_at, truth_at = resolved(out), resolved(truth_out)
    if cases_at in (truth_at, *truth_at.parents) or truth_at in cases_at.parents:
        raise InputError(f"{truth_out}: expected a folder for the truth that lies apart from {out}")
    with new_folder(out) as cases, new_folder(truth_out) as sealed:
        entries = []
        with processes(threads) as work, stage("making cases", count) as advance:
            for number, case in enumerate(work(made, range(count)), 1):
                entries.append(write(cases, sealed, f"case_{number:04d}", case))
                advance("")
        for path in beside:
            shutil.copyfile(path, cases / path.name)
        write_index(cases, sealed, entries, order)
