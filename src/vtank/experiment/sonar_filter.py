"""The three-state Kalman filter of the sonar range, compiled: position, velocity, acceleration under white jerk.

The same filter as identify's on filterpy, written out for speed; a test keeps them equal.
"""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_are

from ..compiled import law

Array = NDArray[np.float64]


def transition(period_s: float) -> Array:
    """F(T), shape (3, 3): constant acceleration over one period [s]."""
    t = period_s
    return np.array([[1.0, t, t * t / 2], [0.0, 1.0, t], [0.0, 0.0, 1.0]])


def white_jerk(period_s: float) -> Array:
    """J(T), shape (3, 3): covariance that white jerk of unit spectral density builds up over one period [s]."""
    t = period_s
    return np.array(
        [
            [t**5 / 20, t**4 / 8, t**3 / 6],
            [t**4 / 8, t**3 / 3, t**2 / 2],
            [t**3 / 6, t**2 / 2, t],
        ]
    )


def steady_state(period_s: float, q: float, r: float) -> tuple[Array, Array]:
    """Steady gain, shape (3,) [1, 1/s, 1/s2], and covariance after an update, shape (3, 3).

    q [unit2/s5] and r [unit2] for a measurement in any unit. The Riccati equation is solved with time in periods
    and the measurement in its own standard deviation, where it is well conditioned.
    """
    gain, posterior = _steady_state(period_s, q, r)
    return gain.copy(), posterior.copy()


@functools.lru_cache(maxsize=64)
def _steady_state(period_s: float, q: float, r: float) -> tuple[Array, Array]:
    measures = np.array([[1.0], [0.0], [0.0]])
    prior = solve_discrete_are(transition(1.0).T, measures, white_jerk(1.0) * (q * period_s**5 / r), np.eye(1))
    gain = prior[:, 0] / (prior[0, 0] + 1.0)
    posterior = prior - np.outer(gain, prior[0])
    rate = period_s ** -np.arange(3.0)
    return gain * rate, r * posterior * np.outer(rate, rate)


@law
def predict(s, c, t, q):
    """Advance state s (3,) and covariance c (3, 3) by t [s] under white jerk of density q, in place."""
    s[0] += t * (s[1] + 0.5 * t * s[2])
    s[1] += t * s[2]
    g = 0.5 * t * t
    # upper triangle of F c, then of (F c) F'
    a00 = c[0, 0] + t * c[0, 1] + g * c[0, 2]
    a01 = c[0, 1] + t * c[1, 1] + g * c[1, 2]
    a02 = c[0, 2] + t * c[1, 2] + g * c[2, 2]
    a11 = c[1, 1] + t * c[1, 2]
    a12 = c[1, 2] + t * c[2, 2]
    a22 = c[2, 2]
    c[0, 0] = a00 + t * a01 + g * a02 + q * t**5 / 20.0
    c[0, 1] = a01 + t * a02 + q * t**4 / 8.0
    c[0, 2] = a02 + q * t**3 / 6.0
    c[1, 1] = a11 + t * a12 + q * t**3 / 3.0
    c[1, 2] = a12 + q * t * t / 2.0
    c[2, 2] = a22 + q * t
    c[1, 0], c[2, 0], c[2, 1] = c[0, 1], c[0, 2], c[1, 2]


@law
def update(s, c, measured, r):
    """Take in a measurement of variance r, in place."""
    innovation, variance = measured - s[0], c[0, 0] + r
    g0, g1, g2 = c[0, 0] / variance, c[0, 1] / variance, c[0, 2] / variance
    s[0] += g0 * innovation
    s[1] += g1 * innovation
    s[2] += g2 * innovation
    c[1, 1] -= g1 * c[0, 1]
    c[1, 2] -= g1 * c[0, 2]
    c[2, 2] -= g2 * c[0, 2]
    c[0, 0] -= g0 * c[0, 0]
    c[0, 1] -= g0 * c[0, 1]
    c[0, 2] -= g0 * c[0, 2]
    c[1, 0], c[2, 0], c[2, 1] = c[0, 1], c[0, 2], c[1, 2]


@law
def filter_step(s, c, measured, t, q, r):
    """One period t [s] of the filter, in place; NaN is a missed ping: the filter predicts and goes on."""
    predict(s, c, t, q)
    if not np.isnan(measured):
        update(s, c, measured, r)
