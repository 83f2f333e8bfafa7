"""New runs of the same experiments, made by whatever could have made the recorded ones.

A cause is a hypothesis with its parameters, or the best of them with a discrepancy that has no name. Causes are drawn
by their probability, parameters by their covariance, turbulence and noise anew. The models found then predict the new
runs, and so does the cause itself, which knows everything but the turbulence to come: its error is the floor there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..estimate.innovations import no_gain
from .evidence import Fitted
from .freeform import Freeform
from .holdout import Model, Overlaid, Prediction, Target, model_of, rms, targets_of
from .selection import Selection
from .smoothing import first_order
from .verdict import Verdict, probabilities

UNLIKELY = 0.02  # probability over the largest below which a cause is left out
CHANCE = 2.0  # [-] mean square over its expectation that turbulence may reach by chance in a few runs; a guess
Gaps = tuple[float, float, float]  # root mean square errors of refit, diagnosed model and cause [m or m/s]


@dataclass(frozen=True)
class Cause:
    """What could have made the data.

    Attributes:
        fit: the hypothesis, fitted.
        theta: its unknowns, shifted to make room for the discrepancy, shape (size,).
        free: the discrepancy, which has no name, or None.
        targets: the recorded runs.
    """

    fit: Fitted
    theta: np.ndarray
    free: Freeform | None
    targets: Sequence[Target]

    @cached_property
    def entered(self) -> tuple[Overlaid, ...]:
        """The cause entering every run."""
        return tuple(
            self.entering(target, k, slice(None), slice(None), self.free) for k, target in enumerate(self.targets)
        )

    def entering(
        self, target: Target, k: int, fed: np.ndarray | slice, here: np.ndarray | slice, free: Freeform | None
    ) -> Overlaid:
        """The cause entering a part of run k; fed, here: which of the run's inputs and measurements that is.

        free: the discrepancy, or as much of it as counts.
        """
        prediction = Prediction(model_of(self.fit, k), target)
        return Overlaid(prediction, free.forces()[k][fed], free.errors()[k][here]) if free else Overlaid(prediction)

    def gap(self) -> float:
        """Its error on the recorded runs [m or m/s]."""
        fit = self.fit
        models = [Model(fit.problem.model(self.theta, k)[0], fit.problem.per_run) for k in range(len(self.targets))]
        return rms([own.errors(models=[model]) for own, model in zip(self.entered, models, strict=True)])

    def new_runs(
        self, thetas: Sequence[np.ndarray], k: int, rngs: Sequence[np.random.Generator]
    ) -> tuple[list[Model], np.ndarray]:
        """The cause at each theta, and what it would let run k read with new turbulence and noise, shape (M, L)."""
        target, truths, draws = self.targets[k], [], []
        for theta, rng in zip(thetas, rngs, strict=True):
            p, start = self.fit.problem.model(theta, k)
            truths.append(Model(p, self.fit.problem.per_run))
            push = turbulence(target, rng)
            p = truths[-1].grid[int(rng.integers(len(truths[-1].grid)))]
            draws.append((p, start, push, noise(target, rng)))
        p, start, push, white = (np.column_stack(part) for part in zip(*draws, strict=True))
        if self.free:
            push, white = push + self.free.forces()[k][:, None], white + self.free.errors()[k][:, None]
        quiet = target.errors(p, no_gain(target.run), np.zeros(target.run.time_s.size), push, start)
        return truths, white - quiet

    def draw(self, rng: np.random.Generator) -> np.ndarray:
        """Unknowns that the data leave possible, shape (size,)."""
        # an inverse of unknowns of very different sizes is symmetric but for rounding, which needs no warning
        theta = rng.multivariate_normal(self.theta, self.fit.covariance(), check_valid="ignore")
        return np.clip(theta, self.fit.prior.low, self.fit.prior.high)


def cause_of(fit: Fitted, targets: Sequence[Target], free: Freeform | None = None) -> Cause:
    """A fitted hypothesis, with what it lacks laid over it where that is given."""
    theta = fit.optimum.theta if free is None else fit.optimum.theta + free.shift
    return Cause(fit, np.clip(theta, fit.prior.low, fit.prior.high), free, targets)


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
        models = [model_of(fit) for fit in (self.selection.refit, self.verdict.fit)]
        return [tuple(Prediction(model, target) for target in self.targets) for model in models]

    @cached_property
    def causes(self) -> list[tuple[float, Cause]]:
        """Causes with their probabilities, the most probable first."""
        chances = probabilities(self.selection)
        fits = [self.selection.nominal, self.selection.refit, *self.selection.named]
        found: list[tuple[float, Fitted, Freeform | None]] = [(chances[f.hypothesis.name], f, None) for f in fits]
        beyond = self.selection.beyond
        found += [(chances["unknown"] + chances["varying"], beyond.fit, beyond if beyond.components else None)]
        most = max(chance for chance, _, _ in found)
        likely = sorted((f for f in found if f[0] > UNLIKELY * most), key=lambda f: -f[0])
        total = sum(chance for chance, _, _ in likely)
        return [(chance / total, cause_of(fit, self.targets, free)) for chance, fit, free in likely]

    def floor(self) -> float:
        """Error on the recorded runs of a model that knows everything [m or m/s].

        That of the most probable cause, but no more than noise and turbulence can account for.
        """
        cause = self.causes[0][1]
        parts = [own.prediction.floor_squares() for own in cause.entered]
        noise, turbulence = (np.mean(np.concatenate([part[i] for part in parts])) for i in range(2))
        return min(cause.gap(), float(np.sqrt(noise + CHANCE * turbulence)))

    def drawn(self, seeds: Sequence[tuple[int, int]]) -> Iterator[tuple[np.ndarray, Cause, list[np.random.Generator]]]:
        """Causes drawn by their probability, one for each seed: which of the seeds are its own, and their numbers."""
        rngs, weight = [np.random.default_rng(seed) for seed in seeds], [chance for chance, _ in self.causes]
        chosen = np.array([int(rng.choice(len(weight), p=weight)) for rng in rngs])
        for which in np.unique(chosen):
            own = np.flatnonzero(chosen == which)
            yield own, self.causes[which][1], [rngs[i] for i in own]

    def new_sets(self, seeds: Sequence[tuple[int, int]]) -> list[Gaps]:
        """Gaps of refit, diagnosed model and cause when every run is repeated once, for each seed."""
        gaps = np.empty((len(seeds), 3))
        for own, cause, rngs in self.drawn(seeds):
            gaps[own] = self._repeated(cause, rngs)
        return [(refit, diagnosed, cause) for refit, diagnosed, cause in gaps.tolist()]

    def _repeated(self, cause: Cause, rngs: Sequence[np.random.Generator]) -> np.ndarray:
        """The gaps of new sets that one cause makes, shape (L, 3)."""
        thetas = [cause.draw(rng) for rng in rngs]
        errors: list[list[np.ndarray]] = [[], [], []]
        for k in range(len(self.targets)):
            truths, value = cause.new_runs(thetas, k, rngs)
            for i, model in enumerate(self.models):
                errors[i].append(model[k].errors(value))
            errors[2].append(cause.entered[k].errors(value, truths))
        return np.column_stack([np.sqrt(np.mean(np.concatenate(parts) ** 2, axis=0)) for parts in errors])


def noise(target: Target, rng: np.random.Generator) -> np.ndarray:
    """White and coloured errors of the measurements, shape (M,) [m or m/s]."""
    run, level = target.run, target.noise
    white = rng.normal(size=run.time_s.size) * np.sqrt(np.array(level.variance)[run.kind])
    if level.colour_sigma == 0.0:
        return white
    coloured = level.colour_sigma * remembered(run.time_s, level.colour_time, rng)
    return white + run.coloured * coloured


def turbulence(target: Target, rng: np.random.Generator) -> np.ndarray:
    """An Ornstein-Uhlenbeck acceleration at the input's stamps [m/s2], shape (I,)."""
    sigma = target.run.loud * target.noise.sigma
    return sigma * remembered(target.run.input_time_s, target.noise.correlation_time, rng)


def remembered(time: np.ndarray, memory: float, rng: np.random.Generator) -> np.ndarray:
    """An Ornstein-Uhlenbeck process of unit variance at these times [s], of the same shape; made on an even grid."""
    step = max(float(np.median(np.diff(time))), 1e-3)
    grid = np.arange(time[0], time[-1] + step, step)
    keep = np.exp(-step / memory)
    kicks = rng.normal(size=grid.size)
    kicks[1:] *= np.sqrt(1.0 - keep**2)
    return np.asarray(np.interp(time, grid, first_order(kicks, 1.0, 0.0, keep)))
