"""The four runs that are fitted, and a peer: scipy.optimize.least_squares on a roll-out in numba.

The peer is written as a user without vtank would write it: Model II, the same ranges and as many unknowns, alpha, beta,
tau, and for each run distance, speed and thrust at its start. Classical Runge-Kutta steps from one sample to the next;
the lag of the thrust is solved exactly. Derivatives are scipy's own finite differences.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numba
import numpy as np
from scipy.optimize import least_squares

from vtank.estimate.observed import Observed, observe
from vtank.experiment import plan_run, simulate_surge
from vtank.experiment.scenario import load_scenario
from vtank.plant.truth import load_truth
from vtank.studies.design import PAPER

TRUTH = load_truth("paper-ii").lumped
NAMES = ("alpha", "beta", "tau")
VALUES = dict(zip(NAMES, (TRUTH.alpha_per_m, TRUTH.beta_m_per_rev2, TRUTH.tau_s), strict=True))
START = tuple(1.3 * value for value in VALUES.values())  # where peers begin; vtank finds its own start


def four_runs() -> list[Observed]:
    """The four experiments with the sonar's noise; the tachometer exact, since the peers know no process noise."""
    scenarios = [load_scenario(name, ("tachometer.noise_rev_s=0",)) for name in PAPER]
    return [observe(result.run) for result in simulate_surge([plan_run(s, i) for i, s in enumerate(scenarios)])]


@numba.njit(cache=True)
def ranges(alpha, beta, tau, start, time, n, out):  # type: ignore[no-untyped-def]
    """Distances to the wall [m] at the stamps, shape (T,), from (distance, speed, thrust) at the first of them."""
    r, u, z = start
    for k in range(time.size):
        out[k] = r
        if k + 1 < time.size:
            h = time[k + 1] - time[k]
            goal, fade = beta * n[k] * abs(n[k]), math.exp(-0.5 * h / tau)
            middle = goal + (z - goal) * fade
            end = goal + (middle - goal) * fade
            a1 = alpha * u * abs(u) + z
            u2 = u + 0.5 * h * a1
            a2 = alpha * u2 * abs(u2) + middle
            u3 = u + 0.5 * h * a2
            a3 = alpha * u3 * abs(u3) + middle
            u4 = u + h * a3
            a4 = alpha * u4 * abs(u4) + end
            r -= h / 6.0 * (u + 2.0 * u2 + 2.0 * u3 + u4)
            u += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            z = end


def scipy_fit(runs: Sequence[Observed], start: Sequence[float]) -> np.ndarray:
    """alpha, beta, tau; started there, at each run's first range, and at rest."""
    ends = np.cumsum([0, *(run.value.size for run in runs)])
    residual = np.empty(ends[-1])

    def away(theta: np.ndarray) -> np.ndarray:
        for k, run in enumerate(runs):
            here = residual[ends[k] : ends[k + 1]]
            ranges(*theta[:3], theta[3 + 3 * k : 6 + 3 * k], run.time_s, run.input, here)
            here -= run.value
        return residual.copy()

    theta = np.concatenate([start, *([run.value[0], 0.0, 0.0] for run in runs)])
    return np.asarray(least_squares(away, theta, x_scale="jac", method="lm").x[:3])
