"""The ceiling: what an ideal observer, who knows the noise and every signal, could score on the same cases.

A rival explanation leaves the vector e of whitened residuals, |e| being its separation from the truth. Under noise n
the log-likelihood of the truth exceeds the rival's by |e|^2/2 + e n, so only the Gram matrix of the rivals' residuals
matters. Effects are alike before the data; the refit without any effect pays no Occam factor, the truth pays that of a
prior as wide as the signal, sqrt(1 + d^2).
Eriksson, Frisk, Krysander, Automatica 49 (2013): distinguishability as Kullback-Leibler divergence, |e|^2/2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import chi2, ncx2

DRAWS = 2000
FALSE_UNKNOWN = 0.03  # false alarm rate at which an unknown is looked for (the project's bar)
DIRECTIONS = 20  # [-] dimensions in which an unknown signal may lie; a guess, the degrees of a generic discrepancy


@dataclass(frozen=True)
class Ceiling:
    """Expected top-1 rate, log score and Brier score of the ideal observer on one case."""

    top1: float
    log_score: float
    brier: float


def ceiling(rivals: Mapping[str, Any], d: float, seed: int = 0) -> Ceiling:
    """The ceiling on a case with post-refit signal-to-noise ratio d; rivals as sealed with its truth."""
    gram = np.array(rivals["gram"])
    values, vectors = np.linalg.eigh(gram)
    factor = vectors * np.sqrt(np.maximum(values, 0.0))
    noise = np.random.default_rng(seed).standard_normal((DRAWS, gram.shape[0])) @ factor.T
    behind = -(0.5 * np.diag(gram) + noise)
    behind[:, list(rivals["names"]).index("parameters")] += 0.5 * math.log1p(d * d)
    top = np.maximum(behind.max(axis=1), 0.0)
    weight = np.exp(behind - top[:, None])
    right = np.exp(-top)
    total = right + weight.sum(axis=1)
    p, others = right / total, weight / total[:, None]
    return Ceiling(
        float(np.mean(behind.max(axis=1) < 0.0)),
        float(np.mean(-np.log(p))),
        float(np.mean((1.0 - p) ** 2 + np.sum(others**2, axis=1))),
    )


def unknown_ceiling(leftover: float) -> float:
    """Chance to notice a signal of that size, left by every known effect, in an unknown one of DIRECTIONS."""
    return float(ncx2.sf(chi2.isf(FALSE_UNKNOWN, DIRECTIONS), DIRECTIONS, leftover**2))


def leftover(rivals: Mapping[str, Any]) -> float:
    """What the best rival cannot imitate [-]."""
    return math.sqrt(max(min(row[i] for i, row in enumerate(rivals["gram"])), 0.0))
