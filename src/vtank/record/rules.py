"""What makes a run usable; the same rules for reading and for writing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .run import INPUTS, OUTPUTS, TIME, FloatArray, Run

SHORTEST = 10  # samples, the fewest that say anything about a motion; a choice
FASTEST_REV_S = 200.0  # [rev/s] above, 12,000 rpm, no propeller of a vehicle turns: the readings are rpm; a choice
SLOWEST_S = 10.0  # [s] between rows: above, no surge motion is seen, and the times are ms; a choice


@dataclass(frozen=True)
class Fault:
    """What is wrong: in which row (None: in the header or the whole), found and expected."""

    row: int | None
    message: str


def header_fault(names: Sequence[str]) -> Fault | None:
    """The first rule that a header breaks; `names` are all columns, `time_s` among them."""
    listed = ", ".join(names)
    if "" in names:
        return Fault(None, f"column {list(names).index('') + 1} has no name in the header ({listed})")
    twice = [name for name in names if list(names).count(name) > 1]
    if twice:
        return Fault(None, f"column {twice[0]} appears more than once, expected each name once")
    if TIME not in names:
        return Fault(None, f"no column {TIME}; found {listed}")
    inputs = [name for name in INPUTS if name in names]
    if len(inputs) != 1:
        found = f"the inputs {' and '.join(inputs)}" if inputs else f"no input among {listed}"
        return Fault(None, f"expected exactly one of {', '.join(INPUTS)}; found {found}")
    if not set(OUTPUTS) & set(names):
        return Fault(None, f"expected at least one of {', '.join(OUTPUTS)}; found {listed}")
    return None


def content_fault(run: Run) -> Fault | None:
    """The first rule that the values of a run break; its header is already known to be sound."""
    return next(_content_faults(run), None)


def _content_faults(run: Run) -> Iterator[Fault]:
    yield from _time_faults(run.time_s)
    for name, values in run.columns.items():
        if np.isnan(values).all():
            yield Fault(None, f"column {name} has no value in any row")
        if np.isinf(values).any():
            yield Fault(int(np.argmax(np.isinf(values))), f"column {name}: found an infinite value, expected a number")
    yield from _command_faults(run)
    yield from _unit_faults(run)
    longest = max(int(np.sum(~np.isnan(run.columns[name]))) for name in run.outputs)
    if longest < SHORTEST:
        yield Fault(None, f"{longest} samples of {' or '.join(run.outputs)}, expected at least {SHORTEST}")


def _time_faults(time_s: FloatArray) -> Iterator[Fault]:
    missing = ~np.isfinite(time_s)
    if missing.any():
        yield Fault(int(np.argmax(missing)), f"column {TIME}: the time is missing, expected a number in every row")
    falls = np.diff(time_s) <= 0.0
    if falls.any():
        row = int(np.argmax(falls)) + 1
        found = f"found {time_s[row]:.10g} after {time_s[row - 1]:.10g}"
        yield Fault(row, f"column {TIME}: {found}, expected strictly increasing times")


def _command_faults(run: Run) -> Iterator[Fault]:
    if "command" not in run.columns:
        return
    outside = np.abs(run.columns["command"]) > 1.0
    if outside.any():
        row = int(np.argmax(outside))
        yield Fault(row, f"column command: found {run.columns['command'][row]:.10g}, expected a value in -1..1")


def _unit_faults(run: Run) -> Iterator[Fault]:
    """Values that only another unit, or a mark for a lost echo, can explain."""
    step_s = float(np.median(np.diff(run.time_s))) if run.time_s.size > 1 else 0.0
    if step_s > SLOWEST_S:
        yield Fault(1, f"column {TIME}: rows {step_s:.4g} s apart, expected {SLOWEST_S:g} s at most; are they seconds?")
    if "n_rev_s" in run.columns:
        fast = np.abs(run.columns["n_rev_s"]) > FASTEST_REV_S
        if fast.any():
            row = int(np.argmax(fast))
            found = f"found {run.columns['n_rev_s'][row]:.10g}"
            yield Fault(row, f"column n_rev_s: {found}, expected rev/s within {FASTEST_REV_S:g} either way; is it rpm?")
    if "range_m" in run.columns:
        behind = run.columns["range_m"] < 0.0
        if behind.any():
            row = int(np.argmax(behind))
            found = f"found {run.columns['range_m'][row]:.10g}"
            yield Fault(row, f"column range_m: {found}, expected a distance of 0 or more, or an empty cell")
