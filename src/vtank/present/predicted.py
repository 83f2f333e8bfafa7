"""How well simulators predict a run, as a table: a row for each thing that was measured."""

from __future__ import annotations

import math
from typing import Any

from ..diagnose.holdout import DIVERGED
from ..record.columns import column
from .blocks import Table
from .words import WORDS, length, number

CALLED = WORDS["called"] | {"noise": "noise"}  # simulators, and what sensors add
DEGREES = {"rad": "°", "rad/s": "°/s"}


def predicted(found: dict[str, Any], run: str) -> Table:
    """The table of what `vtank.predict` returns, of one axis or of a whole vehicle."""
    if "columns" in found:
        rows = [_row(channel(name), sizes, unit_of(name)) for name, sizes in found["columns"].items()]
    else:
        what = "position" if found["unit"] == "m" else "speed"
        rows = [_row(what, found["rms"] | {"noise": found["floor"]}, found["unit"])]
    return Table((f"error on {run}", *CALLED.values()), tuple(rows), ("Root mean square of measured less simulated.",))


def _row(name: str, sizes: dict[str, float], unit: str) -> tuple[str, ...]:
    return (name, *(_size(sizes.get(key), unit) for key in CALLED))


def _size(value: float | None, unit: str) -> str:
    """An error with its unit, angles in degrees; a dash where it is not known."""
    if value is None or not math.isfinite(value):
        return "-"
    if value >= DIVERGED:
        return "runs away"
    if unit in DEGREES:
        return f"{number(math.degrees(value))}{'' if unit == 'rad' else ' '}{DEGREES[unit]}"
    return length(value, unit)


def size(value: float, name: str) -> str:
    """An error of a column, by the column's name."""
    return _size(value, unit_of(name))


def unit_of(name: str) -> str:
    """The unit of a column, by its name."""
    known = column(name)
    return known.unit if known else ""


def channel(name: str) -> str:
    """A column in words, with its instrument: `dvl.surge_m_s` is surge, dvl."""
    instrument, _, kind = name.rpartition(".")
    said = str(WORDS["channel"].get(kind, kind))
    return f"{said}, {instrument}" if instrument else said
