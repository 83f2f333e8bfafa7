"""Write a run as CSV: the same run gives the same bytes."""

from __future__ import annotations

from pathlib import Path

from ..errors import InputError
from .atomic import write_bytes
from .rules import content_fault, header_fault
from .run import TIME, FloatArray, Run

BLOCK = 10_000  # rows that are text at a time; a choice
DECIMALS = 6  # of every cell [1e-6 of the column's unit], far below any sensor's resolution; a choice


def write_run(path: Path | str, run: Run, decimals: int = DECIMALS) -> bytes:
    """Write a run, each cell rounded to `decimals` places; the bytes written. InputError if it breaks the rules."""
    data = run_bytes(run, decimals)
    write_bytes(path, data)
    return data


def run_bytes(run: Run, decimals: int = DECIMALS) -> bytes:
    """The CSV file of a run: `time_s` first, the columns in their order, empty cells for NaN, lines ended by LF."""
    fault = header_fault([TIME, *run.columns]) or content_fault(run)
    if fault:
        time = "" if fault.row is None else f" at row {fault.row}"
        raise InputError(f"run {run.name}{time}: {fault.message}")
    _refuse_merged_times(run, _cells(run.time_s, decimals))
    parts = [(",".join([TIME, *run.columns]) + "\n").encode()]
    for first in range(0, run.time_s.size, BLOCK):
        rows = slice(first, first + BLOCK)
        cells = [_cells(values[rows], decimals) for values in (run.time_s, *run.columns.values())]
        parts.append(("\n".join(map(",".join, zip(*cells, strict=True))) + "\n").encode())
    return b"".join(parts)


def _cells(values: FloatArray, decimals: int) -> list[str]:
    return [_cell(value, decimals) for value in values.tolist()]


def _cell(value: float, decimals: int) -> str:
    if value != value:
        return ""
    text = f"{value:.{decimals}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _refuse_merged_times(run: Run, times: list[str]) -> None:
    """Two samples closer than the decimals written would come back as one time."""
    for earlier, later in zip(times, times[1:], strict=False):
        if earlier == later:
            raise InputError(f"run {run.name}: two times are both written as {later} s; write more decimals")
