"""The paper's two-stage estimator (section III.B): fix the best-determined coefficient, estimate the rest again.

Stage one is the full filter. Stage two holds the coefficient with the smallest final variance at its final value,
moves its term to the left-hand side and runs the filter on the remaining ones, starting from stage one's estimates
and covariance, with a small q_ii (Table 4: 0.0032 to 0.005). For Model II the held coefficient is C4 = T^2 b / tau:
what stays constant between Tables 2 and 4 is b / tau, not the tabulated b.

Because h4 = n|n| is hundreds of times larger than the other regressors, "smallest variance" is a matter of units.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .kalman import Array, Evolution
from .regression import Regression


def second_stage(
    rows: Regression, first: Evolution, q: Array, r: float, estimator: Callable[..., Evolution]
) -> Evolution:
    """Stage two by the estimator of stage one; returns the evolution of all p coefficients.

    q, shape (p,): diagonal of Q. The coefficient with the smallest diagonal element of stage one's final covariance is
    held, and keeps its variance.
    """
    held = int(np.argmin(first.covariance.diagonal()))
    free = np.delete(np.arange(rows.h.shape[1]), held)
    block = np.ix_(free, free)
    reduced = rows.z - rows.h[:, held] * first.final[held]
    second = estimator(reduced, rows.h[:, free], q[free], r, first.final[free], first.covariance[block])
    c, variance = np.tile(first.final, (rows.z.size, 1)), np.tile(first.covariance.diagonal(), (rows.z.size, 1))
    c[:, free], variance[:, free] = second.c, second.variance
    covariance = np.zeros_like(first.covariance)
    covariance[held, held], covariance[block] = first.covariance[held, held], second.covariance
    return Evolution(c, variance, covariance)
