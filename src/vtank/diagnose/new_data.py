"""New runs of the same experiments, made by whatever could have made the recorded ones.

A cause is a hypothesis with its parameters, or the best of them with a discrepancy that has no name. Causes are drawn
by their probability, parameters by their covariance, turbulence and noise anew; the models found then predict the new
runs from their start windows, and so does the cause itself, which knows everything but the future turbulence.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.signal import lfilter

from .discrepancy import Discrepancy
from .evidence import Fitted
from .holdout import Model, Prediction, Target, model_of, rms, targets_of
from .selection import Selection
from .verdict import Verdict, probabilities

UNLIKELY = 0.02  # probability over the largest below which a cause is left out
Gaps = tuple[float, float, float]  # root mean square errors of refit, diagnosed model and cause [m or m/s]


@dataclass(frozen=True)
class Cause:
    """What could have made the data.

    Attributes:
        fit: the hypothesis, fitted.
        theta: its unknowns, shifted to make room for the discrepancy, shape (size,).
        force: per run, an acceleration without a name [m/s2], shape (I,), or None.
        error: per run, an error of the sensor without a name [m or m/s], shape (M,) or ().
        entered: the cause entering every run.
    """

    fit: Fitted
    theta: np.ndarray
    force: tuple[np.ndarray | None, ...]
    error: tuple[np.ndarray, ...]
    entered: tuple[Prediction, ...]

    def gap(self) -> float:
        """Its error on the recorded runs [m or m/s]."""
        fit, parts = self.fit, []
        for k, prediction in enumerate(self.entered):
            model = Model(fit.problem.model(self.theta, k)[0], fit.problem.per_run)
            parts.append(prediction.errors(prediction.target.run.value - self.error[k], model, self.force[k]))
        return rms(parts)

    def draw(self, rng: np.random.Generator) -> np.ndarray:
        """Unknowns that the data leave possible, shape (size,)."""
        theta = rng.multivariate_normal(self.theta, self.fit.covariance())
        return np.clip(theta, self.fit.prior.low, self.fit.prior.high)


def cause_of(fit: Fitted, targets: Sequence[Target], unnamed: Discrepancy | None = None) -> Cause:
    """A fitted hypothesis, with a discrepancy laid over it where one is given."""
    count = len(targets)
    fitted = unnamed.fitted if unnamed else ()
    force = fitted if unnamed and fitted and unnamed.channel != "sensor" else (None,) * count
    error = fitted if unnamed and fitted and unnamed.channel == "sensor" else (np.zeros(()),) * count
    theta = fit.optimum.theta
    if fitted:
        runs = tuple(replace(r, value=r.value - e) for r, e in zip(fit.problem.runs, error, strict=True))
        forced = replace(fit.problem, runs=runs, forcing=None if force[0] is None else force)
        before = fit.problem.residuals(theta, fit.filtered)
        J = fit.problem.jacobian(theta, fit.filtered, before)
        theta = theta - fit.covariance() @ (J.T @ (forced.residuals(theta, fit.filtered) - before))
        theta = np.clip(theta, fit.prior.low, fit.prior.high)
    model = model_of(fit)
    return Cause(fit, theta, tuple(force), tuple(error), tuple(Prediction(model, t) for t in targets))


@dataclass(frozen=True)
class NewData:
    """New sets of runs, and the models found predicting them."""

    selection: Selection
    verdict: Verdict

    @cached_property
    def targets(self) -> list[Target]:
        """The recorded runs, whose inputs and stamps the new ones share."""
        return targets_of(self.selection.setting)

    @cached_property
    def models(self) -> list[tuple[Prediction, ...]]:
        """The refit and the verdict's model, entering every run."""
        fits = (self.selection.refit, self.verdict.fit)
        return [tuple(Prediction(model_of(fit), target) for target in self.targets) for fit in fits]

    @cached_property
    def causes(self) -> list[tuple[float, Cause]]:
        """Causes with their probabilities, the most probable first."""
        chances = probabilities(self.selection)
        fits = [self.selection.nominal, self.selection.refit, *self.selection.named]
        found: list[tuple[float, Fitted, Discrepancy | None]] = [(chances[f.hypothesis.name], f, None) for f in fits]
        unnamed = max(self.selection.unnamed, key=lambda d: d.gain)
        found += [(chances["unknown"], self.selection.best, unnamed)]
        most = max(chance for chance, _, _ in found)
        likely = sorted((f for f in found if f[0] > UNLIKELY * most), key=lambda f: -f[0])
        total = sum(chance for chance, _, _ in likely)
        return [(chance / total, cause_of(fit, self.targets, unnamed)) for chance, fit, unnamed in likely]

    def new_set(self, seed: tuple[int, int]) -> Gaps:
        """Gaps of refit, diagnosed model and cause on one new set of runs."""
        rng = np.random.default_rng(seed)
        weight = [chance for chance, _ in self.causes]
        cause = self.causes[int(rng.choice(len(weight), p=weight))][1]
        problem, theta = cause.fit.problem, cause.draw(rng)
        errors: list[list[np.ndarray]] = [[], [], []]
        for k, target in enumerate(self.targets):
            p, start = problem.model(theta, k)
            truth = Model(p, problem.per_run)
            value = simulate(truth, target, start, cause.force[k], rng)
            for i, model in enumerate(self.models):
                errors[i].append(model[k].errors(value + cause.error[k]))
            errors[2].append(cause.entered[k].errors(value, truth, cause.force[k]))
        return rms(errors[0]), rms(errors[1]), rms(errors[2])


def simulate(
    truth: Model, target: Target, start: np.ndarray, force: np.ndarray | None, rng: np.random.Generator
) -> np.ndarray:
    """Measured values of a new run with new turbulence and noise, shape (M,)."""
    p, size = truth.grid[int(rng.integers(len(truth.grid)))], target.run.time_s.size
    push = turbulence(target, rng) + (0.0 if force is None else force)
    quiet = -target.errors(p, np.zeros((size, 5)), np.zeros(size), push, start)
    return quiet + rng.normal(size=size) * np.sqrt(np.array(target.noise.variance)[target.run.kind])


def turbulence(target: Target, rng: np.random.Generator) -> np.ndarray:
    """An Ornstein-Uhlenbeck acceleration at the input's stamps [m/s2], shape (I,); made on an even grid."""
    noise, stamps = target.noise, target.run.input_time_s
    step = float(np.median(np.diff(stamps)))
    grid = np.arange(stamps[0], stamps[-1] + step, step)
    keep = np.exp(-step / noise.correlation_time)
    kicks = rng.normal(size=grid.size)
    kicks[1:] *= np.sqrt(1.0 - keep**2)
    return noise.sigma * np.interp(stamps, grid, lfilter([1.0], [1.0, -keep], kicks))
