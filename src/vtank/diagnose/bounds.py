"""What bounds of unknowns take of a Gaussian posterior, and of its prior."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr

Array = NDArray[np.float64]
AT = 1e-12  # from a bound at which an unknown is held there


def within(
    theta: Array, gradient: Array, covariance: Array, low: Array, high: Array, mean: Array | float, sd: Array
) -> float:
    """Log of the share of the posterior that lies within bounds over that of the prior; -inf where rounding has it.

    At the optimum theta, (U,), of the cost with this gradient, (U,), and the inverse of its curvature, (U, U). Where a
    bound holds an unknown the cost still falls beyond it: its Gaussian is about where the cost would be least, and
    stands higher by that. mean, sd: of the prior, (U,). Each unknown by itself, as its margin has it.
    """
    variance, mean = np.diag(covariance), np.broadcast_to(mean, theta.shape)
    bounded = np.flatnonzero(np.isfinite(low) | np.isfinite(high))
    if np.any(variance[bounded] <= 0.0):
        return -np.inf
    held = ((theta <= low + AT) & (gradient > 0.0)) | ((theta >= high - AT) & (gradient < 0.0))
    pull, total = np.where(held, gradient * variance, 0.0), 0.0
    for i in bounded:
        total += 0.5 * pull[i] ** 2 / variance[i]
        total += _log_inside(low[i], high[i], theta[i] - pull[i], np.sqrt(variance[i]))
        total -= _log_inside(low[i], high[i], mean[i], sd[i])
    return float(total)


def _log_inside(low: float, high: float, mean: float, sd: float) -> float:
    """Log probability that a normal variable lies above `low` (where finite), else below `high`: the nearer one."""
    if np.isfinite(low) and (not np.isfinite(high) or abs(mean - low) <= abs(high - mean)):
        return float(log_ndtr((mean - low) / sd))
    return float(log_ndtr((high - mean) / sd)) if np.isfinite(high) else 0.0
