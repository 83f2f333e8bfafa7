"""Bounds on station keeping in regular waves that need no simulation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from ...experiment import Plan
from ...plant import ALPHA, BETA, LINEAR_DRAG, TAU
from ...waves import breaking_height, depth_profile, wave_number

Array = NDArray[np.float64]
TURN = np.linspace(0.0, 2.0 * np.pi, 721)


def water_speed(height_m: float, period_s: float, water_depth_m: float, depth_m: float) -> float:
    """Amplitude of the water's speed ahead and astern under a regular wave [m/s]."""
    w = 2.0 * np.pi / period_s
    along, _ = depth_profile(wave_number(np.array([w]), water_depth_m), -depth_m, water_depth_m)
    return float(0.5 * height_m * w * along[0])


def standing_still_rev_s(plan: Plan, speed_m_s: float, period_s: float) -> float:
    """Greatest propeller speed that keeps the hull quite still in water oscillating at U sin(w t) [rev/s].

    Thrust per moving mass balances drag and the water's acceleration, z = |alpha| U|U| + c U + dU/dt, and the
    propellers lead it by their lag: beta n|n| = z + tau dz/dt.
    """
    w, p = 2.0 * np.pi / period_s, plan.p
    u, du, ddu = (speed_m_s * w**i * f for i, f in enumerate((np.sin(TURN), np.cos(TURN), -np.sin(TURN))))
    z = -p[ALPHA] * np.abs(u) * u + p[LINEAR_DRAG] * u + du
    rate = -2.0 * p[ALPHA] * np.abs(u) * du + p[LINEAR_DRAG] * du + ddu
    return float(np.sqrt(np.abs(z + p[TAU] * rate).max() / p[BETA]))


def thrust_bound_m(plan: Plan, period_s: float, water_depth_m: float, depth_m: float) -> float:
    """Height of the regular wave in which a hull kept quite still takes all of the propellers' speed [m].

    The height at which waves break where even that does not.
    """

    def excess(height: float) -> float:
        speed = water_speed(height, period_s, water_depth_m, depth_m)
        return standing_still_rev_s(plan, speed, period_s) - plan.n_limit_rev_s

    highest = breaking_height(period_s, water_depth_m)
    return highest if excess(highest) < 0.0 else float(brentq(excess, 0.0, highest, xtol=1e-6))


def drift_bound_m(error_m: float, period_s: float, water_depth_m: float, depth_m: float) -> float:
    """Height of the regular wave that carries the water itself, and a hull that rides along, by +-error_m [m]."""
    return error_m * 2.0 * np.pi / period_s / water_speed(1.0, period_s, water_depth_m, depth_m)
