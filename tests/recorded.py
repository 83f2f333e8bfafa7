"""Recordings for tests of the diagnosis, made by the surge equation with a force that no law knows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vtank.dynamics.parameters import null_vector, slot, vector
from vtank.dynamics.surge import advance
from vtank.identify.observed import RANGE, Observed

TICK_S = 0.1
NOMINAL = vector({"alpha": -2.556, "beta": 4.877e-4, "thrust_lag.tau": 0.7074})  # paper's Model II, rounded
STANDOFF_M = float(null_vector()[slot("standoff")])

Force = Callable[[float, float, float], float]  # time [s], surge speed [m/s], propeller speed [rev/s] -> [m/s2]


def calm(t: float, u: float, n: float) -> float:
    """No extra force."""
    return 0.0


def record(name: str, propeller: np.ndarray, p: np.ndarray, noise_m: float, seed: int, force: Force = calm) -> Observed:
    """A run at 10 Hz under held propeller speeds, shape (I,), with an extra force held over each tick."""
    rng = np.random.default_rng(seed)
    time = TICK_S * np.arange(propeller.size)
    x = u = z = wake = 0.0
    place = np.empty(time.size)
    for k, t in enumerate(time):
        place[k] = x
        x, u, z, wake = advance(t, TICK_S, x, u, z, wake, propeller[k], force(t, u, propeller[k]), p)
    measured = STANDOFF_M - place + noise_m * rng.normal(size=time.size)
    return Observed(name, "n_rev_s", time, propeller, time, measured, np.full(time.size, RANGE))


def sine(frequency_rad_s: float, amplitude_rev_s: float, duration_s: float = 120.0) -> np.ndarray:
    """Propeller speeds of a run driven at one frequency, shape (I,) [rev/s]."""
    return amplitude_rev_s * np.sin(frequency_rad_s * TICK_S * np.arange(round(duration_s / TICK_S)))
