"""Two small filters, written out because the package that has them takes half a second to load."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.ndimage import correlate1d

from ..compiled import law


@law
def first_order(x: np.ndarray, ahead: float, behind: float, pole: float) -> np.ndarray:
    """y[k] = ahead x[k] + behind x[k-1] + pole y[k-1], at rest before the first sample, shape (K,)."""
    y, state = np.empty(x.size), 0.0
    for k in range(x.size):
        y[k] = ahead * x[k] + state
        state = behind * x[k] + pole * y[k]
    return y


def local_polynomial(values: np.ndarray, window: int, order: int) -> np.ndarray:
    """Values along the first axis, shape (I,) or (I, K), smoothed by polynomials over `window` samples, an odd number.

    At either end by the polynomial of the outermost window. Savitzky, Golay, Analytical Chemistry 36 (1964).
    """
    fit, half = _projection(window, order), window // 2
    out = correlate1d(values, fit[half], axis=0, mode="nearest")
    out[:half], out[-half:] = fit[:half] @ values[:window], fit[-half:] @ values[-window:]
    return np.asarray(out)


@cache
def _projection(window: int, order: int) -> np.ndarray:
    """Samples of a window to its fitted polynomial at each of them, shape (window, window)."""
    powers = np.vander(np.linspace(-1.0, 1.0, window), order + 1)
    return np.asarray(powers @ np.linalg.pinv(powers))
