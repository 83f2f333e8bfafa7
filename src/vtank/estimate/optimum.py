"""The optimum of a problem: damped Gauss-Newton on innovations and priors, inside bounds.

Written out because the unknowns are few and the samples many, so that the normal equations cost a hundredth of the
factorisation of the full Jacobian, and because residuals and derivatives come from one pass over the runs. Marquardt,
J. SIAM 11 (1963); bounds by projection, with the unknowns that are pressed against a bound left out of the step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .problem import Filtered, Problem

ROUNDING = 1e-12  # [-] damping that keeps curvatures apart which rounding has made one
PROMISE = 0.01  # log-likelihood that a further step must promise to be taken
STILL = 1e-9  # the same where an optimum is wanted to the last digits that matter, and as a share of the cost
FIRST_DAMPING, LEAST_DAMPING, STUCK = 1e-3, 1e-9, 1e9  # relative to the diagonal; at the last no step helps any more
RAISE, EASE = 8.0, 10.0  # factors on the damping after a step that made it worse, and after one that helped


@dataclass(frozen=True)
class Prior:
    """What is known beforehand: normal priors (a deviation of inf: nothing), cut off at bounds; shapes (size,)."""

    mean: np.ndarray
    sd: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @property
    def weight(self) -> np.ndarray:
        """Information of the prior, shape (size,)."""
        return self.sd**-2.0

    def cost(self, residual: np.ndarray, theta: np.ndarray) -> float:
        """Half the sum of squared innovations and prior deviations."""
        return 0.5 * float(residual @ residual + np.sum(((theta - self.mean) / self.sd) ** 2))


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
def climb(
    problem: Problem,
    theta: np.ndarray,
    prior: Prior,
    filtered: Sequence[Filtered],
    steps: int = 15,
    promise: float = PROMISE,
    relative: float = 0.0,
) -> Optimum:
    """Levenberg-Marquardt from theta with the filter's gains held.

    It ends where the next step promises less than `promise`, or less than the share `relative` of the cost.
    """
    theta = np.clip(theta, prior.low, prior.high)
    damping, converged = FIRST_DAMPING, False
    residual, J = problem.linearise(theta, filtered)
    cost = prior.cost(residual, theta)
    for step in range(steps + 1):
        gradient = J.T @ residual + prior.weight * (theta - prior.mean)
        H = J.T @ J + np.diag(prior.weight)
        free = ~(((theta <= prior.low) & (gradient > 0)) | ((theta >= prior.high) & (gradient < 0)))
        free &= np.diag(H) > 0.0
        converged = _promised(H, gradient, free) < max(promise, relative * cost)
        if converged or step == steps:
            break
        while damping < STUCK:
            trial = np.clip(theta + _move(H, gradient, free, damping), prior.low, prior.high)
            there = problem.linearise(trial, filtered)
            at_trial = prior.cost(there[0], trial)
            if at_trial <= cost:
                theta, (residual, J), cost = trial, there, at_trial
                break
            damping *= RAISE
        if damping >= STUCK:
            break
        damping = max(damping / EASE, LEAST_DAMPING)
    return Optimum(theta, cost, H, gradient, converged)


def descend(
    problem: Problem, theta: np.ndarray, prior: Prior, filtered: Sequence[Filtered], steps: int = 50
) -> Optimum:
    """`climb` until nothing moves any more: a millionth of a standard deviation."""
    return climb(problem, theta, prior, filtered, steps, STILL, STILL)


def _move(H: np.ndarray, gradient: np.ndarray, free: np.ndarray, damping: float) -> np.ndarray:
    """The damped step, shape (size,)."""
    move = np.zeros_like(gradient)
    scale = np.sqrt(np.diag(H)[free])
    A = H[np.ix_(free, free)] / np.outer(scale, scale)
    move[free] = -np.linalg.solve(A + damping * np.eye(scale.size), gradient[free] / scale) / scale
    return move


def _promised(H: np.ndarray, gradient: np.ndarray, free: np.ndarray) -> float:
    """Drop of the cost that the undamped step promises."""
    return -0.5 * float(gradient @ _move(H, gradient, free, ROUNDING))
