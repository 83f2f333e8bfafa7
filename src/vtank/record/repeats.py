"""Readings that were written again, by a logger whose rows come faster than an instrument reads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
OFTEN = 0.2  # share of samples that repeat the one before, from which a logger makes them; a choice
EVENLY = 2.0  # times the mean length of stretches of one value, that of most that repeat; beyond, it rests; a choice
FINE = 4.0  # smallest steps of a column by which it usually moves: coarse readings are often alike; a choice
DUST = 1e-9  # of the largest value: what binary fractions add to a step


def smallest_step(values: Array) -> float:
    """Smallest step that values take [their unit]."""
    steps = np.diff(np.unique(values))
    steps = steps[steps > DUST * max(float(np.abs(values).max(initial=0.0)), 1e-12)]
    return float(steps.min()) if steps.size else DUST


def own_readings(values: Array) -> NDArray[np.bool_]:
    """Which samples, (K,), were read and not written again: all, but where repeats are many, even, and to the digit.

    What rests or is stuck repeats for long, what is coarse is often alike; of both every sample was read.
    """
    moves = np.diff(values, prepend=np.nan) != 0.0
    if values.size < 2 or np.mean(~moves) < OFTEN:
        return np.ones(values.size, dtype=bool)
    lengths = np.diff(np.append(np.flatnonzero(moves), values.size))
    each = np.repeat(lengths, lengths)
    usual = float(np.median(each[each > 1]))
    steps = np.abs(np.diff(values[moves]))
    fine = steps.size > 0 and float(np.median(steps)) > FINE * smallest_step(values)
    return moves if fine and usual <= EVENLY * values.size / lengths.size else np.ones(values.size, dtype=bool)
