"""Two folders that are made together: the cases, and their truths sealed."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...record import new_folder, refuse_loss
from ...record.files import resolved
from ..processes import processes
from ..stage import Stage
from .kept import T, Write, forget, kept
from .seal import INDEX, SEAL, ended, write_index


def make_sealed(
    out: Path, truth_out: Path, order: Mapping[str, Any], count: int, threads: int, made: Callable[[int], T],
    write: Write[T], stage: Stage, beside: Iterable[Path] = (),
) -> None:  # fmt: skip
    """Write the cases to `out` and the truths to `truth_out`, which appear whole or not at all.

    The truths first: a go that was killed between the two is ended by the next with the same order, and one that was
    interrupted before goes on with the cases that are kept. made: case of a number, write: its files, by both folders
    and its name; both in any process. beside: files that are copied to the cases.
    """
    if ended(out, truth_out, order):
        forget(truth_out)
        return
    if (out / INDEX).is_file() and (truth_out / SEAL).is_file():
        forget(truth_out)  # a go that was killed at the very end
    for folder in (out, truth_out):
        refuse_loss(folder)
    cases_at, truth_at = resolved(out), resolved(truth_out)
    if cases_at in (truth_at, *truth_at.parents) or truth_at in cases_at.parents:
        raise InputError(f"{truth_out}: expected a folder for the truth that lies apart from {out}")
    with new_folder(out) as cases, new_folder(truth_out) as sealed, kept(truth_out, order) as store:
        left = store.left(count)
        with processes(threads) as work, stage("making cases", len(left)) as advance:
            for _ in work(partial(store.keep, made, write), left):
                advance("")
        entries = [store.put(number, cases, sealed) for number in range(count)]
        for path in beside:
            shutil.copyfile(path, cases / path.name)
        write_index(cases, sealed, entries, order)
    forget(truth_out)
