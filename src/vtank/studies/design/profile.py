"""Profile likelihoods: how fast the likelihood falls when one parameter is held off its optimum and all else refitted.

On recordings as the truth would make them without noise, at the noise level of the plan, so that the curve is the
expected one: a parabola of the Cramer-Rao width where the model is as good as linear over its own uncertainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...diagnose import recorded
from ...estimate import Filtered, Noise, Problem, beforehand, descend
from ...plant import slot, vector
from .flown import Array, Flown
from .information import inverse
from .study import Study

LOOSE = 0.01  # relative bound from which a parameter counts as weak; a choice
STRONG = 0.9  # |correlation| from which it does as well; a convention
ROOT95 = np.sqrt(3.8415)  # root of the drop at the ends of a 95 % interval
REACH = np.linspace(-3.0, 3.0, 13)  # deviations by the bound at which the profile is taken


@dataclass(frozen=True, eq=False)
class Profile:
    """Drop of the log-likelihood, times 2, over a parameter's distance from the truth.

    Attributes:
        name: of the parameter.
        deviations: distance over the Cramer-Rao deviation, shape (K,).
        drop: 2 (log L at the truth - log L), shape (K,): deviations^2 where the likelihood is normal.
    """

    name: str
    deviations: Array
    drop: Array

    @property
    def interval95(self) -> tuple[float, float]:
        """Where the drop passes 3.84, in deviations by the bound; NaN beyond the reach."""
        signed_root = np.sign(self.deviations) * np.sqrt(np.maximum(self.drop, 0.0))
        low, high = np.interp((-ROOT95, ROOT95), signed_root, self.deviations, left=np.nan, right=np.nan)
        return float(low), float(high)


def weak(study: Study) -> list[str]:
    """Parameters with a loose bound or a close companion; the loosest where there is none."""
    others = np.abs(study.correlation - np.eye(len(study.free)))
    chosen = (study.relative > LOOSE) | (others.max(axis=1) > STRONG)
    if not chosen.any():
        chosen[np.argmax(study.relative)] = True
    return [name for name, is_weak in zip(study.free, chosen, strict=True) if is_weak]


def profiles(study: Study, names: Sequence[str] | None = None, reach: Array = REACH) -> list[Profile]:
    """Of the weak parameters, or of these, at `reach` deviations by the bound, shape (K,)."""
    runs = tuple(recorded(f.run, f.p, f.scenario.standoff_m) for f in study.flown)
    truth = Problem(runs, study.flown[0].p, study.free, noise=shared_noise(study.flown))
    filtered = truth.filter(at_rest(truth))
    sd = dict(zip(study.free, bound(truth, filtered), strict=True))
    out = []
    for name in weak(study) if names is None else names:
        left = tuple(other for other in study.free if other != name)
        held = [vector({name: float(truth.base[slot(name)]) + k * sd[name]}, truth.base) for k in reach]
        problems = [replace(truth, base=p, free=left) for p in held]
        out.append(Profile(name, reach, np.array([least(problem, filtered) for problem in problems])))
    return out


def shared_noise(flown: Sequence[Flown]) -> Noise:
    """One noise level for all runs, as the likelihood has it: the disturbance at its rms over the runs."""
    noise = flown[0].noise
    return replace(noise, sigma=float(np.sqrt(np.mean([f.noise.sigma**2 for f in flown]))))


def bound(truth: Problem, filtered: Sequence[Filtered]) -> Array:
    """Cramer-Rao deviations of the free parameters at that noise level, shape (P,)."""
    theta = at_rest(truth)
    J = truth.jacobian(theta, filtered)
    information = J.T @ J + np.diag(beforehand(truth, theta).weight)
    return np.asarray(np.sqrt(np.diag(inverse(information))[: len(truth.free)]))


def at_rest(problem: Problem) -> Array:
    """Unknowns as in the problem's base, every run at rest at x = 0 at first, shape (size,)."""
    theta = problem.initial()
    theta[len(problem.free) :] = 0.0
    return theta


def least(problem: Problem, filtered: Sequence[Filtered]) -> float:
    """Least sum of squared innovations over their deviations near the base, with the filter's gains at the truth."""
    theta = at_rest(problem)
    return 2.0 * descend(problem, theta, beforehand(problem, theta), filtered).cost
