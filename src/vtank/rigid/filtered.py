"""Noise, what a filter at a noise leaves of a run, and how work on several cores is shared out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FAR = 4.0  # deviations beyond which a measurement counts less and less; a choice
THREADS = 2  # that share simulations out; each is computed alike on any number


@dataclass(frozen=True)
class Noise:
    """White error of each column, (C,) [its unit squared], and the disturbance: (6,) [m/s2, rad/s2], memory [s]."""

    variance: Array
    sigma: Array
    memory_s: float = 2.0


@dataclass(frozen=True, eq=False)
class Filtered:
    """Of one run: innovations, variances, gains, and the variance that the state explains; (M,), (M, 18)."""

    innovation: Array
    variance: Array
    gain: Array
    explained: Array


def bent(z: Array) -> Array:
    """Residuals whose square is Huber's: deviations as they are up to FAR, beyond it growing as their root.

    A spike then tells of the instrument, and a model that is far off is still told from one that is farther.
    Huber, Ann. Math. Stat. 35 (1964).
    """
    size = np.abs(z)
    return np.asarray(np.where(size <= FAR, z, np.sign(z) * np.sqrt(FAR * (2.0 * size - FAR) * (size > FAR))))


def share(work: Sequence[Callable[[], Any]]) -> list[Any]:
    """Results of calls that numba runs without Python's lock, in their order."""
    if len(work) < 2:
        return [call() for call in work]
    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(lambda call: call(), work))
