"""Maximum-likelihood identification of the surge model from all runs jointly.

The sonar's range is predicted and never differentiated; initial states are free; turbulence and a coloured error of the
sonar are handled by the innovations of an extended Kalman filter when the residuals ask for it, outliers by weights.
Gauss-Newton on the innovations with the filter's gains held and renewed (prediction-error method: Ljung, System
Identification, 1999, ch. 7 and 9); covariance from the Fisher information of all unknowns, initial states included.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from html import escape

import numpy as np

from ..errors import InputError
from ..plant.parameters import LAG, LOSS, LUMPED, unit_of, vector
from ..plant.surge import LINEAR_INPUT, thrust_target
from ..record.shown import html_table
from .first_guess import first_guesses, typical_acceleration
from .heavy_tails import heavy, information, reweighted, standardised
from .noise_search import COLOUR, DISTURBANCE, Part
from .observed import POSITION, RANGE, Observed
from .optimum import Optimum, Prior, descend
from .problem import Filtered, Problem
from .process_noise import SUSPICIOUS, colour, measurement_noise, noise_level

NORMAL95 = 1.959964  # [-] deviations to either side that hold 95 % of a normal distribution
MODELS: dict[str, tuple[str, ...]] = {"I": ("alpha", "beta"), "II": ("alpha", "beta", LAG), "III": LUMPED}
BOUNDS = {  # drag slows, thrust pushes; a lag below a fifth of the sampling period looks like any shorter one
    "alpha": (-np.inf, 0.0),
    "beta": (0.0, np.inf),
    LAG: (0.02, 60.0),
    LOSS: (-50.0, 5.0),
}
INSEPARABLE = 0.95  # |correlation| from which two parameters count as not separated, and
LOOSE = 0.05  # relative deviation that one of them must have besides; conventions, both
UNDETERMINED = 0.5  # relative standard deviation from which a parameter is reported as undetermined; a convention
FORGIVING = 0.3  # [-] disturbance that is forgiven at first, over the runs' own accelerations; a choice
WARM_UP = 2  # iterations beside the forgiving filter; a choice
STRAIGHT = 12  # iterations of pure simulation in which a first guess that needs no leading has arrived; a choice
APART = 5.0  # deviations between two optima that are not one; a choice
AGREED = 1e-3  # relative difference of the sums of squares at which two descents have found the same optimum
EXACT = 1e-5  # [m, m/s] residuals below this are errors of integration, and no turbulence
WORTHWHILE = 5.0  # gain in log-likelihood from which the two numbers of process noise are kept; a convention
MOST_TURNS, REWEIGHTED = 20, 20  # alternations of noise and parameters, and of weights and parameters; choices
SETTLED = 0.005  # gain in log-likelihood below which the noise level and the parameters agree


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

    def __repr__(self) -> str:
        """Shared parameters with their deviations, SI, and the runs."""
        found = ", ".join(f"{name} = {value:.4g} +- {self.sd[name]:.2g}" for name, value in self.values.items())
        runs = ", ".join(run.name for run in self.problem.runs)
        return f"Estimate({found}; {runs}{'' if self.converged else '; not converged'})"

    def _repr_html_(self) -> str:
        """The same as a table, for a notebook, with what the data cannot separate."""
        rows = []
        for name, value in self.values.items():
            low, high = self.interval95(name)
            unit = unit_of(name, self.problem.runs[0].input_name)
            rows.append((name, f"{value:.5g}", f"{self.sd[name]:.2g}", f"{low:.5g} to {high:.5g}", unit))
        warned = "" if self.converged else "not converged. "
        return html_table(("parameter", "value", "sd", "95 % interval", "unit"), rows) + (
            f"<p>{escape(warned + ' '.join(self.warnings))}</p>"
        )

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
        return value - NORMAL95 * sd, value + NORMAL95 * sd

    @property
    def correlation(self) -> np.ndarray:
        """Correlation of the shared parameters, shape (free, free)."""
        count = len(self.problem.free)
        return _correlation(self.covariance[:count, :count])

    def vector(self) -> np.ndarray:
        """Parameter vector with the estimates set, shape (P,)."""
        return vector(self.values, self.problem.base)

    def free_runs(self) -> list[Filtered]:
        """Residuals of pure simulation from the input and the estimated start, per run."""
        return self.problem.simulate(self.theta)

    def free_tracks(self) -> list[np.ndarray]:
        """States (x, u, z, wake, 0) of that simulation at the measurements, shapes (M, 5)."""
        return self.problem.track(self.theta, self.free_runs())

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

    base: parameter vector for what is not fitted (effects, stand-off); process_noise: True or False to force a
    disturbance or a coloured error of the sonar, None to look for them when the residuals are not white. Heavy tails
    are allowed for where there are any. InputError where the runs or the model do not go together.
    """
    base = vector({LAG: 0.0 if model == "I" else 0.5}, base)
    base[LINEAR_INPUT] = float(_common_input(runs) == "thrust_N")
    if model == "III" and base[LINEAR_INPUT]:
        raise InputError("Model III needs a propeller speed for its thrust loss; these runs have thrust_N")
    # with both, each run's stand-off matters, and is unknown
    tied = any({RANGE, POSITION} <= run.first.keys() for run in runs)
    problem = Problem(tuple(runs), base, MODELS[model], ("standoff",) if tied else ())
    with told_apart(problem.runs, "model's", "run "):
        return fit(problem, first_guesses(problem), process_noise)


@contextmanager
def told_apart(runs: Sequence[Observed], whose: str, first: str = "") -> Iterator[None]:
    """InputError where the linear algebra inside fails, because nothing in the runs speaks of some parameter."""
    try:
        yield
    except np.linalg.LinAlgError as error:
        raise InputError(
            f"{first}{', '.join(run.name for run in runs)}: the recordings do not tell the {whose} parameters apart "
            f"({error}); expected runs in which the vehicle speeds up and slows down"
        ) from error


def _common_input(runs: Sequence[Observed]) -> str:
    names = {run.input_name for run in runs}
    if len(names) != 1:
        listed = ", ".join(f"{run.name}: {run.input_name}" for run in runs)
        raise InputError(f"runs that are fitted together need the same input; found {listed or 'no run'}")
    return names.pop()


def fit(problem: Problem, guesses: Sequence[np.ndarray], process_noise: bool | None = None) -> Estimate:
    """The optimum, from as many of the first guesses of theta as it takes until one is beyond doubt."""
    prior = beforehand(problem, guesses[0])
    found = _output_error(problem, guesses, prior)
    end, elsewhere = found[0], _elsewhere(problem, found)
    plain, end = _weighted(problem.with_noise(problem.noise.calm()), end, prior)
    heard = set().union(*(run.first for run in problem.runs))
    exact = max(plain.noise.variance[kind] for kind in heard) <= EXACT**2
    calm, end = (plain, end) if exact else _robust(plain, end, prior)
    restless = not exact and colour(calm.filter(end.theta)) > SUSPICIOUS
    if process_noise or (process_noise is None and restless):
        turbulent, other = _robust(*_restless(plain, end, guesses[0], prior), prior)
        if process_noise or _likelihood(turbulent, other) > _likelihood(calm, end) + WORTHWHILE:
            return _estimate(turbulent, other, prior)
    return _estimate(calm, end, prior, elsewhere)


def refit(problem: Problem, guess: np.ndarray) -> Estimate:
    """The optimum near a guess of theta, at a noise level that is known already."""
    prior, before = beforehand(problem, guess), np.inf
    with told_apart(problem.runs, "model's", "run "):
        for _ in range(5):
            end = descend(problem, guess, prior, problem.filter(guess))
            if problem.noise.quiet or before - end.cost < SETTLED:
                break
            guess, before = end.theta, end.cost
        return _estimate(problem, end, prior)


@np.errstate(over="ignore", invalid="ignore")  # where the model runs away there is none
def _likelihood(problem: Problem, end: Optimum) -> float:
    found = problem.log_likelihood(problem.filter(end.theta))
    return found if np.isfinite(found) else -np.inf


def beforehand(problem: Problem, guess: np.ndarray) -> Prior:
    """Bounds of the parameters; and the lag holds about as much thrust at first as the run's own input could give it.

    Without the latter, a short lag's first state is as good as free, and drags the lag along.
    """
    low, high = np.full(problem.size, -np.inf), np.full(problem.size, np.inf)
    sd = np.full(problem.size, np.inf)
    for i, name in enumerate(problem.free):
        low[i], high[i] = BOUNDS.get(name, (-np.inf, np.inf))
    for k, run in enumerate(problem.runs):
        if problem.lagging:
            p, _ = problem.model(guess, k)
            most = float(np.max(np.abs(run.input)))
            sd[problem.own_slice(k).stop - 1] = max(thrust_target(0.0, most, p), -thrust_target(0.0, -most, p), 1e-6)
    return Prior(np.zeros(problem.size), sd, low, high)


def _forgiving(problem: Problem) -> Problem:
    """The problem beside a filter that forgives much.

    It predicts over a second or two only, where the innovations are nearly linear in the parameters: a descent in it
    leads into the right valley of the simulation over minutes, and stays near it where turbulence makes the simulation
    worthless.
    """
    return problem.with_noise(replace(problem.noise, sigma=FORGIVING * typical_acceleration(problem.runs)))


def _output_error(problem: Problem, guesses: Sequence[np.ndarray], prior: Prior) -> list[Optimum]:
    """Optima of pure simulation, the best first.

    Straight from the first guess where that leaves nothing to explain and the runs tell the parameters well; else led
    there from one guess after another, until two agree or, where all is told well, nothing is left to explain.
    """
    quiet = problem.with_noise(problem.noise.calm())
    found = [descend(quiet, guesses[0], prior, quiet.filter(guesses[0]), STRAIGHT)]
    sizes = np.maximum(np.abs(found[0].theta[: len(problem.free)]), 1e-12)
    told = found[0].converged and bool(np.all(_deviations(problem, found[0]) < LOOSE * sizes))
    if told and colour(quiet.filter(found[0].theta)) < SUSPICIOUS:
        return found
    forgiving, best = _forgiving(problem), np.inf
    for guess in guesses:
        warm = descend(forgiving, guess, prior, forgiving.filter(guess), WARM_UP)
        found.append(descend(quiet, warm.theta, prior, quiet.filter(warm.theta)))
        agree = abs(found[-1].cost - best) < AGREED * best
        best = min(found[-1].cost, best)
        found.sort(key=lambda end: end.cost)
        if agree or (told and colour(quiet.filter(found[0].theta)) < SUSPICIOUS):
            break
    return found


def _deviations(problem: Problem, end: Optimum) -> np.ndarray:
    """Deviations of the shared parameters at an optimum of pure simulation, shape (free,)."""
    size = np.sqrt(2.0 * end.cost / sum(run.value.size for run in problem.runs))  # of residuals, in supposed deviations
    return np.asarray(size * np.sqrt(np.diag(_inverse(end.information))[: len(problem.free)]))


def _elsewhere(problem: Problem, found: Sequence[Optimum]) -> tuple[str, ...]:
    """A warning of an optimum that is as good but for chance, with parameters that are others by far."""
    count, samples = len(problem.free), sum(run.value.size for run in problem.runs)
    here, sd = found[0].theta[:count], _deviations(problem, found[0])
    for other in found[1:]:
        behind = 0.5 * samples * np.log(max(other.cost, 1e-300) / max(found[0].cost, 1e-300))
        there = other.theta[:count]
        if other.converged and behind < WORTHWHILE and np.any(np.abs(there - here) > APART * sd):
            said = ", ".join(f"{name} = {value:.3g}" for name, value in zip(problem.free, there, strict=True))
            return (f"these runs are explained about as well by {said}; another excitation tells which",)
    return ()


def _weighted(problem: Problem, end: Optimum, prior: Prior) -> tuple[Problem, Optimum]:
    """The problem with the noise of each channel as it was found, and its optimum."""
    channels = set().union(*(run.first for run in problem.runs))
    for round in range(len(channels)):  # with a single channel its weight does not matter
        problem = problem.with_noise(measurement_noise(problem, problem.filter(end.theta)))
        if round + 1 < len(channels):
            end = descend(problem, end.theta, prior, problem.filter(end.theta))
    return problem, end


def _robust(problem: Problem, end: Optimum, prior: Prior) -> tuple[Problem, Optimum]:
    """The same under Student's t where the innovations have heavy tails: weights, level and parameters in turns."""
    filtered = problem.filter(end.theta)
    if not heavy(standardised(problem, filtered)):
        return problem, end
    before = -np.inf
    for _ in range(REWEIGHTED):
        problem = reweighted(problem, filtered)
        end = descend(problem, end.theta, prior, problem.filter(end.theta))
        filtered = problem.filter(end.theta)
        likelihood = problem.log_likelihood(filtered)
        if likelihood - before < SETTLED:
            break
        before = likelihood
    return problem, end


def _restless(calm: Problem, end: Optimum, guess: np.ndarray, prior: Prior) -> tuple[Problem, Optimum]:
    """The likeliest of fits with a disturbance, a coloured error of the sonar, or both; what is simple comes first.

    The search begins at the first guess, since rough water leads pure simulation astray, and with both, since a
    coloured error that is taken for a disturbance leads the filter astray. A coloured error alone is sought at the
    optimum of pure simulation as well.
    """
    forgiving = _forgiving(calm)
    near = _near(forgiving, guess, prior)
    filtered = forgiving.filter(near.theta)
    if heavy(standardised(forgiving, filtered)):  # what simulation leaves in rough water says nothing about outliers
        forgiving = reweighted(forgiving, filtered)
        calm = replace(forgiving, noise=forgiving.noise.calm())
    if not any(run.record.colour.any() for run in calm.runs):
        return _alternate(forgiving, near, prior, (DISTURBANCE,), 3)
    coloured = replace(forgiving.noise, colour_sigma=float(np.sqrt(forgiving.noise.variance[0])))
    both = forgiving.with_noise(coloured)
    both, near = _alternate(both, _near(both, guess, prior), prior, (DISTURBANCE, COLOUR))
    asked, found = _likelihood(both, near) - WORTHWHILE, (both, near)
    rough = both.with_noise(noise_level(both, near.theta, (DISTURBANCE,)))
    if _likelihood(rough, near) > asked:
        found = _alternate(rough, near, prior, (DISTURBANCE,))
        asked = _likelihood(*found)
    other = _alternate(calm, end, prior, (COLOUR,))
    return other if _likelihood(*other) > asked else found


def _near(problem: Problem, guess: np.ndarray, prior: Prior) -> Optimum:
    """Optimum of a problem from a guess."""
    return descend(problem, guess, prior, problem.filter(guess))


def _alternate(
    problem: Problem, end: Optimum, prior: Prior, parts: tuple[Part, ...], rough: int = 0
) -> tuple[Problem, Optimum]:
    """Alternate between the noise level (likelihood of the filter) and the parameters (gains held).

    parts: what the noise has beside its white part; rough: rounds in which memories are held.
    """
    for turn in range(MOST_TURNS):
        noise = noise_level(problem, end.theta, parts, turn < rough)
        if noise is problem.noise:
            break  # the simulation runs away: it says nothing about the noise
        problem = problem.with_noise(noise)
        filtered = problem.filter(end.theta)
        before = descend(problem, end.theta, prior, filtered, 0)
        end = descend(problem, end.theta, prior, filtered)
        if end.converged and turn >= rough and before.cost - end.cost < SETTLED:
            return problem, end
        problem = problem.with_noise(measurement_noise(problem, problem.filter(end.theta)))
    return problem, replace(end, converged=False)


def _estimate(problem: Problem, end: Optimum, prior: Prior, told: tuple[str, ...] = ()) -> Estimate:
    """The estimate at an optimum; told: warnings that the optimum itself does not give."""
    filtered = problem.filter(end.theta)
    J = problem.jacobian(end.theta, filtered)
    freedom = problem.noise.freedom
    each = 1.0 if np.isinf(freedom) else information(standardised(problem, filtered), freedom)
    covariance = _inverse(each * J.T @ J + np.diag(prior.weight))
    likelihood = problem.log_likelihood(filtered)
    if not np.isfinite(likelihood):
        why = "are input and measurements of one recording, and in the units that the header says?"
        raise InputError(f"the model runs away on these recordings, and its likelihood is no number; {why}")
    warnings = told + _warnings(problem, end.theta, covariance, end.converged)
    return Estimate(problem, end.theta, covariance, filtered, likelihood, end.converged, warnings)


def _inverse(information: np.ndarray) -> np.ndarray:
    """Inverse of a Fisher information, scaled first; directions without information get a very large variance."""
    scale = np.sqrt(np.maximum(np.diag(information), 1e-200))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    return (vectors / np.maximum(values, 1e-14)) @ vectors.T / np.outer(scale, scale)


def _correlation(covariance: np.ndarray) -> np.ndarray:
    sd = np.sqrt(np.diag(covariance))
    return covariance / np.outer(sd, sd)


def _warnings(problem: Problem, theta: np.ndarray, covariance: np.ndarray, converged: bool) -> tuple[str, ...]:
    """What the estimates do not say by themselves; parameters that are all well known may well be correlated."""
    out = [] if converged else ["the optimiser did not converge; the estimates are not to be trusted"]
    correlation = _correlation(covariance)
    loose = np.sqrt(np.diag(covariance)) / np.maximum(np.abs(theta), 1e-12)
    for i, name in enumerate(problem.free):
        low, high = BOUNDS.get(name, (-np.inf, np.inf))
        if theta[i] - low < 1e-6 or high - theta[i] < 1e-6:
            out.append(f"{name} has run into its bound at {theta[i]:.3g}")
        elif loose[i] > UNDETERMINED:
            out.append(f"{name} is not determined by these runs: {theta[i]:.3g} +- {loose[i] * abs(theta[i]):.2g}")
        for j in range(i):
            if abs(correlation[i, j]) > INSEPARABLE and max(loose[i], loose[j]) > LOOSE:
                pair = f"{problem.free[j]} and {name}"
                out.append(f"{pair} cannot be separated on these runs (correlation {correlation[i, j]:+.3f})")
    return tuple(out)
