"""The likeliest noise level: a search for the disturbance and the sensor's coloured error over the white noise.

The channels keep the ratio of their variances. Their common scale is not searched for: at a given ratio of disturbance
to measurement noise the innovations do not depend on it, and the likeliest scale is their mean square.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize

from .problem import Noise

LEAST = 1e-14  # [m2, m2/s2] variance below which no measurement is believed
HOPELESS = 1e12  # cost of a level that makes no number of the innovations: the simulation has run away
Likelihood = Callable[[Noise], tuple[float, float, int]]  # squares, logarithms and number, see squares_and_logs
DISTURBANCE, COLOUR = ("sigma", "correlation_time"), ("colour_sigma", "colour_time")  # parts: deviation and memory
Part = tuple[str, str]


@dataclass(frozen=True)
class NoiseSearch:
    """What a search for a noise level is given; levels are logarithms q: sizes and memories in turns.

    Attributes:
        likelihood: of the innovations at a noise level.
        noise: ratio of the channels' variances.
        sizes: least and largest deviation of the disturbance [m/s2] and of the coloured error [m].
        memories: shortest and longest of their memories [s].
        parts: what the noise has beside its white part, as q tells them.
        usual: memory [s] and its spread [powers of e] beforehand, where something is known.
    """

    likelihood: Likelihood
    noise: Noise
    sizes: tuple[float, float]
    memories: tuple[float, float]
    parts: tuple[Part, ...] = (DISTURBANCE,)
    usual: tuple[float, float] = (1.0, np.inf)

    def level(self, q: np.ndarray) -> tuple[Noise, float]:
        """Noise level at q, shape (2 parts,); and its negative log-likelihood.

        Where the innovations are no numbers, `noise` itself, at the cost HOPELESS.
        """
        size = np.exp(np.clip(q[0::2], *np.log(self.sizes)))
        memory = np.exp(np.clip(q[1::2], *np.log(self.memories)))
        levels = dict(zip(sum(self.parts, ()), np.column_stack([size, memory]).ravel().tolist(), strict=True))
        trial = replace(self.noise.calm(), **levels)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # the simulation may run away
            squares, logs, count = self.likelihood(trial)
            scale = squares / count
            strange = np.log(memory / self.usual[0]) / self.usual[1]
            cost = 0.5 * float(count * np.log(scale) + logs + strange @ strange)
        if not np.isfinite(cost):
            return self.noise, HOPELESS
        variance = tuple(max(float(v * scale), LEAST) for v in trial.variance)
        root = float(np.sqrt(scale))
        sigma = max(trial.sigma * root, self.sizes[0]) if DISTURBANCE in self.parts else 0.0
        return replace(trial, variance=variance, sigma=sigma, colour_sigma=trial.colour_sigma * root), cost

    def likeliest(
        self, origin: np.ndarray, steps: Sequence[float], evaluations: int, close: float, even: float
    ) -> tuple[Noise, float]:
        """Likeliest level near `origin`, and its cost, by the simplex of Nelder and Mead, J. Computing 7 (1965).

        steps: first steps; it ends after so many evaluations, or once the levels are this close and their costs even.
        """
        simplex = origin + np.vstack([0.0 * origin, np.diag(steps)])
        options = {"maxfev": evaluations, "xatol": close, "fatol": even, "initial_simplex": simplex}
        found = minimize(lambda q: self.level(q)[1], origin, method="Nelder-Mead", options=options)
        return self.level(found.x)
