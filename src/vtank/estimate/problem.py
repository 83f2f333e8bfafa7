"""The fit of the surge model to several runs as one least-squares problem.

Unknowns theta, in this order: the parameters shared by all runs; for each run its own parameters (a seiche's phase)
and its initial state. Everything else in the parameter vector stays as in `base`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..plant.parameters import LAG, slot
from ..plant.surge import STANDOFF, TAU
from .innovations import GAINS, kalman, predict
from .observed import Observed

FLAGGED = 1e8  # factor on the variance of a measurement that is left out: it neither steers the filter nor counts
RUNAWAY = 1e6  # [-] residual, in deviations, at which a simulation counts as diverged
RELATIVE_STEP = 1e-6  # finite-difference step over a parameter's size; the model is smooth to 1e-12


@dataclass(frozen=True)
class Noise:
    """Noise shared by all runs: variance of range, position and speed [m2, m2, m2/s2], and the disturbance.

    sigma [m/s2] and correlation_time [s] are the stationary deviation and the memory of the disturbing acceleration
    (turbulence, wake); colour_sigma [m] and colour_time [s] are those of a coloured error of the sonar beside the white
    one. Both zero is white measurement noise, the output-error case.
    """

    variance: tuple[float, float, float] = (1e-4, 1e-4, 1e-4)
    sigma: float = 0.0
    correlation_time: float = 1.0
    colour_sigma: float = 0.0
    colour_time: float = 1.0

    def calm(self) -> Noise:
        """The same white measurement noise alone."""
        return replace(self, sigma=0.0, colour_sigma=0.0)

    @property
    def quiet(self) -> bool:
        """Whether the innovations are those of pure simulation: white measurement noise and nothing else."""
        return self.sigma == 0.0 and self.colour_sigma == 0.0


@dataclass(frozen=True)
class Filtered:
    """Innovations, their variances and the gains of one run, shapes (M,), (M,) and (M, 6)."""

    innovation: np.ndarray
    variance: np.ndarray
    gain: np.ndarray


@dataclass(frozen=True)
class Problem:
    """Runs, the parameters that are free, and the noise level.

    Attributes:
        runs: the observed runs.
        base: parameter vector for everything that is not free, shape (P,).
        free: names of the shared free parameters, such as "alpha".
        per_run: names of the parameters that every run has for itself.
        noise: the noise level.
        weight: per run, a factor on each measurement's variance, shape (M,), for outliers; None is one everywhere.
        forcing: per run, a known acceleration held like the input [m/s2], shape (I,); None is zero everywhere.
    """

    runs: tuple[Observed, ...]
    base: np.ndarray
    free: tuple[str, ...]
    per_run: tuple[str, ...] = ()
    noise: Noise = Noise()
    weight: tuple[np.ndarray, ...] | None = None
    forcing: tuple[np.ndarray, ...] | None = None
    _slots: np.ndarray = field(init=False, repr=False)
    _own: np.ndarray = field(init=False, repr=False)
    _states: tuple[tuple[int, ...], ...] = field(init=False, repr=False)
    _ends: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        lag = (2,) if self.has_lag else ()
        states = tuple((*((0,) if run.has_position else ()), 1, *lag) for run in self.runs)
        sizes = [len(self.free), *(len(self.per_run) + len(own) for own in states)]
        object.__setattr__(self, "_slots", np.array([slot(name) for name in self.free], dtype=int))
        object.__setattr__(self, "_own", np.array([slot(name) for name in self.per_run], dtype=int))
        object.__setattr__(self, "_states", states)
        object.__setattr__(self, "_ends", np.cumsum(sizes))

    def with_noise(self, noise: Noise) -> Problem:
        """The same problem at another noise level."""
        return replace(self, noise=noise)

    # --- layout of theta -------------------------------------------------------------------------------------
    @property
    def has_lag(self) -> bool:
        """Whether the lagged thrust is a state with an initial value of its own."""
        return LAG in self.free or self.base[TAU] > 0.0

    def start_states(self, run: int) -> tuple[int, ...]:
        """Indices of the initial state (x, u, z) that are free for a run."""
        return self._states[run]

    def own_slice(self, run: int) -> slice:
        """Where the unknowns of one run lie in theta."""
        return slice(int(self._ends[run]), int(self._ends[run + 1]))

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self._ends[-1])

    def initial(self, p: np.ndarray | None = None) -> np.ndarray:
        """First guess of theta from a parameter vector (default: base) and the runs' first samples."""
        p = self.base if p is None else p
        parts = [p[self._slots]]
        for k, run in enumerate(self.runs):
            standoff = p[STANDOFF] if run.standoff is None else run.standoff
            parts += [p[self._own], run.start(standoff)[list(self.start_states(k))]]
        return np.concatenate(parts)

    def model(self, theta: np.ndarray, run: int) -> tuple[np.ndarray, np.ndarray]:
        """Parameter vector, shape (P,), and initial state (x, u, z, wake), shape (4,), of one run."""
        p, start = self.base.copy(), np.zeros(4)
        if self.runs[run].standoff is not None:
            p[STANDOFF] = self.runs[run].standoff
        p[self._slots] = theta[: len(self.free)]
        own = theta[self.own_slice(run)]
        p[self._own] = own[: len(self.per_run)]
        start[list(self.start_states(run))] = own[len(self.per_run) :]
        return p, start

    # --- predictions -----------------------------------------------------------------------------------------
    def noise_variance(self, run: int) -> np.ndarray:
        """Variance of each measurement of a run, shape (M,)."""
        variance = np.array(self.noise.variance)[self.runs[run].kind]
        return variance if self.weight is None else variance * self.weight[run]

    def filter(self, theta: np.ndarray) -> list[Filtered]:
        """Extended Kalman filter along every run at theta; the initial states are unknowns, so they start certain."""
        out = []
        for k, run in enumerate(self.runs):
            p, start = self.model(theta, k)
            size = run.time_s.size
            result = Filtered(np.empty(size), np.empty(size), np.zeros((size, GAINS)))
            if self.noise.quiet:
                self._predict(k, p, start, result.gain, result.innovation)
                result.variance[:] = self.noise_variance(k)
            else:
                kalman(p, start, np.zeros(4), self.noise.sigma, self.noise.correlation_time,
                       run.input_time_s, run.input, run.lone, run.time_s, run.value, run.kind, self.noise_variance(k),
                       result.innovation, result.variance, result.gain, self._push(k),
                       self.noise.colour_sigma, self.noise.colour_time)  # fmt: skip
            out.append(result)
        return out

    def _predict(self, k: int, p: np.ndarray, start: np.ndarray, gain: np.ndarray, out: np.ndarray) -> None:
        run = self.runs[k]
        predict(p, start, self.noise.correlation_time, run.input_time_s, run.input, run.lone,
                run.time_s, run.value, run.kind, gain, out, self._push(k), None,
                self.noise.colour_time)  # fmt: skip

    def _push(self, k: int) -> np.ndarray | None:
        return None if self.forcing is None else self.forcing[k]

    def track(self, theta: np.ndarray, filtered: Sequence[Filtered]) -> list[np.ndarray]:
        """States (x, u, z, wake, d) at the measurements of every run, shapes (M, 5), along the filtered innovations."""
        out = []
        for k, (run, f) in enumerate(zip(self.runs, filtered, strict=True)):
            track = np.empty((run.time_s.size, 5))
            p, start = self.model(theta, k)
            predict(p, start, self.noise.correlation_time, run.input_time_s, run.input, run.lone, run.time_s, run.value,
                    run.kind, f.gain, np.empty(run.time_s.size), self._push(k), track,
                    self.noise.colour_time)  # fmt: skip
            out.append(track)
        return out

    def residuals(self, theta: np.ndarray, filtered: Sequence[Filtered]) -> np.ndarray:
        """Innovations of all runs over their deviations, with the gains of `filtered` held, shape (sum M,)."""
        parts = []
        for k, f in enumerate(filtered):
            e = np.empty(f.innovation.size)
            self._predict(k, *self.model(theta, k), f.gain, e)
            parts.append(_tamed(e / np.sqrt(f.variance)))
        return np.concatenate(parts)

    def jacobian(
        self, theta: np.ndarray, filtered: Sequence[Filtered], residual: np.ndarray | None = None
    ) -> np.ndarray:
        """Derivative of `residuals` by forward differences, shape (sum M, size); a run's own unknowns touch it alone.

        residual: the residuals at theta where they are known already, shape (sum M,).
        """
        rows = np.cumsum([0] + [f.innovation.size for f in filtered])
        J = np.zeros((rows[-1], self.size))
        for k, f in enumerate(filtered):
            here = self.own_slice(k)
            sd, e = np.sqrt(f.variance), np.empty(f.innovation.size)
            if residual is None:
                self._predict(k, *self.model(theta, k), f.gain, e)
            base = _tamed(e / sd) if residual is None else residual[rows[k] : rows[k + 1]]
            for i in [*range(len(self.free)), *range(here.start, here.stop)]:
                nudged = theta.copy()
                nudged[i] += (step := RELATIVE_STEP * max(abs(theta[i]), 1e-2))
                self._predict(k, *self.model(nudged, k), f.gain, e)
                J[rows[k] : rows[k + 1], i] = (_tamed(e / sd) - base) / step
        return J

    def used(self, run: int) -> np.ndarray:
        """Which measurements of a run count, shape (M,) of bool."""
        return np.ones(self.runs[run].time_s.size, bool) if self.weight is None else self.weight[run] < FLAGGED

    def log_likelihood(self, filtered: Sequence[Filtered]) -> float:
        """Gaussian log-likelihood of the innovations that count."""
        total = 0.0
        for k, f in enumerate(filtered):
            e, S = f.innovation[self.used(k)], f.variance[self.used(k)]
            total -= 0.5 * float(np.sum(e**2 / S + np.log(2.0 * np.pi * S)))
        return total


def _tamed(residual: np.ndarray) -> np.ndarray:
    """Residuals of a model that has run away (NaN as well), held at a size that still says which way is worse."""
    return np.asarray(np.fmin(np.fmax(residual, -RUNAWAY), RUNAWAY))
