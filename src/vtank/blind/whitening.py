"""White residuals under the noise that a case truly has.

Sonar noise (white, or with a memory), rounding, turbulence and the tachometer's noise, which enters as thrust, make up
a linear model of what moves the ranges about the noise-free ones; its Kalman recursion turns correlated residuals into
white ones of unit variance, exactly as the Cholesky factor of their covariance would.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..compiled import law
from ..pilot.plan import Plan

Array = NDArray[np.float64]
SIZE = 5  # place, speed, turbulence, thrust by tachometer noise, coloured sonar noise


@dataclass(frozen=True)
class Whitener:
    """Gains of one run.

    Attributes:
        damping: rate at which a small change of speed dies away, shape (T,) [1/s].
        push: change of thrust by one deviation of the tachometer, shape (T,) [m/s2].
        deviation: stationary deviation of turbulence [m/s2], unit tachometer process and coloured sonar noise [m].
        memory: their correlation times [s]; 0 is white from tick to tick.
        variance: of the white part of a range [m2].
        period_s: tick [s].
    """

    damping: Array
    push: Array
    deviation: tuple[float, float, float]
    memory: tuple[float, float, float]
    variance: float
    period_s: float

    def whiten(self, columns: Array) -> Array:
        """White columns, shape (T, C), of `columns` (T, C) [m]; rows with NaN in the first column come back as zero."""
        out = np.zeros_like(columns)
        whiten(columns, self.damping, self.push, np.array(self.deviation), np.array(self.memory), self.variance,
               self.period_s, out)  # fmt: skip
        return out


def whitener(plan: Plan, sonar_memory_s: float, speed_m_s: Array, n_rev_s: Array) -> Whitener:
    """The noise of a run about a noise-free motion: speed and propeller speed at the ticks, shape (T,) each."""
    s, truth = plan.scenario, plan.truth
    rounding = s.sonar.resolution_m**2 / 12.0
    coloured = sonar_memory_s > 0.0
    lag = math.exp(-s.period_s / truth.tau_s) if truth.tau_s > 0.0 else 0.0
    smoothed = math.sqrt((1.0 - lag) / (1.0 + lag))  # of white noise through the lag
    return Whitener(
        damping=2.0 * abs(truth.alpha_per_m) * np.abs(speed_m_s),
        push=2.0 * truth.beta_m_per_rev2 * np.abs(n_rev_s) * s.tachometer.noise_rev_s,
        deviation=(s.turbulence.acceleration_m_s2, smoothed, s.sonar.noise_m if coloured else 0.0),
        memory=(s.turbulence.time_s, truth.tau_s, sonar_memory_s),
        variance=rounding + (1e-12 if coloured else s.sonar.noise_m**2) + 1e-12,
        period_s=s.period_s,
    )


@law
def whiten(columns, damping, push, deviation, memory, variance, period_s, out):  # type: ignore[no-untyped-def]
    """Innovations of the model of this module over their deviations, column by column."""
    h, count = period_s, columns.shape[1]
    P, F, state = np.zeros((SIZE, SIZE)), np.eye(SIZE), np.zeros((SIZE, count))
    for j in range(3):
        P[2 + j, 2 + j] = deviation[j] ** 2
        F[2 + j, 2 + j] = math.exp(-h / memory[j]) if memory[j] > 0.0 else 0.0
    for k in range(columns.shape[0]):
        if not math.isnan(columns[k, 0]):
            S = P[0, 0] + 2.0 * P[0, 4] + P[4, 4] + variance
            gain = (P[:, 0] + P[:, 4]) / S
            for c in range(count):
                e = columns[k, c] - state[0, c] - state[4, c]
                out[k, c] = e / math.sqrt(S)
                for j in range(SIZE):
                    state[j, c] += gain[j] * e
            row = P[0] + P[4]
            for j in range(SIZE):
                for m in range(SIZE):
                    P[j, m] -= gain[j] * row[m]
        decay = math.exp(-damping[k] * h)
        mean = (1.0 - decay) / damping[k] if damping[k] > 1e-9 else h
        F[0, 1], F[1, 1] = mean, decay
        F[0, 2], F[1, 2] = 0.5 * h * h, mean
        F[0, 3], F[1, 3] = 0.5 * h * h * push[k], mean * push[k]
        P = F @ P @ F.T
        for j in range(3):
            P[2 + j, 2 + j] += deviation[j] ** 2 * (1.0 - F[2 + j, 2 + j] ** 2)
        state = F @ state
