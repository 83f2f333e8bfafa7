"""Ordinary least squares on the paper's regressions (12) and (13), its comparison in section VI."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .regression import Array, Regression


@dataclass(frozen=True)
class LeastSquaresFit:
    """Coefficients with the covariance that white, uncorrelated equation errors would give them."""

    c: Array  # (p,) in the paper's feet
    covariance: Array  # (p, p)
    deviation: float  # of the equation error z - h C [ft/s]
    condition: float  # of h with its columns at unit length

    @property
    def standard_error(self) -> Array:
        """Claimed standard error of each coefficient, shape (p,)."""
        return np.sqrt(self.covariance.diagonal())


def least_squares(rows: Regression) -> LeastSquaresFit:
    """Fit all complete rows at once. Columns are scaled to unit length first; a zero column gets a zero coefficient."""
    z, h = rows.z[rows.complete], rows.h[rows.complete]
    length = np.linalg.norm(h, axis=0)
    length[length == 0.0] = 1.0
    scaled, _, _, singular = np.linalg.lstsq(h / length, z, rcond=None)
    error = z - h / length @ scaled
    variance = float(error @ error) / max(z.size - h.shape[1], 1)
    covariance = variance * np.linalg.pinv((h / length).T @ (h / length)) / np.outer(length, length)
    condition = float(singular[0] / singular[-1]) if singular[-1] > 0.0 else np.inf
    return LeastSquaresFit(scaled / length, covariance, float(np.sqrt(variance)), condition)
