"""Turbulence as process noise: does the data ask for it, and how strong is it?

The disturbance is an Ornstein-Uhlenbeck acceleration among the states of the extended Kalman filter; its deviation
and memory, and the measurement noise, are those that make the innovations most likely.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from .first_guess import typical_acceleration
from .noise_likelihood import linearised, squares_and_logs
from .observed import CHANNELS
from .problem import Filtered, Noise, Problem

LEAST = 1e-14  # [m2, m2/s2] variance below which no measurement is believed
SPANS = (1, 4, 16, 64)  # samples over which successive residuals are added up to see whether they go together
SUSPICIOUS = 4.0  # deviations of a white sequence from which process noise is looked for; one chance in 10^4
MEMORY_S = (0.05, 60.0)  # [s] shortest and longest memory of a disturbance that are told from noise and from drift
USUAL_MEMORY_S, SPREAD = 1.0, 1.5  # [s, powers of e] prior of the memory: a weak disturbance does not tell it; a guess
SIMPLEX = np.array([[0.0, 0.0], [-0.3, 0.0], [0.0, 0.3]])  # first steps of the search, in powers of e


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
    return replace(problem.noise, variance=(variance[0], variance[1], variance[2]))


def noise_level(problem: Problem, theta: np.ndarray, hold_memory: bool = False) -> Noise:
    """Measurement noise, disturbance and its memory that make the innovations at theta most likely.

    The channels keep the ratio of their variances. Their common scale is not searched for: at a given ratio of
    disturbance to measurement noise the innovations do not depend on it, and the likeliest scale is their mean square.
    hold_memory: leave the memory as it is in the problem.
    """
    noise = problem.noise
    runs = linearised(problem, theta)
    start = np.log([noise.sigma or 0.1 * typical_acceleration(problem.runs), noise.correlation_time])

    def level(q: np.ndarray) -> tuple[Noise, float]:
        memory = float(np.clip(np.exp(q[1]), *MEMORY_S))
        trial = replace(noise, sigma=float(np.exp(np.clip(q[0], -25.0, 5.0))), correlation_time=memory)
        squares, logs, count = squares_and_logs(runs, trial)
        scale = squares / count
        a, b, c = (max(scale * v, LEAST) for v in noise.variance)
        cost = 0.5 * float(count * np.log(scale) + logs + (np.log(memory / USUAL_MEMORY_S) / SPREAD) ** 2)
        return Noise((a, b, c), trial.sigma * float(np.sqrt(scale)), memory), cost

    if hold_memory:
        weakest, strongest = start[0] - 5.0, start[0] + 2.0
        found = minimize_scalar(
            lambda x: level(np.array([x, start[1]]))[1], bounds=(weakest, strongest), options={"xatol": 0.2}
        )
        return level(np.array([found.x, start[1]]))[0]
    options = {"maxfev": 60, "xatol": 0.1, "fatol": 0.1, "initial_simplex": start + SIMPLEX}
    return level(minimize(lambda q: level(q)[1], start, method="Nelder-Mead", options=options).x)[0]
