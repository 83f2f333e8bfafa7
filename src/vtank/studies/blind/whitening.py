"""White residuals under the noise that a case truly has.

Sonar noise (white, or with a memory), rounding, turbulence and the tachometer's noise, which enters as thrust, make up
a linear model of what moves the ranges about the noise-free ones; its Kalman recursion turns correlated residuals into
white ones of unit variance, exactly as the Cholesky factor of their covariance would.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...compiled import law
from .fly import Trip

Array = NDArray[np.float64]
PITCHING_M, PITCHING_S = 4e-4, 1.0  # [m], [s] rms and memory of the range error of a hull that pitches (paper's runs)
SIZE = 5  # place, speed, turbulence, thrust by tachometer noise, coloured sonar noise


@dataclass(frozen=True, eq=False)
class Whitener:
    """Gains of one run.

    Attributes:
        damping: rate at which a small change of speed dies away, shape (T,) [1/s].
        push: change of thrust by one deviation of the tachometer, shape (T,) [m/s2].
        deviation: stationary deviation of turbulence [m/s2], unit tachometer process and coloured sonar noise [m].
        memory: their correlation times [s]; 0 is white from tick to tick.
        variance: of the white part of each range, shape (T,) [m2].
        period_s: tick [s].
    """

    damping: Array
    push: Array
    deviation: tuple[float, float, float]
    memory: tuple[float, float, float]
    variance: Array
    period_s: float

    def whiten(self, columns: Array) -> Array:
        """White columns, shape (T, C), of `columns` (T, C) [m]; rows with NaN in the first column come back as zero."""
        gain, decay, mean, deviation = self._gains(np.isnan(columns[:, 0]).tobytes())
        out = np.zeros_like(columns)
        innovations(columns, gain, decay, mean, self.push, self.keep, self.period_s, deviation, out)
        return out

    @property
    def keep(self) -> Array:
        """Correlation of the three coloured processes from tick to tick, shape (3,)."""
        return np.array([math.exp(-self.period_s / time_s) if time_s > 0.0 else 0.0 for time_s in self.memory])

    @functools.lru_cache(maxsize=16)  # noqa: B019 - a whitener lives as long as its case
    def _gains(self, missing: bytes) -> tuple[Array, Array, Array, Array]:
        """Kalman gains (T, 5), decay of speed (T,), mean decay times tick (T,) [s], deviations of innovations (T,)."""
        gain, deviation = np.zeros((self.damping.size, SIZE)), np.zeros(self.damping.size)
        decay = np.exp(-self.damping * self.period_s)
        safe = np.maximum(self.damping, 1e-9)
        mean = np.where(self.damping > 1e-9, (1.0 - decay) / safe, self.period_s)
        recursion(np.frombuffer(missing, dtype=bool), decay, mean, self.push, np.array(self.deviation), self.keep,
                  self.variance, self.period_s, gain, deviation)  # fmt: skip
        return gain, decay, mean, deviation


def whitener(plan: Trip, x_m: Array, speed_m_s: Array, n_rev_s: Array) -> Whitener:
    """The noise of a run about a noise-free motion: place, speed and propeller speed at the ticks, shape (T,) each.

    The hull that its thrusters hold pitches and sways a little, an error of PITCHING_M of the range.
    """
    s, truth, noise = plan.scenario, plan.truth, plan.noise
    coloured = noise.memory_s > 0.0
    white = 0.0 if coloured else s.sonar.noise_m * noise.growth(-x_m, speed_m_s)
    late = noise.jitter * s.period_s * speed_m_s  # of which uniform errors of the stamps have a third in square
    lag = math.exp(-s.period_s / truth.tau_s) if truth.tau_s > 0.0 else 0.0
    smoothed = math.sqrt((1.0 - lag) / (1.0 + lag))  # of white noise through the lag
    return Whitener(
        damping=2.0 * abs(truth.alpha_per_m) * np.abs(speed_m_s),
        push=2.0 * truth.beta_m_per_rev2 * np.abs(n_rev_s) * s.tachometer.noise_rev_s,
        deviation=(s.turbulence.acceleration_m_s2, smoothed, math.hypot(PITCHING_M, coloured * s.sonar.noise_m)),
        memory=(s.turbulence.time_s, truth.tau_s, noise.memory_s if coloured else PITCHING_S),
        variance=white**2 + late**2 / 3.0 + s.sonar.resolution_m**2 / 12.0 + 1e-12 + 0.0 * x_m,
        period_s=s.period_s,
    )


@law
def recursion(missing, decay, mean, push, sd, keep, variance, h, gain, deviation):  # type: ignore[no-untyped-def]
    """Covariance recursion; fills the gains and the deviations of the innovations [m]."""
    P, F = np.zeros((SIZE, SIZE)), np.eye(SIZE)
    for j in range(3):
        P[2 + j, 2 + j] = sd[j] ** 2
        F[2 + j, 2 + j] = keep[j]
    for k in range(missing.size):
        S = P[0, 0] + 2.0 * P[0, 4] + P[4, 4] + variance[k]
        deviation[k] = math.sqrt(S)
        if not missing[k]:
            row = P[0] + P[4]
            gain[k] = row / S
            P -= np.outer(gain[k], row)
        F[0, 1], F[1, 1] = mean[k], decay[k]
        F[0, 2], F[1, 2] = 0.5 * h * h, mean[k]
        F[0, 3], F[1, 3] = 0.5 * h * h * push[k], mean[k] * push[k]
        P = F @ P @ F.T
        for j in range(3):
            P[2 + j, 2 + j] += sd[j] ** 2 * (1.0 - keep[j] ** 2)


@law
def innovations(columns, gain, decay, mean, push, keep, h, deviation, out):  # type: ignore[no-untyped-def]
    """Innovations over their deviations, column by column, with the gains given."""
    for c in range(columns.shape[1]):
        x, u, d, q, s = 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(columns.shape[0]):
            if not math.isnan(columns[k, 0]):
                e = columns[k, c] - x - s
                out[k, c] = e / deviation[k]
                x, u, d = x + gain[k, 0] * e, u + gain[k, 1] * e, d + gain[k, 2] * e
                q, s = q + gain[k, 3] * e, s + gain[k, 4] * e
            a = d + push[k] * q
            x, u = x + mean[k] * u + 0.5 * h * h * a, decay[k] * u + mean[k] * a
            d, q, s = keep[0] * d, keep[1] * q, keep[2] * s
