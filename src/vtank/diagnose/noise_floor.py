"""One noise level for all hypotheses.

Left to itself, each hypothesis would call its own misfit noise. The level is therefore taken from the explanation
that needs the least of it and then holds for everybody: measurement variance, and an Ornstein-Uhlenbeck disturbance
for turbulence and wake, by the likelihood of the innovations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from ..identify.problem import Noise, Problem
from .evidence import Fitted, Setting, evaluate

CONTENDERS = 2  # hypotheses whose own noise level is looked at
ROUNDS = 3  # alternations of fit and noise level
SETTLED = 0.2  # change of log sigma that no longer matters
LEAST_SIGMA = 1e-5  # [m/s2] disturbance too weak to matter over a run: 0.1 mm after 4 s
MEMORY_S = (0.2, 30.0)  # [s] shortest and longest memory of the disturbance that is looked for


def noise_at(problem: Problem, theta: np.ndarray, evaluations: int = 30) -> Noise:
    """Noise level near the problem's own that makes the innovations at theta most likely.

    The overall scale is concentrated out of the likelihood: what is searched are the disturbance over the measurement
    noise, and its memory.
    """
    noise = problem.noise

    def shape(q: np.ndarray) -> Noise:
        sigma = float(np.exp(np.clip(q[0], np.log(LEAST_SIGMA), 3.0)))
        return replace(noise, sigma=sigma, correlation_time=float(np.exp(np.clip(q[1], *np.log(MEMORY_S)))))

    def scale_and_cost(q: np.ndarray) -> tuple[float, float]:
        trial = problem.with_noise(shape(q))
        squares, logs, count = 0.0, 0.0, 0
        for k, f in enumerate(trial.filter(theta)):
            e, S = f.innovation[problem.used(k)], f.variance[problem.used(k)]
            squares, logs, count = squares + float(np.sum(e**2 / S)), logs + float(np.sum(np.log(S))), count + e.size
        cost = 0.5 * (count * np.log(squares / count) + logs)
        return squares / count, cost if np.isfinite(cost) else 1e12

    start = np.log([max(noise.sigma, 10.0 * LEAST_SIGMA), noise.correlation_time])
    simplex = start + np.array([[0.0, 0.0], [-1.0, 0.0], [0.0, 0.7]])
    options = {"maxfev": evaluations, "xatol": 0.05, "fatol": 0.3, "initial_simplex": simplex}
    best = minimize(lambda q: scale_and_cost(q)[1], start, method="Nelder-Mead", options=options).x
    scale, found = scale_and_cost(best)[0], shape(best)
    a, b, c = (float(v * scale) for v in found.variance)
    return Noise((a, b, c), max(found.sigma * float(np.sqrt(scale)), LEAST_SIGMA), found.correlation_time)


def settle(setting: Setting, fits: Sequence[Fitted]) -> Setting:
    """The setting at the noise level of the contender that, with its own level, is most likely."""
    ranked = sorted(fits, key=lambda f: -f.log_evidence)[:CONTENDERS]
    best: tuple[float, Noise] | None = None
    for fit in ranked:
        for _ in range(ROUNDS):
            noise = noise_at(fit.problem, fit.optimum.theta)
            change = abs(np.log(noise.sigma / max(fit.problem.noise.sigma, LEAST_SIGMA)))
            fit = evaluate(setting.with_noise(noise), fit.hypothesis, [fit.start()])
            if change < SETTLED:
                break
        if best is None or fit.log_evidence > best[0]:
            best = fit.log_evidence, noise
    assert best is not None
    return setting.with_noise(best[1])
