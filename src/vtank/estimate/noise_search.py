"""The likeliest noise level: a search for the disturbance and the sensor's coloured error over the white noise.

The channels keep the ratio of their variances. Their common scale is not searched for: at a given ratio of disturbance
to measurement noise the innovations do not depend on it, and the likeliest scale is their mean square.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .problem import Noise
from .simplex import Walk, simplex

LEAST = 1e-14  # [m2, m2/s2] variance below which no measurement is believed
HOPELESS = 1e12  # cost of a level that makes no number of the innovations: the simulation has run away
# squares, logarithms and number at some levels, see `squares_and_logs`
Likelihood = Callable[[Sequence[Noise]], tuple[np.ndarray, np.ndarray, int]]
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
        log_prior: log density of a level beforehand, where something is known.
    """

    likelihood: Likelihood
    noise: Noise
    sizes: tuple[float, float]
    memories: tuple[float, float]
    parts: tuple[Part, ...] = (DISTURBANCE,)
    log_prior: Callable[[Noise], float] = lambda noise: 0.0

    def level(self, q: np.ndarray) -> tuple[Noise, float]:
        """Noise level at q, shape (2 parts,); and its cost: negative logarithm of likelihood and prior.

        Where the innovations are no numbers, `noise` itself, at the cost HOPELESS.
        """
        return levels([(self, q)])[0]

    def trial(self, q: np.ndarray) -> Noise:
        """Noise level at q but for the common scale."""
        low, high = np.log([self.sizes, self.memories]).T
        values = np.exp(np.clip(q.reshape(-1, 2), low, high)).ravel().tolist()
        return replace(self.noise.calm(), **dict(zip(sum(self.parts, ()), values, strict=True)))

    def judged(self, trial: Noise, squares: float, logs: float, count: int) -> tuple[Noise, float]:
        """A trial at its likeliest scale, and its cost; see `level`."""
        scale = squares / count
        cost = 0.5 * float(count * np.log(scale) + logs)
        if not np.isfinite(cost):
            return self.noise, HOPELESS
        variance = tuple(max(float(v * scale), LEAST) for v in trial.variance)
        root = float(np.sqrt(scale))
        sigma = max(trial.sigma * root, self.sizes[0]) if DISTURBANCE in self.parts else 0.0
        found = replace(trial, variance=variance, sigma=sigma, colour_sigma=trial.colour_sigma * root)
        return found, cost - self.log_prior(found)

    def walk(self, origin: np.ndarray, steps: Sequence[float], evaluations: int, close: float, even: float) -> Walk:
        """The way of a simplex down from `origin`, see `likeliest`."""
        return simplex(origin + np.vstack([0.0 * origin, np.diag(steps)]), evaluations, close, even)

    def likeliest(
        self, origin: np.ndarray, steps: Sequence[float], evaluations: int, close: float, even: float
    ) -> tuple[Noise, float]:
        """Likeliest level near `origin`, and its cost.

        steps: first steps; it ends after so many evaluations, or once the levels are this close and their costs even.
        """
        return together([(self, self.walk(origin, steps, evaluations, close, even))])[0]


def levels(wanted: Sequence[tuple[NoiseSearch, np.ndarray]]) -> list[tuple[Noise, float]]:
    """Noise levels of searches for the same likelihood, and their costs, in one go; see `NoiseSearch.level`."""
    trials = [search.trial(q) for search, q in wanted]
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # the simulation may run away
        squares, logs, count = wanted[0][0].likelihood(trials)
        parts = zip(wanted, trials, squares, logs, strict=True)
        return [search.judged(trial, s, log, count) for (search, _), trial, s, log in parts]


def together(searches: Sequence[tuple[NoiseSearch, Walk]]) -> list[tuple[Noise, float]]:
    """The likeliest level of each of several searches for the same likelihood, made in step."""
    asked = {i: next(walk) for i, (_, walk) in enumerate(searches)}
    ends: dict[int, np.ndarray] = {}
    while asked:
        found = iter(levels([(searches[i][0], q) for i, points in asked.items() for q in points]))
        for i, points in list(asked.items()):
            try:
                asked[i] = searches[i][1].send([next(found)[1] for _ in points])
            except StopIteration as end:
                ends[i] = end.value
                del asked[i]
    return levels([(search, ends[i]) for i, (search, _) in enumerate(searches)])
