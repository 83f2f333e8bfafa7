"""Measures of a set of answers, each with the number of cases behind it and a 95 % interval."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom

Z = 1.959964  # of a two-sided 95 % interval


@dataclass(frozen=True)
class Measure:
    """A value, the number of cases behind it, and its 95 % interval; NaN where there is no case."""

    value: float
    n: int
    low: float
    high: float

    def text(self, digits: int = 3) -> str:
        """As in a table: value [low, high], n."""
        if self.n == 0:
            return "-"
        if math.isnan(self.low):
            return f"{self.value:.4f} ({self.n})"
        return f"{self.value:.{digits}f} [{self.low:.{digits}f}, {self.high:.{digits}f}] ({self.n})"

    def brief(self, digits: int = 2) -> str:
        """As in a wide table: value (n)."""
        return f"{self.value:.{digits}f} ({self.n})" if self.n else "-"


NOTHING = Measure(math.nan, 0, math.nan, math.nan)


def share(hits: Sequence[bool]) -> Measure:
    """A proportion, with the interval of Wilson, JASA 22 (1927)."""
    n = len(hits)
    if n == 0:
        return NOTHING
    p = sum(hits) / n
    middle = (p + Z * Z / (2 * n)) / (1 + Z * Z / n)
    half = Z / (1 + Z * Z / n) * math.sqrt(p * (1 - p) / n + Z * Z / (4 * n * n))
    return Measure(p, n, max(middle - half, 0.0), min(middle + half, 1.0))


def quantile(values: Sequence[float], q: float) -> Measure:
    """A quantile, with the interval between order statistics that the binomial distribution gives."""
    n = len(values)
    if n == 0:
        return NOTHING
    ordered = np.sort(values)
    low, high = int(binom.ppf(0.025, n, q)) - 1, int(binom.ppf(0.975, n, q))
    return Measure(float(np.quantile(ordered, q)), n, float(ordered[max(low, 0)]), float(ordered[min(high, n - 1)]))


def first(chances: Mapping[str, float]) -> str:
    """The most probable name."""
    return max(chances, key=lambda name: chances[name])
