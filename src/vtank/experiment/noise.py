"""Random streams of a run: one per source of noise, drawn before the run from the seed and the run's number.

Streams are independent (numpy's SeedSequence and Philox), so a source that is switched off or on leaves every other
stream as it was, and the order in which runs are simulated does not matter.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..compiled import law

Array = NDArray[np.float64]

# Stream numbers: part of what a seed means, never to be renumbered. Further sources take further numbers.
SONAR, DROPOUT, MULTIPATH, TACHOMETER, SPIKE, TURBULENCE = range(6)
STREAMS = 6  # of those above, with a number for every tick
WAVES, AXIS = 6, 7  # components of the sea; readings of another axis than surge


def stream(seed: int, run: int, source: int) -> np.random.Generator:
    """The random stream of one source of noise in one run."""
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(seed, spawn_key=(run, source))))


def normal(seed: int, run: int, source: int, deviation: float, size: int) -> Array:
    """White Gaussian noise of that standard deviation, shape (size,)."""
    return deviation * stream(seed, run, source).standard_normal(size) if deviation > 0.0 else np.zeros(size)


def uniform(seed: int, run: int, source: int, probability: float, size: int) -> Array:
    """Uniform numbers in [0, 1), shape (size,), which decide on events; ones where the event cannot happen."""
    return stream(seed, run, source).random(size) if probability > 0.0 else np.ones(size)


def turbulence(seed: int, run: int, deviation: float, time_s: float, period_s: float, size: int) -> Array:
    """Ornstein-Uhlenbeck process of that standard deviation and correlation time, exact at the ticks, shape (size,)."""
    if deviation == 0.0:
        return np.zeros(size)
    white = stream(seed, run, TURBULENCE).standard_normal(size)
    return deviation * ornstein_uhlenbeck(white, math.exp(-period_s / time_s))


@law
def ornstein_uhlenbeck(white: Array, correlation: float) -> Array:
    """Stationary process of unit variance with that correlation from tick to tick, from unit white noise."""
    process = np.empty_like(white)
    fresh = math.sqrt(1.0 - correlation * correlation)
    process[0] = white[0]
    for k in range(1, white.size):
        process[k] = correlation * process[k - 1] + fresh * white[k]
    return process
