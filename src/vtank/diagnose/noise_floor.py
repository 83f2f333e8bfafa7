"""One noise level for all hypotheses.

Left to itself, each hypothesis would call its own misfit noise. The level is therefore taken from the explanation
that needs the least of it and then holds for everybody: measurement variance, and an Ornstein-Uhlenbeck disturbance
for turbulence and wake, by the likelihood of the innovations.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from ..identify.problem import Noise, Problem
from .evidence import Fitted, Setting, evaluate

CONTENDERS = 3  # hypotheses whose own noise level is looked at
ROUNDS = 4  # alternations of fit and noise level
SETTLED = 0.2  # change of log sigma that no longer matters
LEAST_SIGMA = 1e-5  # [m/s2] disturbance too weak to matter over a run: 0.1 mm after 4 s


def noise_at(problem: Problem, theta: np.ndarray, evaluations: int = 60) -> Noise:
    """Noise level near the problem's own that makes the innovations at theta most likely."""
    noise = problem.noise
    start = np.array([0.0, np.log(max(noise.sigma, 10.0 * LEAST_SIGMA)), np.log(noise.correlation_time)])

    def level(q: np.ndarray) -> Noise:
        a, b, c = (float(v * np.exp(np.clip(q[0], -15.0, 15.0))) for v in noise.variance)
        sigma = float(np.exp(np.clip(q[1], np.log(LEAST_SIGMA), 3.0)))
        return Noise((a, b, c), sigma, float(np.exp(np.clip(q[2], np.log(0.2), np.log(30.0)))))

    def cost(q: np.ndarray) -> float:
        trial = problem.with_noise(level(q))
        value = -trial.log_likelihood(trial.filter(theta))
        return value if np.isfinite(value) else 1e12

    simplex = start + np.vstack([np.zeros(3), np.diag([-0.5, -1.0, 0.7])])
    options = {"maxfev": evaluations, "xatol": 0.05, "fatol": 0.3, "initial_simplex": simplex}
    return level(minimize(cost, start, method="Nelder-Mead", options=options).x)


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
