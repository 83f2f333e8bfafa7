"""Maximum-likelihood identification of the surge model from all runs jointly.

The sonar's range is predicted and never differentiated; initial states are free; turbulence is handled by the
innovations of an extended Kalman filter when the residuals ask for it. Gauss-Newton on the innovations with the
filter's gains held and renewed (prediction-error method: Ljung, System Identification, 1999, ch. 7 and 9); covariance
from the Fisher information of all unknowns, initial states included.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares, minimize

from ..dynamics.parameters import slot, vector
from .observed import POSITION, RANGE, SPEED, Observed
from .problem import Filtered, Noise, Problem

MODELS: dict[str, tuple[str, ...]] = {
    "I": ("alpha", "beta"),
    "II": ("alpha", "beta", "thrust_lag.tau"),
    "III": ("alpha", "beta", "thrust_loss.gamma", "thrust_lag.tau"),
}
BOUNDS = {"thrust_lag.tau": (1e-3, 60.0), "thrust_loss.gamma": (-50.0, 5.0)}
INSEPARABLE = 0.95  # |correlation| from which two parameters are reported as not separable; a convention
UNDETERMINED = 0.5  # relative standard deviation from which a parameter is reported as undetermined; a convention
WHITE = 0.2  # lag-one correlation of the residuals from which process noise is looked for; a convention


@dataclass(frozen=True)
class Estimate:
    """Parameters with their uncertainty.

    Attributes:
        problem: the problem at the noise level found.
        theta: all unknowns at the optimum.
        covariance: of theta, shape (size, size).
        filtered: innovations, variances and gains per run.
        log_likelihood: of the innovations.
        converged: whether the optimiser stopped at an optimum.
        warnings: what the data cannot separate or determine, in plain sentences.
    """

    problem: Problem
    theta: np.ndarray
    covariance: np.ndarray
    filtered: list[Filtered]
    log_likelihood: float
    converged: bool
    warnings: tuple[str, ...]

    @property
    def values(self) -> dict[str, float]:
        """Shared parameters by name, SI."""
        return {name: float(self.theta[i]) for i, name in enumerate(self.problem.free)}

    @property
    def sd(self) -> dict[str, float]:
        """Their standard deviations."""
        return {name: float(np.sqrt(self.covariance[i, i])) for i, name in enumerate(self.problem.free)}

    def interval95(self, name: str) -> tuple[float, float]:
        """95 % interval of a shared parameter (normal)."""
        value, sd = self.values[name], self.sd[name]
        return value - 1.959964 * sd, value + 1.959964 * sd

    @property
    def correlation(self) -> np.ndarray:
        """Correlation of the shared parameters, shape (free, free)."""
        count = len(self.problem.free)
        return _correlation(self.covariance[:count, :count])

    def vector(self) -> np.ndarray:
        """Parameter vector with the estimates set, shape (P,)."""
        return vector(self.values, self.problem.base)

    def rms(self, kind: int) -> float:
        """Root mean square of the innovations of one channel [m or m/s]; NaN where it was not measured."""
        parts = [f.innovation[run.kind == kind] for f, run in zip(self.filtered, self.problem.runs, strict=True)]
        e = np.concatenate(parts)
        return float(np.sqrt(np.mean(e**2))) if e.size else float("nan")


def identify(
    runs: Sequence[Observed],
    model: str = "II",
    base: np.ndarray | None = None,
    process_noise: bool | None = None,
) -> Estimate:
    """Fit Model I, II or III to all runs jointly.

    base: parameter vector for what is not fitted (effects, stand-off); process_noise: True or False to force it,
    None to look for it when the residuals are not white.
    """
    base = vector({} if model == "I" else {"thrust_lag.tau": 0.5}, base)
    base[slot("linear_input")] = float(runs[0].input_name == "thrust_N")
    problem = Problem(tuple(runs), base, MODELS[model])
    return fit(problem, first_guesses(problem), process_noise)


def fit(problem: Problem, guesses: Sequence[np.ndarray], process_noise: bool | None = None) -> Estimate:
    """Best optimum from several first guesses of theta."""
    best = min((_output_error(problem, guess) for guess in guesses), key=lambda result: result[1])
    theta, _, converged = best
    problem = problem.with_noise(_measurement_noise(problem, theta))
    if process_noise or (process_noise is None and _lag_one(problem.filter(theta)) > WHITE):
        problem, theta, converged = _with_process_noise(problem, theta)
    return _estimate(problem, theta, converged)


def first_guesses(problem: Problem, count: int = 2) -> list[np.ndarray]:
    """Best points of a coarse grid over drag, thrust and lag, scaled to the runs' speeds and inputs."""
    speed, acceleration, square = _scales(problem.runs, bool(problem.base[slot("linear_input")]))
    simulated = problem.filter(problem.initial())
    found = []
    for length in (0.1, 0.3, 1.0, 3.0, 10.0, 30.0):  # [m] 1/|alpha|
        for tau in (0.1, 0.5, 2.0) if problem.has_lag else (0.0,):
            for factor in (0.5, 1.0, 2.0):
                beta = factor * (speed**2 / length + acceleration) / square
                p = vector({"alpha": -1.0 / length, "beta": beta, "thrust_lag.tau": tau}, problem.base)
                theta = problem.initial(p)
                found.append((float(np.sum(problem.residuals(theta, simulated) ** 2)), theta))
    return [theta for _, theta in sorted(found, key=lambda item: item[0])[:count]]


def _scales(runs: Sequence[Observed], linear: bool) -> tuple[float, float, float]:
    """Rms speed [m/s], rms acceleration [m/s2] and rms input (squared unless linear), from differences over 1 s."""
    speeds, accelerations, inputs = [], [], []
    for run in runs:
        grid = np.arange(run.time_s[0], run.time_s[-1], 1.0)
        kind = next(kind for kind in (RANGE, POSITION, SPEED) if np.any(run.kind == kind))
        chosen = run.kind == kind
        track = np.interp(grid, run.time_s[chosen], run.value[chosen])
        speed = track if kind == SPEED else np.diff(track)
        speeds.append(speed)
        accelerations.append(np.diff(speed))
        inputs.append(run.input if linear else run.input**2)
    rms = [max(float(np.sqrt(np.mean(np.concatenate(x) ** 2))), 1e-6) for x in (speeds, accelerations, inputs)]
    return rms[0], rms[1], rms[2]


def _bounds(problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    low, high = np.full(problem.size, -np.inf), np.full(problem.size, np.inf)
    for i, name in enumerate(problem.free):
        low[i], high[i] = BOUNDS.get(name, (-np.inf, np.inf))
    return low, high


def _solve(problem: Problem, theta: np.ndarray, filtered: Sequence[Filtered]) -> tuple[np.ndarray, float, bool]:
    low, high = _bounds(problem)
    result = least_squares(
        problem.residuals,
        np.clip(theta, low + 1e-12, high - 1e-12),
        problem.jacobian,
        bounds=(low, high),
        method="dogbox",
        x_scale="jac",
        ftol=1e-7,
        xtol=1e-9,
        gtol=1e-9,
        max_nfev=100,
        args=(filtered,),
    )
    return result.x, float(2.0 * result.cost), bool(result.success)


def _output_error(problem: Problem, theta: np.ndarray) -> tuple[np.ndarray, float, bool]:
    quiet = problem.with_noise(replace(problem.noise, sigma=0.0))
    return _solve(quiet, theta, quiet.filter(theta))


def _measurement_noise(problem: Problem, theta: np.ndarray) -> Noise:
    """Variance of each channel from the residuals, corrected for the unknowns fitted."""
    filtered = problem.filter(theta)
    variance = list(problem.noise.variance)
    total = sum(f.innovation.size for f in filtered)
    for kind in (RANGE, POSITION, SPEED):
        e = np.concatenate([f.innovation[run.kind == kind] for f, run in zip(filtered, problem.runs, strict=True)])
        if e.size:
            variance[kind] = max(float(np.mean(e**2)) * total / max(total - problem.size, 1), 1e-14)
    return replace(problem.noise, variance=(variance[0], variance[1], variance[2]))


def _lag_one(filtered: Sequence[Filtered]) -> float:
    """Correlation of successive residuals; white noise gives zero."""
    pairs = sum(float(np.dot(f.innovation[1:], f.innovation[:-1])) for f in filtered)
    return pairs / sum(float(np.dot(f.innovation, f.innovation)) for f in filtered)


def _with_process_noise(problem: Problem, theta: np.ndarray) -> tuple[Problem, np.ndarray, bool]:
    """Alternate between the noise level (likelihood of the filter) and the parameters (gains held)."""
    converged = False
    for _ in range(6):
        problem = problem.with_noise(noise_level(problem, theta))
        previous = theta
        theta, _, converged = _solve(problem, theta, problem.filter(theta))
        spread = np.abs(problem.jacobian(theta, problem.filter(theta))).sum(axis=0)
        if np.all(np.abs(theta - previous) * spread < 0.3 * np.sqrt(problem.filter(theta)[0].innovation.size)):
            break
    return problem, theta, converged


def noise_level(problem: Problem, theta: np.ndarray) -> Noise:
    """Measurement variance, disturbance and its memory that make the innovations at theta most likely."""
    noise = problem.noise
    _, acceleration, _ = _scales(problem.runs, False)
    start = np.log([0.3, max(noise.sigma, 0.1 * acceleration), noise.correlation_time])

    def level(q: np.ndarray) -> Noise:
        scale, sigma, memory = np.exp(np.clip(q, -20.0, 5.0))
        a, b, c = (scale * v for v in noise.variance)
        return Noise((a, b, c), float(sigma), float(np.clip(memory, 0.05, 60.0)))

    def cost(q: np.ndarray) -> float:
        trial = problem.with_noise(level(q))
        return -trial.log_likelihood(trial.filter(theta))

    result = minimize(cost, start, method="Nelder-Mead", options={"maxfev": 150, "xatol": 0.02, "fatol": 0.05})
    return level(result.x)


def _estimate(problem: Problem, theta: np.ndarray, converged: bool) -> Estimate:
    filtered = problem.filter(theta)
    J = problem.jacobian(theta, filtered)
    covariance = _inverse(J.T @ J)
    return Estimate(
        problem,
        theta,
        covariance,
        filtered,
        problem.log_likelihood(filtered),
        converged,
        _warnings(problem, theta, covariance, converged),
    )


def _inverse(information: np.ndarray) -> np.ndarray:
    """Inverse of a Fisher information, scaled first; directions without information get a very large variance."""
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    return (vectors / np.maximum(values, 1e-14)) @ vectors.T / np.outer(scale, scale)


def _correlation(covariance: np.ndarray) -> np.ndarray:
    sd = np.sqrt(np.diag(covariance))
    return covariance / np.outer(sd, sd)


def _warnings(problem: Problem, theta: np.ndarray, covariance: np.ndarray, converged: bool) -> tuple[str, ...]:
    out = [] if converged else ["the optimiser did not converge; the estimates are not to be trusted"]
    correlation, sd = _correlation(covariance), np.sqrt(np.diag(covariance))
    for i, name in enumerate(problem.free):
        if sd[i] > UNDETERMINED * abs(theta[i]):
            out.append(f"{name} is not determined by these runs: {theta[i]:.3g} +- {sd[i]:.2g}")
        low, high = BOUNDS.get(name, (-np.inf, np.inf))
        if theta[i] - low < 1e-6 or high - theta[i] < 1e-6:
            out.append(f"{name} has run into its bound at {theta[i]:.3g}")
        for j in range(i):
            if abs(correlation[i, j]) > INSEPARABLE:
                pair = f"{problem.free[j]} and {name}"
                out.append(f"{pair} cannot be separated on these runs (correlation {correlation[i, j]:+.3f})")
    return tuple(out)
