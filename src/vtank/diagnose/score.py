"""Score tests: what an effect promises on top of a fitted hypothesis, without fitting it.

The innovations are linearised around the optimum; what the free parameters can take up is projected out of the
effect's column, and the rest is compared with the innovations that are left (Rao's score test).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from scipy.linalg import block_diag

from ..effects.catalogue import PARAMETERS
from ..plant.parameters import slot
from . import outliers
from .evidence import Fitted, Setting, Start
from .hypothesis import starting_values
from .lines import loudest

PROBE_M_S = 1e-3  # amplitude of the probing wave, small enough to be linear
TRIES = 2  # frequencies handed to the optimiser


@dataclass(frozen=True)
class Linearised:
    """A fit near its optimum.

    Attributes:
        fit: the fit.
        residual: innovations over their deviations, all runs, shape (sum M,).
        jacobian: their derivatives with respect to all unknowns, shape (sum M, size).
    """

    fit: Fitted
    residual: np.ndarray
    jacobian: np.ndarray

    @cached_property
    def information(self) -> np.ndarray:
        """Information about all unknowns, priors included, shape (size, size)."""
        return np.asarray(self.jacobian.T @ self.jacobian + np.diag(self.fit.prior.sd**-2))

    def remaining(self, columns: np.ndarray) -> np.ndarray:
        """What the fit's own parameters, held by their priors, cannot take up of columns (sum M, K)."""
        return projected_out(columns, self.jacobian, self.information)

    def explain(self, columns: np.ndarray) -> tuple[float, np.ndarray]:
        """Drop of half the sum of squares, and best coefficients, of columns (sum M, K) beside the fit's parameters."""
        rest = self.remaining(columns)
        A, b = columns.T @ rest, -rest.T @ self.residual
        scale = np.sqrt(np.maximum(np.diag(A), 1e-30))
        coefficients = np.linalg.lstsq(A / np.outer(scale, scale), b / scale, rcond=1e-8)[0] / scale
        return 0.5 * float(b @ coefficients), coefficients


def projected_out(columns: np.ndarray, jacobian: np.ndarray, information: np.ndarray) -> np.ndarray:
    """What nuisance parameters cannot take up of columns, shape (sum M,) or (sum M, K).

    jacobian: of the same residuals, shape (sum M, size); information: of the nuisance parameters, shape (size, size).
    """
    return np.asarray(columns - jacobian @ np.linalg.solve(information, jacobian.T @ columns))


def linearise(fit: Fitted) -> Linearised:
    """Residuals and derivatives of a fit at its optimum."""
    theta = fit.optimum.theta
    return Linearised(fit, *fit.problem.linearise(theta, fit.filtered))


def score(setting: Setting, near: Linearised, second: Fitted, refit: float) -> tuple[float, Start]:
    """Log-likelihood that the effect of `second` promises on top of a fit, and the values at which it does.

    refit: log evidence of the refit alone.
    """
    (effect,) = second.hypothesis.effects
    own: Start = {k: v for k, v in second.start().items() if k in effect.slots()}
    if all(q.counted for q in effect.parameters):
        return outliers.judged(effect, np.empty(0), setting.runs, near.fit.filtered)[0], own
    if effect.outliers:
        return max(second.log_evidence - refit, 0.0), own
    starts: list[Start] = [own]
    starts += [{**values} for values in starting_values(effect, setting.runs)]
    columns = _shifted(near.fit, starts) - near.residual[:, None]
    gains = [near.explain(column[:, None])[0] for column in columns.T]
    tried = [(0.0, own), *zip(gains, starts, strict=True), *(scan(near, effect.wave) if effect.wave else ())]
    return max(tried, key=lambda found: found[0])


def _shifted(fit: Fitted, starts: Sequence[Start]) -> np.ndarray:
    """Residuals of the fit with an effect added at the values of each of L starts, shape (sum M, L)."""
    problem, parts = fit.problem, []
    for k, f in enumerate(fit.filtered):
        p = np.repeat(problem.model(fit.optimum.theta, k)[0][:, None], len(starts), axis=1)
        for lane, start in enumerate(starts):
            for name, value in start.items():
                p[slot(name), lane] = np.broadcast_to(value, len(problem.runs))[k]
        parts.append(problem.varied(fit.optimum.theta, f, k, p=p))
    return np.concatenate(parts)


def scan(near: Linearised, wave: tuple[str, str, str]) -> list[tuple[float, Start]]:
    """Frequencies at which a wave explains most on top of a fit: how much, and its first guesses by slot."""
    _, pace, _ = wave
    rad_s = loudest(near.fit).within(*PARAMETERS[pace].bounds).rad_s
    rows = np.cumsum([f.innovation.size for f in near.fit.filtered])[:-1]
    tried = product(rad_s, (0.0, 0.5 * np.pi))
    probes: list[Start] = [dict(zip(wave, (PROBE_M_S, float(w), phase), strict=True)) for w, phase in tried]
    parts = np.split((_shifted(near.fit, probes) - near.residual[:, None]) / PROBE_M_S, rows) if probes else []
    found = []
    for j, frequency in enumerate(rad_s):
        gain, c = near.explain(block_diag(*(part[:, 2 * j : 2 * j + 2] for part in parts)))
        found.append((gain, float(frequency), c.reshape(len(parts), 2)))
    out: list[tuple[float, Start]] = []
    for gain, frequency, c in sorted(found, key=lambda f: -f[0])[:TRIES]:
        amplitude = float(np.sqrt(np.mean(np.sum(c**2, axis=1))))
        phase = np.arctan2(c[:, 1], c[:, 0])
        out.append((gain, dict(zip(wave, (amplitude, frequency, phase), strict=True))))
    return out
