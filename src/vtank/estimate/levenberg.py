"""Levenberg-Marquardt on the innovations of a problem, inside bounds.

Written out because the unknowns are few and the samples many: the normal equations, scaled to unit diagonal, cost a
hundredth of the factorisation of the full Jacobian. Marquardt, J. SIAM 11 (1963); bounds by projection, with the
unknowns that are pressed against a bound left out of the step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .problem import Filtered, Problem

STILL = 1e-6  # predicted relative decrease of the cost at which a step is the last: it leaves far less behind
FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-12, 1e8  # relative to the diagonal of the normal equations
FAITHFUL = 0.8  # share of the promised decrease from which the linear model is trusted further
NEAR = 0.001  # promised relative decrease below which a faithful linear model serves the next step as well


@dataclass(frozen=True)
class Prior:
    """What is known beforehand: mean and deviation (inf: nothing) of each unknown, and its bounds; shapes (size,)."""

    mean: np.ndarray
    sd: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @property
    def weight(self) -> np.ndarray:
        """Information of the prior, shape (size,)."""
        return self.sd**-2.0


@dataclass(frozen=True)
class Descent:
    """Where it ended.

    Attributes:
        theta: unknowns, shape (size,).
        cost: sum of squares, the prior's included.
        converged: whether a further step would not matter.
        jacobian: derivative of the innovations [m or m/s], there or before a last step that hardly mattered, shape
            (sum M, size); no rows where no iteration was asked for.
    """

    theta: np.ndarray
    cost: float
    converged: bool
    jacobian: np.ndarray


def descend(
    problem: Problem, theta: np.ndarray, filtered: Sequence[Filtered], prior: Prior, iterations: int = 50
) -> Descent:
    """Minimise the sum of squared innovations over their deviations, with the gains of `filtered` held."""

    def squares(residual: np.ndarray, theta: np.ndarray) -> float:
        return float(residual @ residual + prior.weight @ (theta - prior.mean) ** 2)

    theta, damping = np.clip(theta, prior.low, prior.high), FIRST_DAMPING
    residual = problem.residuals(theta, filtered)
    deviation = np.sqrt(np.concatenate([f.variance for f in filtered]))[:, None]
    cost, near, J = squares(residual, theta), False, np.empty((0, theta.size))
    for _ in range(iterations):
        if not near:
            J = problem.jacobian(theta, filtered, residual)
            information = J.T @ J + np.diag(prior.weight)
        gradient = J.T @ residual + prior.weight * (theta - prior.mean)
        while True:
            trial, promised = _step(theta, gradient, information, damping, prior)
            at_trial = problem.residuals(trial, filtered)
            decrease = cost - squares(at_trial, trial)
            if decrease >= 0.0 or damping > MOST_DAMPING or promised < STILL * cost:
                break
            damping *= 10.0
        if decrease > 0.0:
            theta, residual, cost = trial, at_trial, cost - decrease
        if promised <= STILL * cost or damping > MOST_DAMPING:
            return Descent(theta, cost, True, J * deviation)
        faithful = decrease > FAITHFUL * promised
        near = faithful and promised < NEAR * cost
        damping = max(damping * (0.01 if faithful else 0.1), LEAST_DAMPING)
    return Descent(theta, cost, False, J * deviation if iterations else J)


def _step(
    theta: np.ndarray, gradient: np.ndarray, information: np.ndarray, damping: float, prior: Prior
) -> tuple[np.ndarray, float]:
    """The damped step from theta, cut off at the bounds, and the decrease of the cost that it promises."""
    pressed = (theta <= prior.low) & (gradient > 0.0) | (theta >= prior.high) & (gradient < 0.0)
    free = ~pressed & (np.diag(information) > 0.0)
    scale = np.sqrt(np.diag(information)[free])
    A = information[np.ix_(free, free)] / np.outer(scale, scale)
    move = np.zeros_like(theta)
    move[free] = -np.linalg.solve(A + damping * np.eye(scale.size), gradient[free] / scale) / scale
    trial = np.clip(theta + move, prior.low, prior.high)
    move = trial - theta
    return trial, float(-2.0 * gradient @ move - move @ information @ move)
