"""What acts of the inputs that thrusters and fins are given, and what force comes of it, under effects at places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...plant.actuators import Fin, Thruster
from .effect import Array, Placed


def acting(
    part: Thruster | Fin, effects: Sequence[Placed], asked: Mapping[str, Array], step_s: float, rows: slice
) -> Array:
    """Inputs that act on a thruster or fin at some steps, shape (n,), of what all are asked for at every step, (T,)."""
    mine = [placed for placed in effects if placed.place == part.name]
    column = next((p.values["column"] for p in mine if "column" in p.values), part.column)
    values = asked.get(column, np.zeros(len(next(iter(asked.values())))))
    delays = [placed.effect.delay(placed.values) for placed in mine if placed.effect.delay]
    values = delayed(values, sum(delays) / step_s, rows)
    for placed in mine:
        if placed.effect.input:
            values = placed.effect.input(values, placed.values)
    return values


def delayed(values: Array, steps: float, rows: slice) -> Array:
    """Held values, (T,), `steps` time steps later, at some rows; 0 before the first.

    Where a value changes within a step the step gets the mean of before and after, by time.
    """
    at = np.arange(rows.start, rows.stop) - int(np.floor(steps))
    share = steps - np.floor(steps)
    now, before = (np.where(row >= 0, values[np.maximum(row, 0)], 0.0) for row in (at, at - 1))
    return now if share == 0.0 else (1.0 - share) * now + share * before


def thrust(thruster: Thruster, effects: Sequence[Placed], time_s: Array, inputs: Array) -> Array:
    """Steady force of a thruster under inputs that act, shape (n,) [N]."""
    force = thruster.force_N(inputs)
    for placed in effects:
        if placed.effect.thrust and placed.place == thruster.name:
            force = placed.effect.thrust(time_s, inputs, force, placed.values)
    return force
