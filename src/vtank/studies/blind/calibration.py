"""Calibration of stated probabilities: reliability without bins, and what miscalibration costs in Brier score.

The observed frequencies are those of isotonic regression of the outcomes on the stated probabilities, found by pooling
adjacent violators (PAV). Dimitriadis, Gneiting, Jordan, PNAS 118 (2021), e2016191118: the CORP approach;
Brier score = miscalibration - discrimination + uncertainty.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Corp:
    """Decomposition of the Brier score of n events; `expected` is the miscalibration that chance alone would show."""

    n: int
    brier: float
    miscalibration: float
    discrimination: float
    uncertainty: float
    expected: float


def pav(stated: Array, happened: Array) -> Array:
    """Isotonic regression of outcomes (0 or 1) on stated probabilities, at the events themselves, shape (n,)."""
    levels, place = np.unique(stated, return_inverse=True)
    count = np.bincount(place)
    return np.asarray(isotonic_regression(np.bincount(place, happened) / count, weights=count).x[place])


def corp(stated: Array, happened: Array, draws: int = 200, seed: int = 0) -> Corp:
    """CORP decomposition of the Brier score of stated probabilities, shape (n,), of events that happened or not."""
    brier, miscalibration = float(np.mean((stated - happened) ** 2)), _miscalibration(stated, happened)
    uncertainty = float(np.mean(happened) * (1.0 - np.mean(happened)))
    random = np.random.default_rng(seed)
    by_chance = [_miscalibration(stated, (random.random(stated.size) < stated).astype(float)) for _ in range(draws)]
    discrimination = uncertainty - (brier - miscalibration)
    return Corp(stated.size, brier, miscalibration, discrimination, uncertainty, float(np.mean(by_chance)))


def _miscalibration(stated: Array, happened: Array) -> float:
    return float(np.mean((stated - happened) ** 2) - np.mean((pav(stated, happened) - happened) ** 2))
