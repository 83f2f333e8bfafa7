"""Predicting a run that was not used: its state from a start window, after that the model and the recorded input alone.

Within the window an extended Kalman filter finds position, speed, lagged thrust and disturbance; at its end the gains
become zero. What every run has for itself (a seiche's phase) is weighed over a grid by the likelihood of the window,
and the prediction is made at its mean: where the window does not tell the phase, the wave is predicted to be small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np

from ..effects.catalogue import CATALOGUE, PARAMETERS
from ..estimate.innovations import filtered, innovations, no_gain
from ..estimate.observed import Observed
from ..estimate.problem import FLAGGED, Noise
from ..plant.parameters import slot
from ..plant.surge import TAU
from . import outliers
from .evidence import START_SD, Fitted, Setting
from .lone_speeds import with_lone_speeds

START_WINDOW_S = 10.0  # [s] of a run from which its initial state is found
WINDOW_SHARE = 1.0 / 3.0  # longest window over the run's length, for runs shorter than half a minute; a guess
GRID = 12  # values of a run's own parameter that are weighed
REMOTE = 1e5  # [m2 or m2/s2] variance of a measurement that steers nothing, small enough to leave P its digits
DIVERGED = 1e6  # [m or m/s] error at which a simulation that has run away is held
REDUCIBLE = 1.1  # refit over floor from which there is a gap left to close; a convention


@dataclass(frozen=True)
class Model:
    """A simulator that predicts: parameter vector, shape (P,), and the parameters that every run has for itself.

    Those of effects are weighed anew in every run; own parameters that differ from run to run stay as they are.
    """

    p: np.ndarray
    per_run: tuple[str, ...] = ()

    @cached_property
    def weighed(self) -> tuple[str, ...]:
        """Those that a run's start tells; a simulator's own that differ by run stay as they are."""
        return tuple(name for name in self.per_run if name in PARAMETERS and PARAMETERS[name].per_run)

    @cached_property
    def grid(self) -> np.ndarray:
        """Parameter vectors over the values of the run's own parameters, shape (G, P); one where it has none."""
        ranges = [(-np.pi, np.pi) if PARAMETERS[s].angle else PARAMETERS[s].bounds for s in self.weighed]
        values = [low + (high - low) * (np.arange(GRID) + 0.5) / GRID for low, high in ranges]
        points = np.array(list(product(*values)))
        grid = np.tile(self.p, (len(points), 1))
        grid[:, [slot(name) for name in self.weighed]] = points
        return grid

    def mean(self, weight: np.ndarray) -> np.ndarray:
        """Parameter vector at the mean of the grid, shape (P,); of a wave, the mean of its two quadratures."""
        p, size_of = self.p.copy(), {wave[2]: wave[0] for effect in CATALOGUE if (wave := effect.wave)}
        for name in self.weighed:
            values = self.grid[:, slot(name)]
            if name in size_of:
                mean = complex(weight @ np.exp(1j * values))
                p[slot(size_of[name])] *= abs(mean)
                p[slot(name)] = np.angle(mean)
            else:
                p[slot(name)] = weight @ values
        return p


def model_of(fit: Fitted, run: int = 0) -> Model:
    """The model of a fitted hypothesis for a run, spikes of the tachometer repaired as it says."""
    p = fit.problem.model(fit.optimum.theta, run)[0]
    bounds = {name: q.bounds for name, q in fit.hypothesis.parameters()}
    for name, value in fit.extra.items():
        p[slot(name)] = np.clip(value, *bounds[name])
    return Model(p, fit.problem.per_run)


@dataclass(frozen=True)
class Target:
    """A run to be predicted.

    Attributes:
        run: the run.
        weight: factor on each measurement's variance (FLAGGED: left out), shape (M,).
        noise: noise level.
    """

    run: Observed
    weight: np.ndarray
    noise: Noise

    @cached_property
    def inside(self) -> int:
        """Number of measurements in the start window."""
        past = self.run.time_s - self.run.time_s[0]
        return int(np.sum(past <= min(START_WINDOW_S, WINDOW_SHARE * past[-1])))

    @cached_property
    def scored(self) -> np.ndarray:
        """Which measurements count: those after the window, positions where there are any, else speeds; shape (M,)."""
        late = np.arange(self.run.time_s.size) >= self.inside
        return late & (self.weight < FLAGGED) & (self.run.placed | (not self.run.has_position))

    @cached_property
    def variance(self) -> np.ndarray:
        """Of each measurement's white noise [m2 or m2/s2], shape (M,)."""
        return np.array(self.noise.variance)[self.run.kind] * self.weight

    @cached_property
    def coloured(self) -> np.ndarray:
        """Variance of the coloured error at each measurement [m2 or m2/s2], shape (M,)."""
        return self.run.coloured * self.noise.colour_sigma**2

    @cached_property
    def window(self) -> Target:
        """The start window alone."""
        m, run = self.inside, self.run
        fed = run.input_time_s <= max(run.time_s[m - 1], run.input_time_s[0])
        short = replace(run, time_s=run.time_s[:m], value=run.value[:m], kind=run.kind[:m],
                        input_time_s=run.input_time_s[fed], input=run.input[fed], lone=run.lone[fed])  # fmt: skip
        return Target(short, self.weight[:m], self.noise)

    def begin(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and deviation of the state (x, u, z, wake) at the first measurement, before any is used; shape (4,)."""
        x, u, z = START_SD
        sd = np.array([x * self.run.has_position, u, z * (p[TAU] > 0.0), 0.0])
        return self.run.start(p), sd

    def filter(self, p: np.ndarray, variance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Variances of the innovations, shape (M,), and gains, shape (M, 6), for measurements of given variance."""
        p = self.run.here(p)
        start, sd = self.begin(p)
        found = filtered(self.run, p, start, self.noise, variance, sd)
        return found.variance, found.gain

    def errors(
        self,
        p: np.ndarray,
        gain: np.ndarray,
        value: np.ndarray,
        forcing: np.ndarray | None = None,
        start: np.ndarray | None = None,
    ) -> np.ndarray:
        """Measured value less prediction with the given gains, shape (M,), or (M, L) of L models.

        p: shape (P,) or (P, L); value: shape (M,) or (M, L); forcing: known acceleration [m/s2], shape (I,) or (I, L);
        start: states at the first measurement, shape (S,) or (S, L), by default a guess.
        """
        p = self.run.here(p)
        start = self.run.start(p) if start is None else start
        return held(innovations(self.run, p, start, self.noise, gain, value, forcing))


def target_of(run: Observed, noise: Noise) -> Target:
    """A run as a target, lone outliers left out and lone speeds found."""
    return Target(with_lone_speeds([run])[0], np.where(outliers.long_ranges(run), FLAGGED, 1.0), noise)


def targets_of(setting: Setting) -> list[Target]:
    """All runs of a setting."""
    return [Target(run, weight, setting.noise) for run, weight in zip(setting.runs, setting.weight, strict=True)]


class Prediction:
    """A model that has entered a run: window gains for each value of the run's own parameter, kept for reuse.

    Attributes:
        model, target: what predicts what.
        gains: of the window, shape (G, m, 6).
    """

    def __init__(self, model: Model, target: Target) -> None:
        """Filter the start window."""
        self.model, self.target = model, target
        found = [target.window.filter(p, target.window.variance) for p in model.grid]
        self.gains = np.array([gain for _, gain in found])
        self._variance = np.array([variance for variance, _ in found])

    def errors(
        self,
        value: np.ndarray | None = None,
        models: Sequence[Model] | None = None,
        forcing: np.ndarray | None = None,
    ) -> np.ndarray:
        """Simulation errors at the measurements that count, shape (K,), or (K, L) of L recordings.

        value: other measured values, shape (M,) or (M, L); models: others of the same structure, one for each of these;
        forcing: see Target.
        """
        target, value = self.target, self.target.run.value if value is None else value
        many = value if value.ndim == 2 else value[:, None]
        models = models or [self.model] * many.shape[1]
        weight = self._weigh(models, many)
        p = np.column_stack([model.mean(w) for model, w in zip(models, weight, strict=True)])
        found, best = np.empty(many.shape), np.argmax(weight, axis=1)
        for i in np.unique(best):
            own, gain = best == i, no_gain(target.run)
            gain[: target.inside] = self.gains[i]
            found[:, own] = target.errors(p[:, own], gain, many[:, own], forcing)
        return found[target.scored] if value.ndim == 2 else found[target.scored, 0]

    def _weigh(self, models: Sequence[Model], value: np.ndarray) -> np.ndarray:
        """Posterior weight of each value of the runs' own parameter, shape (L, G), from the window."""
        count, window = len(self.gains), self.target.window
        if count == 1:
            return np.ones((len(models), 1))
        cost = np.empty((len(models), count))
        for i in range(count):
            p = np.column_stack([model.grid[i] for model in models])
            e, S = window.errors(p, self.gains[i], value[: self.target.inside]), self._variance[i][:, None]
            cost[:, i] = 0.5 * np.sum(e**2 / S + np.log(S), axis=0)
        weight = np.exp(np.min(cost, axis=1, keepdims=True) - cost)
        return np.asarray(weight / np.sum(weight, axis=1, keepdims=True))

    def floor_squares(self) -> tuple[np.ndarray, np.ndarray]:
        """Expected square error of the right model at the measurements that count, shapes (K,) [m2 or m2/s2].

        By measurement noise; and by turbulence and the uncertain state at the window's end.
        """
        target = self.target
        p = self.model.mean(self._weigh([self.model], target.run.value[:, None])[0])
        late = np.arange(target.run.time_s.size) >= target.inside
        S, _ = target.filter(p, np.where(late, REMOTE, target.variance))
        noise = (target.variance + target.coloured)[target.scored]
        return noise, np.maximum(S - REMOTE - target.coloured, 0.0)[target.scored]


@dataclass(frozen=True)
class Overlaid:
    """A prediction with what its model lacks laid over it.

    Attributes:
        prediction: of the model alone.
        force: acceleration at the input's stamps [m/s2], shape (I,), or None.
        error: of the readings [m or m/s], shape (M,) or ().
    """

    prediction: Prediction
    force: np.ndarray | None = None
    error: np.ndarray = field(default_factory=lambda: np.zeros(()))

    def errors(self, value: np.ndarray | None = None, models: Sequence[Model] | None = None) -> np.ndarray:
        """Simulation errors, see `Prediction.errors`."""
        value = self.prediction.target.run.value if value is None else value
        error = self.error if value.ndim == 1 else np.reshape(self.error, (-1, 1))
        return self.prediction.errors(value - error, models, self.force)


def held(values: np.ndarray) -> np.ndarray:
    """Errors or motions of a simulation, held at DIVERGED where it has run away."""
    return np.asarray(np.clip(np.nan_to_num(values, nan=DIVERGED), -DIVERGED, DIVERGED))


def rms(parts: Sequence[np.ndarray]) -> float:
    """Root mean square over all runs together [m or m/s]."""
    return float(np.sqrt(np.mean(np.concatenate(list(parts)) ** 2)))


def fraction_closed(refit: float, diagnosed: float, floor: float) -> float | None:
    """Share of the reducible gap, refit less floor, that the diagnosed model closes; None where there is none."""
    return (refit - diagnosed) / (refit - floor) if refit > REDUCIBLE * floor else None
