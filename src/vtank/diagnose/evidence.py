"""Evidence of every hypothesis on the same data with the same noise.

Laplace's approximation of the marginal likelihood: optimum, priors and the information about all unknowns, initial
states included. Each effect's prior is set in gap units: whatever its unit, the prior makes the same change of the
simulated output (root mean square) as large as the gap that is to be explained. Where a parameter has run into the
null, the Gaussian is continued beyond and cut off there.
MacKay, Information Theory, Inference, and Learning Algorithms (2003), ch. 27 and 28.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..effects.effect import Parameter
from ..estimate.innovations import simulated
from ..estimate.observed import Observed
from ..estimate.optimum import Optimum, Prior, climb
from ..estimate.problem import Filtered, Noise, Problem
from ..plant.parameters import LAG, LINEAR_DRAG, indices, slot, vector
from . import outliers
from .bounds import within
from .hypothesis import Hypothesis, largest_input, nuisance, starting_values, stretch, typical

NUISANCE_SPREAD = 0.5  # prior deviation of the nominal's own parameters over their size; a guess, wide on purpose
LEAST = 1e-9  # of a first guess, in its unit: what was found to be nothing stays nothing, and its prior finite
FOREIGN_SPREAD = 10.0  # the same where the nominal is but the recordings' own refit: next to no prior
VISIBLE_LIMIT = 0.99  # share of the largest input above which a saturation touches too few samples to be seen
OFFSET_SPREAD = 0.2  # prior deviation of a measured force's offset over the largest force; a choice
SPIKE_SPREAD = 0.5  # prior deviation of the size of spikes over that of the lone readings; a choice
LOST = 1e200  # [m2 or m2/s2] variance of a measurement whose own is lost to rounding: it counts for nothing
STILL_SIGMA = 1e-3  # [m/s2] disturbance of still water: what a vehicle leaves and meets again in a tank; a guess
LOWEST = {LAG: 1e-3, LINEAR_DRAG: 0.0}  # [s], [1/s] of own parameters: no lag of nothing, no drag that drives
START_SD = np.array([1.0, 0.3, 0.3])  # [m, m/s, m/s2] prior of the initial state (x, u, z)


Start = dict[str, float | np.ndarray]  # first guesses by slot name; arrays hold one value per run
STATES = "initial state"  # key of the initial states (x, u, z, wake) in a first guess, shape (runs, 4)


@dataclass(frozen=True)
class Setting:
    """What all hypotheses share.

    Attributes:
        runs: the observed runs.
        nominal: parameter vector of the nominal simulator, shape (P,).
        noise: shared noise level.
        gap: size of the gap to be explained, root mean square of the simulated output [m or m/s].
        flags: per run, the measurements that are lone outliers, shape (M,) of bool.
        weight: per run, the factor on each measurement's variance (FLAGGED: left out), shape (M,).
        foreign: whether the nominal is but the recordings' own refit, a first guess.
        usual: disturbance that is no surprise in this water [m/s2].
    """

    runs: tuple[Observed, ...]
    nominal: np.ndarray
    noise: Noise
    gap: float
    flags: tuple[np.ndarray, ...]
    weight: tuple[np.ndarray, ...]
    foreign: bool = False
    usual: float = STILL_SIGMA

    def with_noise(self, noise: Noise) -> Setting:
        """The same setting at another noise level."""
        return replace(self, noise=noise)


@dataclass(frozen=True)
class Fitted:
    """A hypothesis fitted to the runs, with its evidence.

    Attributes:
        hypothesis: what was fitted.
        problem: runs, free parameters and noise.
        prior: priors and bounds of all unknowns.
        optimum: where the fit ended.
        filtered: innovations at the optimum.
        log_likelihood: of the innovations and of the outliers; -inf where the model runs away.
        log_evidence: the same with parameters integrated out.
        extra: estimates that are not slots of the optimiser (outlier effects), by slot name.
    """

    hypothesis: Hypothesis
    problem: Problem
    prior: Prior
    optimum: Optimum
    filtered: list[Filtered]
    log_likelihood: float
    log_evidence: float
    extra: dict[str, float]

    @property
    def values(self) -> dict[str, float]:
        """Shared parameters at the optimum, by slot name."""
        return {name: float(self.optimum.theta[i]) for i, name in enumerate(self.problem.free)}

    def start(self) -> Start:
        """Its parameters as a first guess for a related fit, those of single runs included."""
        models = [self.problem.model(self.optimum.theta, k) for k in range(len(self.problem.runs))]
        own = {name: np.array([p[slot(name)] for p, _ in models]) for name in self.problem.per_run}
        return {**self.values, **own, STATES: np.array([start for _, start in models])}

    def vector(self) -> np.ndarray:
        """Parameter vector at the optimum (per-run parameters of the first run), shape (P,)."""
        return self.problem.model(self.optimum.theta, 0)[0]

    def covariance(self) -> np.ndarray:
        """Posterior covariance of all unknowns, shape (size, size)."""
        return np.linalg.inv(self.optimum.information)


def build(setting: Setting, hypothesis: Hypothesis, start: Start) -> tuple[Problem, np.ndarray]:
    """The least-squares problem of a hypothesis and a first guess of its unknowns."""
    fitted = [(name, parameter) for name, parameter in hypothesis.parameters() if not parameter.counted]
    varying = tuple(name for name, _, _ in hypothesis.varying)
    free = tuple(name for name in nuisance(setting.nominal) if name not in varying) if hypothesis.refit else ()
    free += tuple(name for name, parameter in fitted if not parameter.per_run)
    per_run = (*varying, *(name for name, parameter in fitted if parameter.per_run))
    base = vector({k: float(v) for k, v in start.items() if np.ndim(v) == 0}, setting.nominal)
    problem = Problem(setting.runs, base, free, per_run, setting.noise, setting.weight)
    theta = problem.initial()
    for k in range(len(setting.runs)):
        own = theta[problem.own_slice(k)]
        own[: len(per_run)] = [np.broadcast_to(start.get(name, 0.0), len(setting.runs))[k] for name in per_run]
        if STATES in start:
            own[len(per_run) :] = np.asarray(start[STATES])[k, list(problem.start_states(k))]
    return problem, theta


def prior_of(setting: Setting, hypothesis: Hypothesis, problem: Problem, theta: np.ndarray) -> Prior:
    """Priors in gap units and bounds for all unknowns of a problem."""
    known, top = dict(hypothesis.parameters()), largest_input(problem.runs)
    rows = []  # mean, deviation and bounds
    for i, name in enumerate(problem.free):
        nominal = setting.nominal[slot(name)]
        low, high = LOWEST.get(name, -np.inf), np.inf
        if name in known:
            nominal, sd = _effect_prior(setting, known[name], problem, theta, i)
            low, high = (bound * stretch(known[name], setting.runs) for bound in known[name].bounds)
            if known[name].limit:  # a limit no run reaches is no effect
                high = VISIBLE_LIMIT * top
        elif name == "force_offset":
            nominal, sd = 0.0, OFFSET_SPREAD * top
        elif name == "linear_input":
            nominal, sd, low, high = 0.5, 0.5, 0.0, 1.0
        else:
            sd = (FOREIGN_SPREAD if setting.foreign else NUISANCE_SPREAD) * max(abs(nominal), LEAST)
        rows.append((nominal, sd, low, high))
    varies = {name: (mean, sd, LOWEST.get(name, -np.inf), np.inf) for name, mean, sd in hypothesis.varying}
    own = [varies.get(name) or (0.0, _spread(known[name]), -np.inf, np.inf) for name in problem.per_run]
    first, count = problem.initial(), len(own)
    for k in range(len(problem.runs)):
        states = zip(first[problem.own_slice(k)][count:], START_SD[list(problem.start_states(k))], strict=True)
        rows += [*own, *((mean, sd, -np.inf, np.inf) for mean, sd in states)]
    return Prior(*np.array(rows).T.copy())


def _spread(parameter: Parameter) -> float:
    """Deviation of what lies anywhere between its bounds."""
    return (parameter.bounds[1] - parameter.bounds[0]) / float(np.sqrt(12.0))


def _effect_prior(
    setting: Setting, parameter: Parameter, problem: Problem, theta: np.ndarray, i: int
) -> tuple[float, float]:
    """Mean and deviation of one effect parameter: the size moves the output by the gap, a shape spans its bounds.

    How far a size moves the output is tried where the fit begins, but not closer to the null than at a moderate value:
    many effects level off, and one that another fit had switched off must not be thought of as immense.
    """
    if parameter.seen:  # the lone readings themselves say it, before any range is asked
        seen = float(np.median(outliers.spike_sizes(problem.runs)))
        return seen, SPIKE_SPREAD * seen
    if parameter.shape:
        return parameter.null, _spread(parameter)
    if parameter.limit:
        top = largest_input(problem.runs)
        return 0.7 * top, 0.3 * top
    off, on, moderate = theta.copy(), theta.copy(), typical(parameter, problem.runs)
    mean = off[i] = float(setting.nominal[slot(problem.free[i])])  # the null, but of an effect that the nominal has
    if abs(theta[i] - mean) < abs(moderate - parameter.null):
        on[i] = mean + moderate - parameter.null
    change = _simulated_change(problem, off, on) / abs(on[i] - mean)
    return mean, max(setting.gap / max(change, 1e-12), 1e-9)


def _simulated_change(problem: Problem, a: np.ndarray, b: np.ndarray) -> float:
    """Root mean square difference of two pure simulations [unit of the measurements]."""
    models = ([problem.model(theta, k) for theta in (a, b)] for k in range(len(problem.runs)))
    pairs = ([np.column_stack(parts) for parts in zip(*both, strict=True)] for both in models)
    with np.errstate(invalid="ignore"):  # both may run away
        difference = np.concatenate(
            [np.diff(simulated(run, *pair), axis=1)[:, 0] for run, pair in zip(problem.runs, pairs, strict=True)]
        )
    return float(np.sqrt(np.mean(np.clip(np.nan_to_num(difference, nan=1e6), -1e6, 1e6) ** 2)))


def evaluate(
    setting: Setting, hypothesis: Hypothesis, starts: Sequence[Start] | None = None, rough: bool = False
) -> Fitted:
    """Fit a hypothesis from the given first guesses (default: its catalogue's) and weigh it; rough: one step only."""
    found: list[tuple[Problem, Prior, Optimum]] = []
    for start in starts or first_guesses(setting, hypothesis):
        problem, theta = build(setting, hypothesis, start)
        prior = prior_of(setting, hypothesis, problem, theta)
        filtered = _filtered(problem, np.clip(theta, prior.low, prior.high))
        found.append((problem, prior, climb(problem, theta, prior, filtered, *([1] if rough else []))))
    problem, prior, optimum = min(found, key=lambda one: one[2].cost)
    filtered = _filtered(problem, optimum.theta)
    if setting.noise.sigma > 0.0 and not rough:  # once more with the gains of the optimum
        before, optimum = optimum, climb(problem, optimum.theta, prior, filtered, steps=4)
        if not np.array_equal(optimum.theta, before.theta):
            filtered = _filtered(problem, optimum.theta)
    return weigh(setting, hypothesis, problem, prior, optimum, filtered)


def _filtered(problem: Problem, theta: np.ndarray) -> list[Filtered]:
    """The filter at theta; a measurement whose variance is lost to rounding counts for nothing."""
    found = problem.filter(theta)
    return [replace(f, variance=np.where(f.variance > 0.0, f.variance, LOST)) for f in found]


def first_guesses(setting: Setting, hypothesis: Hypothesis) -> list[Start]:
    """First guesses from the catalogue, all combinations of a pair's."""
    starts: list[Start] = [{}]
    for effect in hypothesis.effects:
        starts = [{**a, **b} for a in starts for b in starting_values(effect, setting.runs)]
    for name in (name for name, parameter in hypothesis.parameters() if parameter.seen):
        starts = [{**start, name: size} for start in starts for size in outliers.spike_sizes(setting.runs)]
    return starts


def weigh(
    setting: Setting,
    hypothesis: Hypothesis,
    problem: Problem,
    prior: Prior,
    optimum: Optimum,
    filtered: list[Filtered] | None = None,
) -> Fitted:
    """Likelihood and evidence at an optimum; filtered: the innovations there, where they are known already."""
    filtered = filtered or _filtered(problem, optimum.theta)
    if not all(np.isfinite(f.innovation).all() and np.all(f.variance < LOST) for f in filtered):
        return Fitted(hypothesis, problem, prior, optimum, filtered, -np.inf, -np.inf, {})
    extra: dict[str, float] = {}
    likelihood = problem.log_likelihood(filtered)
    for effect in (effect for effect in hypothesis.effects if effect.outliers):
        p = problem.model(optimum.theta, 0)[0][list(indices(effect))]
        gain, counted = outliers.judged(effect, p, setting.runs, filtered)
        likelihood += gain
        extra |= counted
    evidence = likelihood + _occam(prior, optimum)
    if not np.isfinite(evidence):
        likelihood = evidence = -np.inf
    return Fitted(hypothesis, problem, prior, optimum, filtered, likelihood, evidence, extra)


@np.errstate(over="ignore", invalid="ignore")  # where the model runs away there is none
def _occam(prior: Prior, optimum: Optimum) -> float:
    """Log of (prior density x posterior volume) at the optimum, cut off at the bounds."""
    deviation = (optimum.theta - prior.mean) / prior.sd
    sign, logdet = np.linalg.slogdet(optimum.information * np.outer(prior.sd, prior.sd))
    total = -0.5 * float(deviation @ deviation) - 0.5 * logdet
    cut = within(
        optimum.theta, optimum.gradient, np.linalg.inv(optimum.information), prior.low, prior.high, prior.mean, prior.sd
    )
    return total + cut if sign > 0.0 else -np.inf  # lost to rounding: nothing is known about how wide it is
