"""Turbulence as process noise, and a coloured error of the sonar: does the data ask for them, and how strong are they?

The disturbance is an Ornstein-Uhlenbeck acceleration among the states of the extended Kalman filter, the coloured error
one beside them; deviations and memories, and the white noise, are those that make the innovations most likely.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.optimize import minimize_scalar

from .first_guess import typical_acceleration
from .noise_likelihood import linearised, squares_and_logs
from .noise_search import COLOUR, DISTURBANCE, LEAST, NoiseSearch, Part
from .observed import CHANNELS
from .problem import Filtered, Noise, Problem

SPANS = (1, 4, 16, 64)  # samples over which successive residuals are added up to see whether they go together
SUSPICIOUS = 4.0  # deviations of a white sequence from which process noise is looked for; one chance in 10^4
MEMORY_S = (0.05, 60.0)  # [s] shortest and longest memory of a disturbance that are told from noise and from drift
USUAL_MEMORY_S, SPREAD = 1.0, 1.5  # [s, powers of e] prior of the memory: a weak disturbance does not tell it; a guess
SIZES = (np.exp(-25.0), np.exp(5.0))  # [m/s2] weakest and strongest disturbance that numbers bear


def colour(filtered: Sequence[Filtered]) -> float:
    """How far the residuals are from white: largest sum of autocorrelations over SPANS, in its own deviations."""
    products = np.zeros(SPANS[-1] + 1)
    for f in filtered:
        e = f.innovation / np.sqrt(f.variance)
        for lag in range(min(products.size, e.size)):
            products[lag] += float(e[lag:] @ e[: e.size - lag])
    count = sum(f.innovation.size for f in filtered)
    sums = np.cumsum(products[1:] / (products[0] or 1.0))  # nothing left is white
    return max(float(sums[span - 1]) * np.sqrt(count / span) for span in SPANS)


def measurement_noise(problem: Problem, filtered: Sequence[Filtered]) -> Noise:
    """Variance of each channel from its innovations, corrected for the unknowns fitted; the disturbance stays."""
    variance = list(problem.noise.variance)
    samples = sum(f.innovation.size for f in filtered)
    spent = samples / max(samples - problem.size, 1)
    for kind in CHANNELS.values():
        chosen = [(run.kind == kind) & problem.used(k) for k, run in enumerate(problem.runs)]
        pairs = zip(filtered, chosen, strict=True)
        normalised = np.concatenate([f.innovation[own] ** 2 / f.variance[own] for f, own in pairs])
        if normalised.size:
            variance[kind] = max(variance[kind] * float(np.mean(normalised)) * spent, LEAST)
    return replace(problem.noise, variance=tuple(variance))


def noise_level(
    problem: Problem, theta: np.ndarray, parts: tuple[Part, ...] = (DISTURBANCE,), hold_memory: bool = False
) -> Noise:
    """Measurement noise and the parts beside it, with their memories, that make the innovations at theta most likely.

    hold_memory: leave the memory of a disturbance as it is in the problem. Where the simulation runs away, the
    problem's own noise.
    """
    noise, likelihood = problem.noise, partial(squares_and_logs, linearised(problem, theta))
    search = NoiseSearch(likelihood, noise, SIZES, MEMORY_S, parts, partial(_usual, parts))
    first = {DISTURBANCE: 0.1 * typical_acceleration(problem.runs), COLOUR: float(np.sqrt(noise.variance[0]))}
    levels = [(getattr(noise, size) or first[size, memory], getattr(noise, memory)) for size, memory in parts]
    start = np.log(np.array(levels).ravel())
    if not hold_memory:
        return search.likeliest(start, (-0.3, 0.3) * len(parts), 60 * len(parts), 0.1, 0.1)[0]
    bounds = start[0] - 5.0, start[0] + 2.0
    x = minimize_scalar(lambda x: search.level(np.array([x, start[1]]))[1], bounds=bounds, options={"xatol": 0.2}).x
    return search.level(np.array([x, start[1]]))[0]


def _usual(parts: tuple[Part, ...], noise: Noise) -> float:
    """Log density of the memories of the parts of a noise beforehand."""
    away = [np.log(getattr(noise, memory) / USUAL_MEMORY_S) / SPREAD for _, memory in parts]
    return -0.5 * float(np.dot(away, away))
