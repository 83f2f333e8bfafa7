"""Noise, what a filter at a noise leaves of a run, and how work on several cores is shared out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FAR = 8.0  # deviations beyond which a measurement is left out of fits: a spike tells of the instrument alone; a choice
FEW = 0.05  # share of a column's measurements that may be spikes; a guess
THREADS = 2  # that share simulations out; each is computed alike on any number


@dataclass(frozen=True)
class Noise:
    """White error of each column, (C,) [its unit squared], and the disturbance: (6,) [m/s2, rad/s2], memory [s]."""

    variance: Array
    sigma: Array
    memory_s: float = 2.0


@dataclass(frozen=True, eq=False)
class Filtered:
    """Of one run: innovations, variances, gains, the variance that the state explains, and what is no spike.

    Shapes (M,), of the gains (M, 18).
    """

    innovation: Array
    variance: Array
    gain: Array
    explained: Array
    counts: NDArray[np.bool_]

    @classmethod
    def of(
        cls, column: NDArray[np.int64], innovation: Array, variance: Array, gain: Array, explained: Array
    ) -> Filtered:
        """What a filter left, with the spikes among it: far off, and few in their column."""
        counts = np.abs(innovation) < FAR * np.sqrt(variance)
        for c in np.unique(column[~counts]):
            mine = column == c
            if np.mean(~counts[mine]) > FEW:  # so many are no spikes: the model is far off
                counts |= mine
        return cls(innovation, variance, gain, explained, counts)


def share(work: Sequence[Callable[[], Any]]) -> list[Any]:
    """Results of calls that numba runs without Python's lock, in their order."""
    if len(work) < 2:
        return [call() for call in work]
    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(lambda call: call(), work))
