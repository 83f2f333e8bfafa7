"""Families of sensor noise: how far a range is off, which pings are lost, and when a sample is stamped."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...experiment import noise as streams
from .cause import log_uniform

Array = NDArray[np.float64]
SHAPE, JITTER = 8, 9  # streams of random numbers, after those of vtank.experiment.noise
LOST = -1.0  # a draw below any share of lost pings
OUTLIERS, WIDER = 0.05, 6.0  # share of a contaminated noise, and how much wider it is


@dataclass(frozen=True)
class Noise:
    """Noise of the sonar.

    Attributes:
        family: one of FAMILIES.
        memory_s: correlation time of coloured noise, 0 for white [s].
        by_range, by_speed: relative growth of its deviation with the distance from the stand-off [1/m] and speed [s/m].
        lost: share of pings that is lost in blocks [-].
        beyond_m: pings from further away than the stand-off by so much are lost [m].
        jitter: largest error of a time stamp, in ticks [-].
    """

    family: str
    memory_s: float = 0.0
    by_range: float = 0.0
    by_speed: float = 0.0
    lost: float = 0.0
    beyond_m: float = math.inf
    jitter: float = 0.0

    def growth(self, away_m: Any, speed_m_s: Any) -> Any:
        """Factor on the deviation, away_m beyond the stand-off at that speed, shape as given."""
        return np.maximum(1.0 + self.by_range * away_m, 0.2) + self.by_speed * np.abs(speed_m_s)

    def unit(self, random: np.random.Generator, size: int, period_s: float) -> Array:
        """Noise of unit deviation, shape (size,)."""
        if self.memory_s > 0.0:
            return streams.ornstein_uhlenbeck(random.standard_normal(size), math.exp(-period_s / self.memory_s))
        return UNIT.get(self.family, UNIT["white"])(random, size)

    def blocks(self, random: np.random.Generator, size: int, period_s: float) -> Array:
        """Which pings are lost in blocks of 0.5 to 5 s, shape (size,) of bool."""
        gone = np.zeros(size, bool)
        while self.lost > 0.0 and gone.mean() < self.lost:
            start, length = random.integers(size), round(random.uniform(0.5, 5.0) / period_s)
            gone[start : start + length] = True
        return gone


def contaminated(random: np.random.Generator, size: int) -> Array:
    """Mostly narrow, now and then wide."""
    wide = np.where(random.random(size) < OUTLIERS, WIDER, 1.0)
    return wide * random.standard_normal(size) / math.sqrt(1.0 + OUTLIERS * (WIDER**2 - 1.0))


UNIT: dict[str, Callable[[np.random.Generator, int], Array]] = {
    "white": lambda random, size: random.standard_normal(size),
    "t3": lambda random, size: random.standard_t(3.0, size) / math.sqrt(3.0),
    "laplace": lambda random, size: random.laplace(0.0, math.sqrt(0.5), size),
    "contaminated": contaminated,
}
# Families with their share, and what makes them; resolution and lost pings at random are the sonar's own; choices
FAMILIES: dict[str, tuple[float, Callable[[np.random.Generator], dict[str, float]]]] = {
    "white": (0.2, lambda random: {}),
    "coloured": (0.12, lambda random: {"memory_s": 0.5 if random.random() < 0.4 else log_uniform(random, 0.15, 2.0)}),
    "t3": (0.08, lambda random: {}),
    "laplace": (0.08, lambda random: {}),
    "contaminated": (0.08, lambda random: {}),
    "coarse": (0.08, lambda random: {}),
    "missing_random": (0.06, lambda random: {}),
    "missing_blocks": (0.06, lambda random: {"lost": 0.3}),
    "missing_far": (0.05, lambda random: {"beyond_m": random.uniform(0.0, 0.12)}),
    "jitter": (0.07, lambda random: {"jitter": random.uniform(0.1, 0.4)}),
    "by_range": (0.06, lambda random: {"by_range": random.uniform(0.8, 2.0)}),
    "by_speed": (0.06, lambda random: {"by_speed": random.uniform(3.0, 12.0)}),
}


def draw_noise(random: np.random.Generator, familiar: bool = False) -> Noise:
    """A family and what makes it; familiar: white."""
    shares = [share for share, _ in FAMILIES.values()]
    family = str(random.choice(list(FAMILIES), p=shares)) if not familiar else "white"
    return Noise(family, **FAMILIES[family][1](random))
