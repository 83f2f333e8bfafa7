"""What makes a run usable; the same rules for reading and for writing."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .columns import MOTION, channel_of, column, unknown
from .run import INPUTS, OUTPUTS, TIME, FloatArray, Run

SHORTEST = 10  # samples, the fewest that say anything about a motion; a choice
SLOWEST_S = 10.0  # [s] between rows: above, no surge motion is seen, and the times are ms; a choice
LONGEST = 300  # characters of a header as they stand in a message; a choice
PAUSE_S = 86400.0  # [s] in a recording, a day: the longest run that a scenario may ask for too; a choice

# Column -> least and greatest value that is believed, in its unit, and these in words. All are guesses, far beyond any
# vehicle: 12,000 rpm; no distance on Earth is longer than 4e7 m; the fastest torpedo makes 100 m/s; the propellers of
# the largest ships push with some MN; stamps that count from 1970 are 1.8e9 s today.
BELIEVED = {
    "command": (-1.0, 1.0, "a value in -1..1"),
    TIME: (-1e10, 1e10, "seconds within 1e10 either way"),
    "n_rev_s": (-200.0, 200.0, "rev/s within 200 either way; is it rpm?"),
    "thrust_N": (-1e8, 1e8, "newtons within 1e8 either way"),
    "range_m": (0.0, 1e8, "a distance of 0 or more and 1e8 m at most, or an empty cell"),
    "position_m": (-1e8, 1e8, "metres within 1e8 either way"),
    "surge_m_s": (-200.0, 200.0, "m/s within 200 either way"),
}
ANYTHING = (-1e12, 1e12, "a number within 1e12 either way")  # of columns that are not read


@dataclass(frozen=True)
class Fault:
    """What is wrong: in which row (None: in the header or the whole), found and expected."""

    row: int | None
    message: str


def header_fault(names: Sequence[str]) -> Fault | None:
    """The first rule that a header breaks; `names` are all columns, `time_s` among them."""
    listed = textwrap.shorten(", ".join(names), LONGEST, placeholder=" ...")
    if "" in names:
        return Fault(None, f"column {list(names).index('') + 1} has no name in the header ({listed})")
    twice = [name for name in names if list(names).count(name) > 1]
    if twice:
        return Fault(None, f"column {twice[0]} appears more than once, expected each name once")
    if TIME not in names:
        return Fault(None, f"no column {TIME}; found {listed}")
    inputs = [name for name in INPUTS if name in names]
    if not _one_axis(names) and (known := [name for name in names if _is_whole(name)]):
        strange = next((name for name in names if name not in (TIME, *INPUTS, *known) and column(name) is None), None)
        return Fault(None, unknown(strange)) if strange else None
    if len(inputs) != 1:
        found = f"the inputs {' and '.join(inputs)}" if inputs else f"no input among {listed}"
        return Fault(None, f"expected exactly one of {', '.join(INPUTS)}; found {found}")
    if not set(OUTPUTS) & set(names):
        return Fault(None, f"expected at least one of {', '.join(OUTPUTS)}; found {listed}")
    return None


def _is_whole(name: str) -> bool:
    """Whether only the recording of a whole vehicle has such a column."""
    return name not in (*INPUTS, *OUTPUTS) and column(name) is not None


def _one_axis(names: Iterable[str]) -> bool:
    """Whether it is a single-axis run, whatever other columns it has: these are not read."""
    return bool(set(INPUTS) & set(names) and set(OUTPUTS) & set(names))


def _believed(name: str, one_axis: bool) -> tuple[float, float, str]:
    """Least and greatest value that is believed in a column, and these in words."""
    channel = channel_of(name)
    if channel in BELIEVED:
        return BELIEVED[channel]
    if one_axis or (found := column(name)) is None:
        return ANYTHING
    degrees = "; are these degrees?" if found.unit.startswith("rad") else ""
    return -found.most, found.most, f"a number within {found.most:g} {found.unit} either way{degrees}"


def content_fault(run: Run) -> Fault | None:
    """The first rule that the values of a run break; its header is already known to be sound."""
    return next(_content_faults(run), None)


def _content_faults(run: Run) -> Iterator[Fault]:
    yield from _time_faults(run.time_s)
    for name, values in run.columns.items():
        if np.isnan(values).all():
            yield Fault(None, f"column {name} has no value in any row")
        for row in np.flatnonzero(np.isinf(values)).tolist():
            yield Fault(row, f"column {name}: found an infinite value, expected a number")
    yield from _unit_faults(run)
    outputs = run.outputs or [name for name in run.columns if channel_of(name) in MOTION] or list(run.columns)
    longest = max(int(np.sum(~np.isnan(run.columns[name]))) for name in outputs)
    if longest < SHORTEST:
        plural = "s" * (longest != 1)
        yield Fault(None, f"{longest} sample{plural} of {' or '.join(outputs)}, expected at least {SHORTEST}")


def _time_faults(time_s: FloatArray) -> Iterator[Fault]:
    for row in np.flatnonzero(~np.isfinite(time_s)).tolist():
        yield Fault(row, f"column {TIME}: the time is missing, expected a number in every row")
    for row in (np.flatnonzero(np.diff(time_s) <= 0.0) + 1).tolist():
        found = f"found {time_s[row]:.10g} after {time_s[row - 1]:.10g}"
        yield Fault(row, f"column {TIME}: {found}, expected strictly increasing times")


def _unit_faults(run: Run) -> Iterator[Fault]:
    """Values that only another unit, a mark for a lost echo or a broken cell can explain."""
    steps = np.diff(run.time_s)
    step_s = float(np.median(steps)) if steps.size else 0.0
    if step_s > SLOWEST_S:
        yield Fault(1, f"column {TIME}: rows {step_s:.4g} s apart, expected {SLOWEST_S:g} s at most; are they seconds?")
    if step_s and steps.max() > PAUSE_S:
        row, found = int(np.argmax(steps)) + 1, f"found {steps.max():.4g} s without a row"
        yield Fault(row, f"column {TIME}: {found}, expected {PAUSE_S:g} s at most; these are two recordings")
    one_axis = _one_axis(run.columns)
    for name, values in {TIME: run.time_s, **run.columns}.items():
        low, high, expected = _believed(name, one_axis)
        for row in np.flatnonzero((values < low) | (values > high)).tolist():
            yield Fault(row, f"column {name}: found {values[row]:.10g}, expected {expected}")
