"""A promising formula fitted in full: its numbers and the simulator's own parameters move together in output space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi, sqrt

import numpy as np

from ...estimate.optimum import Optimum, Prior, climb
from ...estimate.problem import Problem
from ...plant.formula import Formula
from ...plant.parameters import slot, vector
from ..evidence import Fitted, Setting, weigh
from .grammar import seen
from .motion import Motion
from .screen import length

STEPS = 4  # of a quick fit, and of each half of one that is carried on
LEVELS = 16  # values of a latch that are tried, since no slope leads to them
PROMISE = 0.5  # [nats] that a further step of a quick fit must promise
WIDE = 3.0  # prior deviation of a size over that of its score test; a choice
LAG_S = (0.1, 300.0)  # [s] bounds of a memory: a tick, longer than a run


@dataclass(frozen=True)
class Refitted:
    """A formula with its fit; weight: log evidence less what the choice among formulas costs."""

    formula: Formula
    fit: Fitted
    weight: float

    def covariance(self) -> np.ndarray:
        """Of the formula's numbers, in the order of `formula.fitted()`, shape (K, K)."""
        names, free = self.formula.fitted(), self.fit.problem.free
        here = [free.index(name) for name in names]
        return self.fit.covariance()[np.ix_(here, here)]


def refitted(setting: Setting, fit: Fitted, formula: Formula, runs: Sequence[Motion]) -> Refitted:
    """A formula from its linear start, on top of a fit: a quick fit."""
    problem, theta, prior = posed(setting, fit, formula, runs)
    optimum = climb(problem, theta, prior, problem.filter(theta), STEPS, PROMISE)
    return _weighed(setting, fit, formula, problem, prior, optimum)


def polished(setting: Setting, r: Refitted) -> Refitted:
    """The fit carried on, with the gains of its optimum."""
    problem, prior, optimum = r.fit.problem, r.fit.prior, r.fit.optimum
    theta = latched(problem, optimum.theta, r.formula)
    for _ in range(2):
        optimum = climb(problem, theta, prior, problem.filter(theta), STEPS)
        theta = optimum.theta
    return _weighed(setting, r.fit, r.formula, problem, prior, optimum)


def latched(problem: Problem, theta: np.ndarray, formula: Formula) -> np.ndarray:
    """The unknowns with the levels of a latch where they fit best, one after the other."""
    if formula.memory is None or formula.memory.kind != "latches":
        return theta
    theta, filtered = theta.copy(), problem.filter(theta)
    here = [problem.free.index(name) for name in formula.fitted() if name.startswith("law.memory")]
    span = abs(theta[here[0]] - theta[here[1]])
    for i in here:
        tried = theta[i] + span * np.linspace(-0.5, 0.5, LEVELS + 1)
        costs = np.zeros(tried.size)
        for k, f in enumerate(filtered):
            p = np.repeat(problem.model(theta, k)[0][:, None], tried.size, axis=1)
            p[slot(problem.free[i])] = tried
            costs += np.sum(problem.varied(theta, f, k, p=p) ** 2, axis=0)
        theta[i] = tried[np.argmin(costs)]
    return theta


def _weighed(
    setting: Setting, fit: Fitted, formula: Formula, problem: Problem, prior: Prior, optimum: Optimum
) -> Refitted:
    found = weigh(setting, fit.hypothesis, problem, prior, optimum)
    weight = found.log_evidence - length(formula.factors, formula.memory)
    return Refitted(formula.moved(found.values), found, weight)


def posed(setting: Setting, fit: Fitted, formula: Formula, runs: Sequence[Motion]) -> tuple[Problem, np.ndarray, Prior]:
    """The least-squares problem of a formula on top of a fit, its first guess, and its priors."""
    names, before = formula.fitted(), len(fit.problem.free)
    base, values = vector(formula.values(), fit.problem.base), formula.values()
    free = (*fit.problem.free, *names)
    problem = replace(fit.problem, base=base, free=free, noise=setting.noise)
    theta = np.insert(fit.optimum.theta, before, [values[name] for name in names])
    rows = np.array([_prior(formula, name, runs) for name in names]).reshape(-1, 4)
    whole = [np.insert(own, before, row) for own, row in
             zip((fit.prior.mean, fit.prior.sd, fit.prior.low, fit.prior.high), rows.T, strict=True)]  # fmt: skip
    return problem, theta, Prior(*whole)


def _prior(formula: Formula, name: str, runs: Sequence[Motion]) -> tuple[float, float, float, float]:
    """Mean, deviation and bounds of one number."""
    value = formula.values()[name]
    if name == f"law.{formula.acts}":
        return 0.0, WIDE * abs(value), -np.inf, np.inf
    if name.startswith("law.memory"):
        assert formula.memory
        if formula.memory.kind in ("follows", "delays"):
            return value, value, *LAG_S
        values = seen(runs, formula.memory.quantity.variable)
        if formula.memory.kind == "plays":
            return value, value, 0.0, float(np.ptp(values))
        return value, float(np.ptp(values)) / sqrt(12.0), float(values.min()), float(values.max())
    f = formula.factors[int(name[-1]) - 1]
    if f.operation == "sine":
        return (value, pi / sqrt(3.0), -np.inf, np.inf) if name[4] == "b" else (value, abs(value), -np.inf, np.inf)
    span = float(np.ptp(seen(runs, f.variable, formula.memory)))
    if f.operation == "above" and name[4] == "b":
        low, high = sorted((0.1 * value, np.sign(value) * span))
        return value, 0.3 * span, float(low), float(high)
    if f.operation == "decay":
        low, high = sorted((np.sign(value) * 0.02 * span, np.sign(value) * 20.0 * span))
        return value, abs(value), float(low), float(high)
    return value, span / sqrt(12.0), value - span, value + span
