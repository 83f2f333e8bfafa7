"""What a model leaves unexplained: free-run simulation, the tables' statistics, coherence and whiteness.

Which residual the tables mean: the difference e between the measured speed and a *free run* of the identified model
driven by the propeller speed alone. Four things say so. Its deviation, 0.16 to 0.35 ft/s, is of the size of the speed
itself; the equation error z - h C of (12) is a second difference, about 0.05 ft/s on simulated records. Its mean goes
up to 0.17 ft/s; that of a second difference is next to nothing. Table 1 has no statistics where a is unstable: an
equation error would exist there, a free run diverges. And the figures set the measured velocity against the model's
response, with a phase lag between them. The sign, measured minus simulated, is assumed. The deviation is taken about
the mean: in Table 4, data set 1, it is below the mean absolute value, which a root mean square cannot be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from ..compiled import law
from ..plant.lumped import Lumped
from .paper.regression import Array

DIVERGED_M_S = 100.0  # a surge speed no vehicle reaches: the free run is given up there
LAGS = 20  # of the autocorrelation that is tested; a choice


@dataclass(frozen=True)
class ResidualStatistics:
    """Mean, deviation about the mean and mean absolute value [m/s]; NaN where the free run diverged."""

    mean: float
    deviation: float
    mean_absolute: float

    @property
    def rms(self) -> float:
        """Root mean square [m/s]."""
        return float(np.hypot(self.mean, self.deviation))


@law
def _free_run(n, step_s, alpha, beta, gamma, tau, u, z, limit):  # type: ignore[no-untyped-def]
    speed = np.full(n.size, np.nan)
    for k in range(n.size):
        if not np.abs(u) < limit:
            break
        speed[k] = u
        thrust = beta * n[k] * np.abs(n[k])
        if tau == 0.0:
            z = thrust
        u += step_s * (alpha * u * np.abs(u) + gamma * np.abs(n[k]) * u + z)
        if tau != 0.0:
            z += step_s / tau * (thrust - z)
    return speed


def free_run(n_rev_s: Array, step_s: float, parameters: Lumped, u_m_s: float, z_m_s2: float = 0.0) -> Array:
    """Surge speed [m/s], shape (K,), of the discrete model (6)-(7) driven by the propeller speed, shape (K,).

    Starts at speed u and lagged thrust acceleration z. Once the speed passes 100 m/s the rest is NaN: diverged.
    """
    p = parameters
    n = np.ascontiguousarray(n_rev_s, dtype=float)
    lumped = (p.alpha_per_m, p.beta_m_per_rev2, p.gamma_per_rev, p.tau_s)
    return _free_run(n, float(step_s), *lumped, float(u_m_s), float(z_m_s2), DIVERGED_M_S)


def free_run_beside(u_m_s: Array, n_rev_s: Array, step_s: float, parameters: Lumped) -> Array:
    """Free run from the first two measured speeds, shape (K,): what (10) needs to start, since z is not measured."""
    p, u0, n0 = parameters, u_m_s[0], n_rev_s[0]
    drag = p.alpha_per_m * u0 * abs(u0) + p.gamma_per_rev * u0 * abs(n0)
    return free_run(n_rev_s, step_s, p, u0, (u_m_s[1] - u0) / step_s - drag)


def residual_statistics(measured: Array, simulated: Array) -> ResidualStatistics:
    """The three rows at the foot of the paper's tables, for e = measured - simulated, both shape (K,) [m/s]."""
    diverged = np.isfinite(measured) & ~np.isfinite(simulated)
    error = (measured - simulated)[np.isfinite(measured)]
    if diverged.any() or error.size == 0:
        return ResidualStatistics(np.nan, np.nan, np.nan)
    return ResidualStatistics(float(error.mean()), float(error.std()), float(np.abs(error).mean()))


def residual_coherence(u_m_s: Array, error: Array, step_s: float, segments: int = 8) -> tuple[Array, Array]:
    """Frequencies [rad/s] and coherence between surge speed and residuals (Figures 3, 6, 8), Welch's method.

    Half-overlapping Hann segments; the record is cut so that about `segments` of them fit. The paper does not say
    how it averaged. Under independence the coherence is about 1 / segments, not 0.
    """
    from scipy.signal import coherence  # half a second, for reports alone

    length = max(2 * u_m_s.size // (segments + 1), 8)
    with np.errstate(invalid="ignore"):  # what does not move at all coheres with nothing
        frequency_hz, value = coherence(u_m_s, error, fs=1.0 / step_s, nperseg=min(length, u_m_s.size))
    return 2.0 * np.pi * frequency_hz, np.nan_to_num(value)


def whiteness(error: Array) -> float:
    """Chance of so much correlation in white residuals, shape (K,), by the Ljung-Box test of LAGS lags."""
    centred = error - error.mean()
    full = np.correlate(centred, centred, mode="full")[centred.size - 1 :]
    r = full[1 : LAGS + 1] / (full[0] or 1.0)  # nothing left is white
    k = np.arange(1, r.size + 1)
    statistic = float(centred.size * (centred.size + 2) * np.sum(r**2 / (centred.size - k)))
    return float(chdtrc(r.size, statistic))
