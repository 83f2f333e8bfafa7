"""What recordings hold, as a table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from ..record import INPUTS, Run, column
from .blocks import Table

HEADER = ("run", "channel", "", "samples", "rate_Hz", "from_s", "to_s", "min", "max")


def channels(runs: Iterable[Run]) -> Table:
    """One row for each channel of each run."""
    return Table(HEADER, tuple(row for run in runs for row in _rows(run)), left=3)


def _rows(run: Run) -> Iterator[tuple[str, ...]]:
    for name in run.columns:
        time, values = run.samples(name)
        known = column(name)
        rate = f"{1.0 / np.median(np.diff(time)):.4g}" if time.size > 1 else "-"
        numbers = (time[0], time[-1], values.min(), values.max())
        role = "input" if name in INPUTS else "output" if name in run.outputs else known.role if known else ""
        yield (run.name, name, role, str(time.size), rate, *(f"{number:.5g}" for number in numbers))
