"""What drove a run: inputs of thrusters and angles of fins, from the stamps on at which they change."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..record.run import Run
from .layout import Layout

Array = NDArray[np.float64]
EVENTS_S = 0.2  # [s] from which on a log tells of inputs when they change alone, and not at instants; a guess
JUMP = 0.1  # of the widest range in its unit, by which an input jumps: no average goes across that; a choice


@dataclass(frozen=True, eq=False)
class Driven:
    """What drives a run: stamps of changes [s], (I,), inputs of thrusters, (I, K), and angles of fins [rad], (I, F).

    before: when those until then were told last [s], (I,). units: of inputs and angles, K + F.
    """

    stamps: Array
    inputs: Array
    angles: Array
    before: Array
    units: tuple[str, ...]

    @property
    def tick_s(self) -> float:
        """Time between inputs that are told of at instants [s], at most EVENTS_S; 0 where they never change."""
        return min(float(np.median((self.stamps - self.before)[1:])), EVENTS_S) if self.stamps.size > 1 else 0.0

    def told(self) -> tuple[Array, Array, Array]:
        """Stamps, inputs and angles with those told last before a change, (J,), (J, K), (J, F)."""
        again = np.flatnonzero(self.before[1:] > self.stamps[:-1])  # the next change is not at the next row
        rows = np.sort(np.r_[np.arange(self.stamps.size), again])
        stamps = self.stamps[rows]
        stamps[1:][rows[1:] == rows[:-1]] = self.before[again + 1]
        return stamps, self.inputs[rows], self.angles[rows]

    @cached_property
    def jumps(self) -> Array:
        """Stamps at which an input or angle changes by more than JUMP of the widest range in its unit [s].

        The range of one that hardly acts is its noise.
        """
        table, units = np.hstack((self.inputs, self.angles)), np.array(self.units)
        wide = np.ptp(table, axis=0)
        wide = np.array([wide[units == unit].max() for unit in units])
        far = np.abs(np.diff(table, axis=0)) > JUMP * wide
        return np.asarray(self.stamps[1:][far.any(axis=1)])


def driven(run: Run, layout: Layout) -> Driven:
    """Stamps at which any input changes, and all inputs and fin angles from there on; what has no column rests."""
    fins = [fin.column for fin in layout.vehicle.fins]
    columns = [push.column for push in layout.pushes] + fins
    has = [name for name in columns if name in run.columns]
    rows = np.any([~np.isnan(run.columns[name]) for name in has], axis=0) if has else np.zeros(run.time_s.size, bool)
    if not rows.any():
        raise InputError(f"run {run.name}: no value of {', '.join(columns)}; nothing drives the vehicle")
    table = np.zeros((int(rows.sum()), len(columns)))
    for i, name in enumerate(columns):
        if name in run.columns:
            values = run.columns[name][rows]
            last = np.maximum.accumulate(np.where(np.isnan(values), -1, np.arange(values.size)))
            table[:, i] = np.where(last < 0, 0.0, values[np.maximum(last, 0)])
    keep = np.flatnonzero(np.r_[True, np.any(np.diff(table, axis=0) != 0.0, axis=1)])
    split, stamps = len(layout.pushes), run.time_s[rows]
    inputs, angles = (np.ascontiguousarray(part) for part in (table[keep, :split], table[keep, split:]))
    units = (*(push.unit for push in layout.pushes), *("rad" for _ in fins))
    return Driven(stamps[keep], inputs, angles, stamps[np.maximum(keep - 1, 0)], units)
