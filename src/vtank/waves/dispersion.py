"""The dispersion relation of linear water waves, w^2 = g k tanh(k h), and the height at which waves break.

Source: Dean and Dalrymple, Water Wave Mechanics for Engineers and Scientists (1991), chapter 3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..units import G_M_S2

Array = NDArray[np.float64]

NEWTON_STEPS = 8  # from 5 % to rounding; each step doubles the number of correct digits


def wave_number(rad_s: ArrayLike, depth_m: float) -> Array:
    """k [1/m] of waves of frequency w [rad/s], above zero, in water of depth h [m], which may be infinite.

    Newton's method on x tanh x = w^2 h/g, x = k h, from Eckart's x = c/sqrt(tanh c), which is within 5 %.
    """
    w = np.asarray(rad_s, dtype=np.float64)
    deep = w * w / G_M_S2
    if np.isinf(depth_m):
        return deep
    c = deep * depth_m
    x = c / np.sqrt(np.tanh(c))
    for _ in range(NEWTON_STEPS):
        tanh = np.tanh(x)
        x = x - (x * tanh - c) / (tanh + x * (1.0 - tanh * tanh))
    return x / depth_m


def breaking_height(period_s: float, depth_m: float) -> float:
    """Greatest height, crest to trough, of a regular wave [m]: 0.142 L tanh(k h), Miche (1944)."""
    k = float(wave_number(2.0 * np.pi / period_s, depth_m))
    return 0.142 * 2.0 * np.pi / k * float(np.tanh(k * depth_m))
