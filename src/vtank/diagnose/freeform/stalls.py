"""Readings that repeat themselves: a sensor, or the line to it, that has stalled.

A reading that comes again to the last digit tells nothing. How often it does so by chance the rest of the run shows:
noise on a fine scale makes no two readings alike, a coarse scale makes many, most where little moves.
"""

from __future__ import annotations

import numpy as np

from ..outliers import resolution

CHANCE = 0.01  # stretches expected by chance in a run up to which one is none; a choice
FEWEST = 2  # repetitions of a reading that are looked at

Span = tuple[int, int]


def stalls(values: np.ndarray, course: np.ndarray | None = None) -> list[Span]:
    """First and last reading of the stretches over which readings, shape (N,), repeat more than by chance.

    course: what they should be, shape (N,), where it is known: over less than two steps of the scale nothing moves.
    """
    same = np.diff(values) == 0.0
    edges = np.flatnonzero(np.diff(np.concatenate([[0], same, [0]])))
    out = []
    for first, last in edges.reshape(-1, 2).tolist():
        count = last - first
        usual = (np.sum(same) - count) / max(same.size - count, 1)
        moves = course is None or np.ptp(course[first : last + 1]) > 2.0 * resolution(values)
        if count >= FEWEST and same.size * usual**count < CHANCE and moves:
            out.append((first, last))
    return out


def bridged(values: np.ndarray, span: Span) -> np.ndarray:
    """Values, shape (N,), that go straight from the first of a stretch to the one after it; level at the end."""
    first, last = span
    out, after = values.copy(), min(last + 1, values.size - 1)
    end = values[after] if last < after else values[first]
    out[first : last + 1] = values[first] + (end - values[first]) * np.arange(last - first + 1) / (last + 1 - first)
    return out
