"""A promising formula fitted in full: its numbers and the simulator's own parameters move together in output space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi, sqrt

import numpy as np

from ...estimate.optimum import Prior, climb
from ...estimate.problem import Problem
from ...plant.formula import Formula
from ...plant.parameters import vector
from ..evidence import Fitted, Setting, weigh
from .motion import Motion
from .grammar import seen

STEPS = 8  # of a fit, and again with the gains of its optimum
WIDE = 3.0  # prior deviation of a size over that of its score test; a choice
FACTOR_COST = 3.0  # [nats] of a further factor: one of about twenty modulators of equal standing; a choice
LAG_S = (0.05, 300.0)  # [s] bounds of a memory: shorter than a tick, longer than a run


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
    """A formula from its linear start, on top of a fit."""
    problem, theta, prior = posed(setting, fit, formula, runs)
    optimum = climb(problem, theta, prior, problem.filter(theta), STEPS)
    optimum = climb(problem, optimum.theta, prior, problem.filter(optimum.theta), STEPS // 2)
    found = weigh(setting, fit.hypothesis, problem, prior, optimum)
    weight = found.log_evidence - FACTOR_COST * len(formula.factors)
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
        if formula.memory and formula.memory.kind == "follows":
            return value, value, *LAG_S
        values = seen(runs, formula.memory.quantity.variable)  # type: ignore[union-attr]
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
