"""Short events: stretches of a few readings that are all off, as a sensor that stalls or stutters makes them.

They are looked for where the innovations lean to one side together, by their ranks and over their usual spread: heavy
tails alone, or an error that is somewhat coloured, make no event.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from ..outliers import spread

LENGTHS = (3, 4, 6, 8, 11, 16, 22, 32, 45, 64, 90, 128)  # [readings] of events, two to the octave; choices
MOST = 4  # events of a run that are looked at; a choice


@dataclass(frozen=True)
class Events:
    """Stretches of a run's readings, the most telling first.

    Attributes:
        inside: whether a reading belongs to each, shape (M, E).
        lean: how far the innovations lean together in each, in usual deviations, shape (E,).
        spans: first and last time of each [s].
        looked: number of stretches that were looked through.
    """

    inside: np.ndarray
    lean: np.ndarray
    spans: tuple[tuple[float, float], ...]
    looked: int


def events(time: np.ndarray, innovation: np.ndarray, longest_s: float) -> Events:
    """Events among innovations over their deviations at these times, shapes (M,); NaN where one does not count."""
    there = np.flatnonzero(np.isfinite(innovation))
    _, place, count = np.unique(innovation[there], return_inverse=True, return_counts=True)
    scores = ndtri((np.cumsum(count) - 0.5 * count)[place] / max(there.size, 1))  # of the middle of equal ranks
    total = np.concatenate([[0.0], np.cumsum(scores)])
    found, looked = [], 0
    for length in (n for n in LENGTHS if n < there.size // 4):
        lean = (total[length:] - total[:-length]) / np.sqrt(length)
        lean /= max(spread(lean), 1.0)
        brief = time[there[length - 1 :]] - time[there[: lean.size]] < longest_s
        looked += int(np.sum(brief))
        at = np.argsort(-np.abs(lean) * brief)[: MOST * length]
        found += [(float(lean[j]), int(j), length) for j in at if brief[j]]
    chosen: list[tuple[float, int, int]] = []
    for lean, j, length in sorted(found, key=lambda f: -abs(f[0])):
        if len(chosen) < MOST and all(j + length <= i or i + n <= j for _, i, n in chosen):
            chosen.append((lean, j, length))
    inside = np.zeros((time.size, len(chosen)))
    for e, (_, j, length) in enumerate(chosen):
        inside[there[j] : there[j + length - 1] + 1, e] = 1.0
    spans = tuple((float(time[there[j]]), float(time[there[j + n - 1]])) for _, j, n in chosen)
    return Events(inside, np.array([lean for lean, _, _ in chosen]), spans, looked)
