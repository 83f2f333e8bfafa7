"""Ordinary least squares on the paper's regressions (12) and (13), its comparison in section VI."""

from __future__ import annotations

import numpy as np

from .kalman import Evolution
from .regression import Regression


def least_squares(rows: Regression) -> Evolution:
    """Fit all complete rows at once: one estimate, with the covariance that white equation errors would give it.

    Columns are scaled to unit length first; a zero column gets a zero coefficient.
    """
    z, h = rows.z[rows.complete], rows.h[rows.complete]
    length = np.linalg.norm(h, axis=0)
    length[length == 0.0] = 1.0
    inverse = np.linalg.pinv(h / length)
    scaled = inverse @ z
    error = z - h / length @ scaled
    variance = float(error @ error) / max(z.size - h.shape[1], 1)
    covariance = variance * (inverse @ inverse.T) / np.outer(length, length)
    return Evolution((scaled / length)[None], covariance.diagonal()[None], covariance)
