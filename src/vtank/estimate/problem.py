"""The fit of the surge model to several runs as one least-squares problem.

Unknowns theta, in this order: the parameters shared by all runs; for each run its own parameters (a seiche's phase)
and its initial state. Everything else in the parameter vector stays as in `base`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..compiled import law
from .innovations import Filtered, Noise, filtered, innovations, keep
from .observed import Observed

__all__ = ["FLAGGED", "Filtered", "Noise", "Problem"]

FLAGGED = 1e8  # factor on the variance of a measurement that is left out: it neither steers the filter nor counts
RUNAWAY = 1e6  # [-] residual, in deviations, at which a simulation counts as diverged
RELATIVE_STEP = 1e-6  # finite-difference step over a parameter's size; the model is smooth to 1e-12


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
        plant = self.runs[0].plant
        states = tuple(run.told(self.lagging) for run in self.runs)
        sizes = [len(self.free), *(len(self.per_run) + len(own) for own in states)]
        object.__setattr__(self, "_slots", plant.parameters.slots(self.free))
        object.__setattr__(self, "_own", plant.parameters.slots(self.per_run))
        object.__setattr__(self, "_states", states)
        object.__setattr__(self, "_ends", np.cumsum(sizes))

    def with_noise(self, noise: Noise) -> Problem:
        """The same problem at another noise level."""
        return replace(self, noise=noise)

    def alone(self, run: int) -> Problem:
        """The same problem for one of its runs."""
        weight, forcing = (part and (part[run],) for part in (self.weight, self.forcing))
        return replace(self, runs=(self.runs[run],), weight=weight, forcing=forcing)

    # --- layout of theta -------------------------------------------------------------------------------------
    @property
    def lagging(self) -> list[str]:
        """Lagging states with an initial value of their own: those whose lag is free, or not null."""
        plant = self.runs[0].plant
        some = plant.lagging.items()
        return [state for state, tau in some if tau in self.free or self.base[plant.parameters.slot(tau)] > 0.0]

    def start_states(self, run: int) -> tuple[int, ...]:
        """Indices of the initial states that are free for a run."""
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
            parts += [p[self._own], run.start(run.here(p))[list(self.start_states(k))]]
        return np.concatenate(parts)

    def model(self, theta: np.ndarray, run: int) -> tuple[np.ndarray, np.ndarray]:
        """Parameter vector, shape (P,), and initial states, shape (S,), of one run."""
        p, start = self.runs[run].here(self.base), np.zeros(len(self.runs[run].plant.states))
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
        return [
            filtered(run, *self.model(theta, k), self.noise, self.noise_variance(k), forcing=self.push(k))
            for k, run in enumerate(self.runs)
        ]

    def simulate(self, theta: np.ndarray) -> list[Filtered]:
        """The same by pure simulation, as if there were no turbulence."""
        return self.with_noise(self.noise.calm()).filter(theta)

    def push(self, run: int) -> np.ndarray | None:
        """Known acceleration on a run [m/s2], shape (I,), or None."""
        return None if self.forcing is None else self.forcing[run]

    def track(self, theta: np.ndarray, filtered: Sequence[Filtered]) -> list[np.ndarray]:
        """States and disturbances at every run's measurements, shapes (M, S + A), along the filtered innovations."""
        out = []
        for k, (run, f) in enumerate(zip(self.runs, filtered, strict=True)):
            out.append(np.empty((run.time_s.size, run.plant.size)))
            innovations(run, *self.model(theta, k), self.noise, f.gain, forcing=self.push(k), track=out[-1])
        return out

    def varied(
        self,
        theta: np.ndarray,
        f: Filtered,
        run: int,
        *,
        p: np.ndarray | None = None,
        value: np.ndarray | None = None,
        forcing: np.ndarray | None = None,
    ) -> np.ndarray:
        """Innovations of a run over their deviations, shape (M,) or (M, L), with something else than the problem's own.

        p: parameters, shape (P,) or (P, L); value: measurements, shape (M,) or (M, L); forcing: known acceleration
        [m/s2], shape (I,) or (I, L).
        """
        own, start = self.model(theta, run)
        push = self.push(run) if forcing is None else forcing
        e = innovations(self.runs[run], own if p is None else p, start, self.noise, f.gain, value, push)
        return np.asarray(_tamed(e / (np.sqrt(f.variance) if e.ndim == 1 else np.sqrt(f.variance)[:, None])))

    def residuals(self, theta: np.ndarray, filtered: Sequence[Filtered]) -> np.ndarray:
        """Innovations of all runs over their deviations, with the gains of `filtered` held, shape (sum M,)."""
        return np.concatenate([self.varied(theta, f, k) for k, f in enumerate(filtered)])

    def linearise(self, theta: np.ndarray, filtered: Sequence[Filtered]) -> tuple[np.ndarray, np.ndarray]:
        """`residuals`, shape (sum M,), and their derivative by forward differences, shape (sum M, size).

        A run's own unknowns touch it alone; all are moved in one pass with the residuals themselves.
        """
        rows, shared = np.cumsum([0] + [f.innovation.size for f in filtered]), len(self.free)
        residual, J = np.empty(rows[-1]), np.zeros((rows[-1], self.size))
        step = RELATIVE_STEP * np.maximum(np.abs(theta), 1e-2)
        for k, f in enumerate(filtered):
            here, own = slice(rows[k], rows[k + 1]), self.own_slice(k)
            p, start = self._nudged(theta, step, k)
            e = innovations(self.runs[k], p, start, self.noise, f.gain, forcing=self.push(k))
            if self.noise.quiet and not f.gain.any():
                keep(self.runs[k], p[:, 0], start[:, 0], self.push(k), e[:, 0])
            _differences(e, f.variance, step, shared, own.start, residual[here], J[here])
        return residual, J

    def _nudged(self, theta: np.ndarray, step: np.ndarray, run: int) -> tuple[np.ndarray, np.ndarray]:
        """Parameters, shape (P, 1 + K), and initial states, shape (S, 1 + K), of a run: at theta, and each moved."""
        p, start = self.model(theta, run)
        slots, states, own = [*self._slots, *self._own], list(self.start_states(run)), self.own_slice(run)
        count = len(slots) + len(states)
        P, S = np.repeat(p[:, None], 1 + count, axis=1), np.repeat(start[:, None], 1 + count, axis=1)
        move = np.concatenate([step[: len(self.free)], step[own]])
        P[slots, np.arange(1, len(slots) + 1)] += move[: len(slots)]
        S[states, np.arange(len(slots) + 1, count + 1)] += move[len(slots) :]
        return P, S

    def jacobian(self, theta: np.ndarray, filtered: Sequence[Filtered]) -> np.ndarray:
        """Derivative of `residuals`, shape (sum M, size)."""
        return self.linearise(theta, filtered)[1]

    def used(self, run: int) -> np.ndarray:
        """Which measurements of a run count, shape (M,) of bool."""
        return np.ones(self.runs[run].time_s.size, bool) if self.weight is None else self.weight[run] < FLAGGED

    def unweighted(self, run: int, filtered: Filtered) -> np.ndarray:
        """Variances that the innovations of a run would have without the measurements' own weights, shape (M,)."""
        added = self.noise_variance(run) - np.array(self.noise.variance)[self.runs[run].kind]
        return np.asarray(filtered.variance - added)

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")  # what is no number is no likelihood
    def log_likelihood(self, filtered: Sequence[Filtered]) -> float:
        """Log-likelihood of the innovations that count: normal, or of Student's t where the noise is."""
        total = 0.0
        for k, f in enumerate(filtered):
            e, used = f.innovation[self.used(k)], self.used(k)
            if np.isfinite(self.noise.freedom):
                S = self.unweighted(k, f)[used]
                total += student(e / np.sqrt(S), self.noise.freedom) - 0.5 * float(np.sum(np.log(S)))
            else:
                S = f.variance[used]
                total -= 0.5 * float(np.sum(e**2 / S + np.log(2.0 * np.pi * S)))
        return total


def student(residual: np.ndarray, freedom: float) -> float:
    """Log-likelihood of residuals over their scales under Student's t, shape (M,)."""
    each = math.lgamma(0.5 * (freedom + 1.0)) - math.lgamma(0.5 * freedom) - 0.5 * math.log(math.pi * freedom)
    return residual.size * each - 0.5 * (freedom + 1.0) * float(np.sum(np.log1p(residual**2 / freedom)))


@law
def _tamed(residual):  # type: ignore[no-untyped-def]
    """A residual or an array of them, NaN as well, held at a size that still says which way is worse."""
    return np.fmin(np.fmax(residual, -RUNAWAY), RUNAWAY)


@law
def _differences(
    e: np.ndarray, variance: np.ndarray, step: np.ndarray, shared: int, own: int, residual: np.ndarray, J: np.ndarray
) -> None:
    """Innovations e, shape (M, 1 + K), over their deviations: those at theta, and their forward differences.

    The columns are moved in the first `shared` unknowns and those from `own` on; see `linearise`.
    """
    for m in range(e.shape[0]):
        sd = math.sqrt(variance[m])
        base = _tamed(e[m, 0] / sd)
        residual[m] = base
        for c in range(1, e.shape[1]):
            i = c - 1 if c <= shared else own + c - 1 - shared
            J[m, i] = (_tamed(e[m, c] / sd) - base) / step[i]
