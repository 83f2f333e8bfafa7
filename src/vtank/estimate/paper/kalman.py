"""The paper's parameter estimator: a Kalman filter whose state is the coefficient vector C, equations (16) to (22).

    C_{k+1} = F C_k + G w,   cov w = Q = q_ii I           z_{k+1} = h_k C_k + v,   var v = R = 0.01

Misprints set right: F, called "null", is the identity (with F = 0 every step would forget the estimate); G = I; the
covariance in the gain (22) is the predicted one throughout. With Q = 0 the filter is recursive least squares.

h comes in the paper's feet (`regression`), where the print's q_ii and R are literal numbers. Another scaling is
offered, because literal q_ii do not let the estimates settle (see `scales`): the same filter with another Q and R.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from filterpy.kalman import KalmanFilter
from numpy.typing import NDArray

from ...compiled import law
from .regression import Regression

Array = NDArray[np.float64]
Scaling = Literal["literal", "normalised"]


@dataclass(frozen=True)
class Evolution:
    """What the estimator believed after each step; rows before the first complete one repeat the start."""

    c: Array  # (K, p) estimates
    variance: Array  # (K, p) diagonal of P
    covariance: Array  # (p, p) final P

    @property
    def final(self) -> Array:
        """The last estimate, shape (p,): the value the paper tabulates."""
        return self.c[-1]


def scales(rows: Regression, scaling: Scaling) -> tuple[Array, float]:
    """Unit of each coefficient, shape (p,), and of z, in which q_ii, the initial variance and R count.

    literal     one: the paper's numbers on z = h C as they stand.
    normalised  as if z and every column of h had been divided by their root mean squares.
    """
    if scaling == "literal":
        return np.ones(rows.h.shape[1]), 1.0
    size = np.sqrt(np.mean(rows.h[rows.complete] ** 2, axis=0))
    output = float(np.sqrt(np.mean(rows.z[rows.complete] ** 2)))
    return output / np.where(size > 0.0, size, 1.0), output


def kalman(z: Array, h: Array, q: Array, r: float, start: Array, covariance: Array) -> Evolution:
    """Run the estimator on filterpy.

    z (K,), h (K, p), NaN rows only predict; q (p,) diagonal of Q; start (p,), covariance (p, p) before the first step.
    """
    size = h.shape[1]
    estimator = KalmanFilter(dim_x=size, dim_z=1)
    estimator.x, estimator.P = start.reshape(size, 1).copy(), covariance.copy()
    estimator.F, estimator.Q, estimator.R = np.eye(size), np.diag(q), np.array([[r]])
    c, variance = np.empty_like(h), np.empty_like(h)
    for k in range(z.size):
        estimator.predict()
        if np.isfinite(z[k]) and np.isfinite(h[k]).all():
            estimator.update(np.array([[z[k]]]), H=h[k : k + 1])
        c[k], variance[k] = estimator.x[:, 0], estimator.P.diagonal()
    return Evolution(c, variance, estimator.P.copy())


@law
def _kalman(z, h, q, r, start, covariance):  # type: ignore[no-untyped-def]
    rows, size = h.shape
    c, variance = np.empty((rows, size)), np.empty((rows, size))
    state, p = start.copy(), covariance.copy()
    for k in range(rows):
        for i in range(size):
            p[i, i] += q[i]
        if np.isfinite(z[k]) and np.isfinite(h[k]).all():
            ph = p @ h[k]
            gain = ph / (h[k] @ ph + r)
            state += gain * (z[k] - h[k] @ state)
            for i in range(size):
                for j in range(size):
                    p[i, j] -= gain[i] * ph[j]  # (21), without products of matrices
        c[k] = state
        for i in range(size):
            variance[k, i] = p[i, i]
    return c, variance, p


def kalman_compiled(z: Array, h: Array, q: Array, r: float, start: Array, covariance: Array) -> Evolution:
    """`kalman`, some hundred times faster, for Monte Carlo studies; equal to it within rounding."""
    return Evolution(*_kalman(z, np.ascontiguousarray(h), q, r, start, covariance))
