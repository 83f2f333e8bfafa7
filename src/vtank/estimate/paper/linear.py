"""The paper's linear comparison model, equation (23): u_{k+1} = a1 u_k + a2 u_{k-1} + b1 n_k + b2 n_{k-1}."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter, lfiltic

from .regression import Array


@dataclass(frozen=True)
class LinearModel:
    """Coefficients of (23) at one step; b1, b2 in [m/rev]."""

    a1: float
    a2: float
    b1_m_per_rev: float
    b2_m_per_rev: float
    step_s: float

    @property
    def poles(self) -> NDArray[np.complex128]:
        """The two discrete poles, shape (2,); stable inside the unit circle."""
        return np.roots([1.0, -self.a1, -self.a2]).astype(complex)

    def free_run(self, n_rev_s: Array, u_m_s: Array) -> Array:
        """Surge speed [m/s], shape (K,), from the propeller speed (K,) and the first two speeds of u_m_s alone."""
        numerator, denominator = [self.b1_m_per_rev, self.b2_m_per_rev], [1.0, -self.a1, -self.a2]
        memory = lfiltic(numerator, denominator, y=[u_m_s[1], u_m_s[0]], x=[n_rev_s[0]])
        ahead, _ = lfilter(numerator, denominator, n_rev_s[1:-1], zi=memory)
        return np.concatenate([u_m_s[:2], ahead])


def fit_linear(u_m_s: Array, n_rev_s: Array, step_s: float) -> LinearModel:
    """Least squares on (23) for records of shape (K,), one row per step; rows with a missing sample are left out."""
    u, n = np.asarray(u_m_s, dtype=float), np.asarray(n_rev_s, dtype=float)
    h = np.column_stack([u[1:-1], u[:-2], n[1:-1], n[:-2]])
    complete = np.isfinite(u[2:]) & np.isfinite(h).all(axis=1)
    a1, a2, b1, b2 = np.linalg.lstsq(h[complete], u[2:][complete], rcond=None)[0].tolist()
    return LinearModel(a1, a2, b1, b2, step_s)
