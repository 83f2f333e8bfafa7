"""Maximum a posteriori fit of a hypothesis: damped Gauss-Newton on innovations and priors, inside bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..estimate.problem import Filtered, Problem

PROMISE = 0.01  # log-likelihood that a further step must promise to be taken
STUCK = 1e9  # damping at which no step helps any more


@dataclass(frozen=True)
class Prior:
    """Independent normal priors on all unknowns, and the bounds they are truncated to; shapes (size,)."""

    mean: np.ndarray
    sd: np.ndarray
    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True)
class Optimum:
    """Where the fit ended.

    Attributes:
        theta: unknowns, shape (size,).
        cost: half the sum of squared innovations and prior deviations, with the gains held.
        information: Gauss-Newton Hessian of the cost, prior included, shape (size, size).
        gradient: of the cost at theta, shape (size,).
        converged: whether a further step would no longer matter.
    """

    theta: np.ndarray
    cost: float
    information: np.ndarray
    gradient: np.ndarray
    converged: bool


@np.errstate(over="ignore", invalid="ignore")  # a trial may run away: its residuals are held, and it is not taken
def climb(problem: Problem, theta: np.ndarray, prior: Prior, filtered: Sequence[Filtered], steps: int = 15) -> Optimum:
    """Levenberg-Marquardt from theta with the filter's gains held; bounds by projection."""
    theta = np.clip(theta, prior.low, prior.high)
    weight, damping = prior.sd**-2, 1e-3
    residual, converged = problem.residuals(theta, filtered), False
    cost = _cost(residual, theta, prior)
    for step in range(steps + 1):
        J = problem.jacobian(theta, filtered, residual)
        gradient = J.T @ residual + weight * (theta - prior.mean)
        H = J.T @ J + np.diag(weight)
        free = ~(((theta <= prior.low) & (gradient > 0)) | ((theta >= prior.high) & (gradient < 0)))
        converged = _promise(H, gradient, free) < PROMISE
        if converged or step == steps:
            break
        while damping < STUCK:
            move = np.zeros_like(theta)
            damped = H[np.ix_(free, free)] + damping * np.diag(np.diag(H)[free])
            move[free] = -np.linalg.solve(damped, gradient[free])
            trial = np.clip(theta + move, prior.low, prior.high)
            trial_residual = problem.residuals(trial, filtered)
            trial_cost = _cost(trial_residual, trial, prior)
            if trial_cost <= cost:
                theta, residual, cost = trial, trial_residual, trial_cost
                break
            damping *= 8.0
        if damping >= STUCK:
            break
        damping = max(damping / 10.0, 1e-9)
    return Optimum(theta, cost, H, gradient, converged)


def _promise(H: np.ndarray, gradient: np.ndarray, free: np.ndarray) -> float:
    """Drop of the cost that the undamped step promises."""
    g = gradient[free]
    return 0.5 * float(g @ np.linalg.solve(H[np.ix_(free, free)], g))


def _cost(residual: np.ndarray, theta: np.ndarray, prior: Prior) -> float:
    return 0.5 * float(residual @ residual + np.sum(((theta - prior.mean) / prior.sd) ** 2))
