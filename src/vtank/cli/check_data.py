"""`vtank check-data`: what a data set or a run holds."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..record import Run

HEADER = ("run", "channel", "", "samples", "rate_Hz", "from_s", "to_s", "min", "max")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `check-data DATASET`."""
    text = "read a data set or a run by the rules for recordings and list its channels"
    parser = subparsers.add_parser("check-data", help=text, description=text)
    parser.add_argument("dataset", type=Path, metavar="DATASET", help="folder of *.csv runs, or one run")


def run(args: argparse.Namespace) -> int:
    """Print a line for the data set and a table of all channels."""
    from ..record import read_dataset

    data = read_dataset(args.dataset)
    origin = "no manifest"
    if data.manifest:
        seed = "" if data.manifest.seed is None else f", seed {data.manifest.seed}"
        origin = f"written by vtank {data.manifest.versions.get('vtank', '?')}{seed}"
    print(f"{data.path}: {len(data)} run{'s' * (len(data) > 1)}, {origin}\n")
    rows = [HEADER, *(row for recording in data for row in _rows(recording))]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        left = [cell.ljust(width) for cell, width in zip(row[:3], widths, strict=False)]
        right = [cell.rjust(width) for cell, width in zip(row[3:], widths[3:], strict=True)]
        print("  ".join(left + right))
    return 0


def _rows(run: Run) -> list[tuple[str, ...]]:
    """One row of the table for each channel."""
    import numpy as np

    rows = []
    for name in run.columns:
        time, values = run.samples(name)
        rate = f"{1.0 / np.median(np.diff(time)):.4g}" if time.size > 1 else "-"
        numbers = (time[0], time[-1], values.min(), values.max())
        role = "input" if name == run.input else "output" if name in run.outputs else ""
        rows.append((run.name, name, role, str(time.size), rate, *(f"{number:.5g}" for number in numbers)))
    return rows
