"""The smallest variance that any unbiased estimate can have: the Cramer-Rao bound of the surge model.

Inverse of the Fisher information of all unknowns, initial states included, from the sensitivities of the simulated
measurements at the truth, for known white noise and a propeller speed that is recorded without error (Cramer,
Mathematical Methods of Statistics, 1946; Ljung, System Identification, 1999, section 7.4).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .observed import Observed
from .problem import Noise, Problem


def rounded_variance(noise: float, resolution: float) -> float:
    """Variance of a reading with normal noise of that deviation, rounded to a resolution; same unit, squared.

    Rounding adds resolution^2/12, like a uniform error, where the noise is not much smaller than the resolution
    (Widrow, IRE Trans. Circuit Theory 3, 1956).
    """
    return noise**2 + resolution**2 / 12.0


def cramer_rao(runs: Sequence[Observed], p: np.ndarray, free: Sequence[str], variance: float) -> np.ndarray:
    """Covariance bound of the free parameters, shape (F, F), for runs that start at rest.

    p: the true parameter vector; variance: of every measurement [unit of the measurement, squared].
    """
    problem = Problem(tuple(runs), p, tuple(free), noise=Noise((variance, variance, variance)))
    theta = problem.initial()
    for k in range(len(runs)):
        theta[problem.own_slice(k)] = 0.0  # at rest at x = 0
    J = problem.jacobian(theta, problem.filter(theta))
    scale = np.linalg.norm(J, axis=0)
    bound = np.linalg.inv((J / scale).T @ (J / scale)) / np.outer(scale, scale)
    return np.asarray(bound[: len(free), : len(free)])
