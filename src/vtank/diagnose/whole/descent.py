"""Least squares with priors and bounds, in valleys that may be narrow and bent: a gain beside what is dead of it.

Levenberg-Marquardt (Marquardt, J. SIAM 11, 1963). A step along a bent valley ends on its wall: it is led back to the
floor by steps of the same derivative, for which no other is made. In spirit the geodesic acceleration of Transtrum and
Sethna (arXiv:1201.5885), which takes one such step of second order.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
PROMISE = 0.02  # log-likelihood that a further step must promise
CLOSE = 1e-4  # or that share of what the residual's half square is above that of noise; a choice
KEPT = 0.5  # of what a step promised, below which it has left the valley; a choice
HOPE = 2.0  # times what the slope promises in all, that a fit may still come down; a choice
BACK, LOWER = 8, 0.7  # steps back to the valley's floor, at most, and what each must leave of the height; choices


def strayed(move: Array, H: Array) -> bool:
    """Whether a move, (U,), is farther than all of it can be told apart; H: information, (U, U)."""
    return bool(move @ H @ move > move.size)


def descend(
    residual: Callable[[Array], Array],
    slopes: Callable[[Array, Array], Array],
    theta: Array,
    scale: Array,
    bounds: tuple[Array, Array],
    steps: int,
    held: bool,
    *,
    enough: float = np.inf,
    promise: float = PROMISE,
) -> tuple[Array, Array, Array]:
    """Where half of |residual|^2 + |theta / scale|^2 is least, its residual (M,) and slope (M, U) there.

    residual: of theta (U,). slopes: d residual / d theta at theta, whose residual is given too. bounds: lowest and
    highest. steps: at most. held: whether slopes cost little, and are made anew at each step; else only once theta has
    gone farther than it can be told apart. enough: that the least has to be; what promises to stay above it ends.
    promise: that a further step must make, in half a square.
    """
    weight, damping, (low, high) = scale**-2.0, 1e-4, bounds
    theta = np.clip(theta, low, high)

    def cost_of(e: Array, at: Array) -> float:
        return 0.5 * float(e @ e + np.sum(weight * at * at))

    e, about = residual(theta), theta
    J = slopes(theta, e) if theta.size else np.empty((e.size, 0))
    for _ in range(steps if theta.size else 0):
        gradient, H, cost = J.T @ e + weight * theta, J.T @ J + np.diag(weight), cost_of(e, theta)
        least_promise = max(promise, CLOSE * (cost - 0.5 * e.size))
        free = ~(((theta <= low) & (gradient > 0.0)) | ((theta >= high) & (gradient < 0.0)))

        def solved(A: Array, b: Array, free: NDArray[np.bool_] = free) -> Array:
            move = np.zeros(b.size)
            move[free] = -np.linalg.solve(A[np.ix_(free, free)], b[free])
            return move

        move, trial = solved(H, gradient), theta
        if -0.5 * gradient @ move < least_promise or cost + HOPE * 0.5 * gradient @ move > enough:
            break
        while -gradient @ move - 0.5 * move @ H @ move > least_promise:
            A = H + damping * np.diag(np.diag(H))
            move = solved(A, gradient)
            least = cost - KEPT * (-gradient @ move - 0.5 * move @ H @ move)
            at = np.clip(theta + move, low, high)
            there, floor = residual(at), e + J @ (at - theta)
            for _back in range(BACK):
                above = cost_of(there, at) - least
                if above < 0.0:
                    break
                aside = np.clip(at + solved(A, J.T @ (there - floor)), low, high)
                beside = residual(aside)
                if not cost_of(beside, aside) - least < LOWER * above:
                    break
                at, there = aside, beside
            if cost_of(there, at) < cost:
                trial = at
                break
            damping = max(damping, 1e-3) * 10.0
        if trial is theta:
            if about is theta:
                break
            J, about, damping = slopes(theta, e), theta, 1e-4  # those of elsewhere lead nowhere
            continue
        theta, e, damping = trial, there, max(damping / 10.0, 1e-8)
        if held or strayed(theta - about, H):
            J, about = slopes(theta, e), theta
    return theta, e, J
