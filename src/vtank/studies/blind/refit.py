"""The scorer's own refit: parameters and initial states by least squares on whitened ranges.

It shares no code with the diagnosis. With noise-free recordings of a case it gives d, the post-refit signal-to-noise
ratio: what the true effect still leaves after all that may be refitted has been; with the recordings themselves it is
the oracle, who knows the effect and only has to find its size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...effects import PARAMETERS, Effect, Parameter
from ...plant import LAG, slot
from .replay import Replay
from .whitening import Whitener

Array = NDArray[np.float64]
NUISANCE = ("alpha", "beta", LAG)  # the nominal's own parameters (paper-ii)
START_STEP = (1e-4, 1e-4, 1e-4)  # finite differences of the initial state [m, m/s, m/s2]
ITERATIONS, SETTLED = 12, 1e-4  # relative drop of the cost at which a fit has settled; choices


@dataclass(frozen=True)
class Recording:
    """One run as the refit sees it.

    Attributes:
        replay: the run.
        n_read: recorded propeller speed, shape (T,) [rev/s].
        range_m: recorded ranges, shape (T,), NaN where there is none or where it is left out [m].
        whitener: its noise.
    """

    replay: Replay
    n_read: Array
    range_m: Array
    whitener: Whitener


@dataclass(frozen=True)
class Fit:
    """A refit: parameter vector and initial state of every run, shapes (R, P) and (R, 4), and whitened residuals."""

    p: Array
    start: Array
    residual: tuple[Array, ...]
    free: tuple[str, ...]

    @property
    def size(self) -> float:
        """Norm of the whitened residuals, d where the recordings are noise-free [-]."""
        return float(np.sqrt(sum(r @ r for r in self.residual)))

    @property
    def whole(self) -> Array:
        """Whitened residuals of all runs, shape (sum T,)."""
        return np.concatenate(self.residual)


def parameters(effects: Sequence[Effect]) -> dict[str, Parameter]:
    """Slots of effects that a refit may free; chance events have none but a bias-free median."""
    return {slot: PARAMETERS[slot] for effect in effects if not effect.outliers for slot in effect.slots()}


def refit(
    recordings: Sequence[Recording],
    p: Array,
    free: Sequence[str] = NUISANCE,
    iterations: int = ITERATIONS,
    start: Array | None = None,
) -> Fit:
    """Least squares over the free parameters and the initial states.

    p: where to begin, shape (P,), or (R, P) where runs differ; start: initial states, shape (R, 4), at rest where the
    first ranges are by default.

    Parameters of effects are kept within their bounds; a parameter that runs have for themselves (a phase) is freed
    for each.
    """
    shared = [name for name in free if not _per_run(name)]
    own = [name for name in free if _per_run(name)]
    problem = _Problem(tuple(recordings), tuple(map(slot, shared)), tuple(map(slot, own)), _bounds(shared))
    if start is None:
        start = np.array([[r.replay.plan.scenario.standoff_m - _first(r.range_m), 0.0, 0.0, 0.0] for r in recordings])
    p = np.tile(p, (len(recordings), 1)) if p.ndim == 1 else p.copy()
    return _descend(problem, p, start, tuple(free), iterations)


def _per_run(name: str) -> bool:
    return name in PARAMETERS and PARAMETERS[name].per_run


def _bounds(names: Sequence[str]) -> Array:
    own = {"alpha": (-100.0, 0.0), "beta": (1e-8, 1.0)}
    return np.array([own[name] if name in own else PARAMETERS[name].bounds for name in names]).reshape(-1, 2)


def _first(range_m: Array) -> float:
    return float(np.mean(range_m[np.isfinite(range_m)][:3]))


@dataclass(frozen=True)
class _Problem:
    recordings: tuple[Recording, ...]
    shared: tuple[int, ...]
    own: tuple[int, ...]
    bounds: Array

    def residual(self, k: int, p: Array, start: Array) -> Array:
        recording = self.recordings[k]
        return recording.range_m - recording.replay.model(p, recording.n_read, start)

    def linear(self, k: int, p: Array, start: Array) -> Array:
        """Whitened residual and its derivatives with respect to shared parameters, own ones and the initial state."""
        base = self.residual(k, p, start)
        columns = [base]
        for i in (*self.shared, *self.own):
            step = 1e-4 * max(abs(p[i]), 1e-2)
            step = -step if p[i] > 0.0 else step
            nudged = p.copy()
            nudged[i] += step
            columns.append((self.residual(k, nudged, start) - base) / step)
        for j, step in enumerate(START_STEP):
            nudged = start.copy()
            nudged[j] += step
            columns.append((self.residual(k, p, nudged) - base) / step)
        return self.recordings[k].whitener.whiten(np.column_stack(columns))

    def cost(self, p: Array, start: Array) -> float:
        total = 0.0
        for k, recording in enumerate(self.recordings):
            r = recording.whitener.whiten(self.residual(k, p[k], start[k])[:, None])[:, 0]
            total += float(r @ r)
        return total if np.isfinite(total) else np.inf


def _descend(problem: _Problem, p: Array, start: Array, free: tuple[str, ...], iterations: int) -> Fit:
    """Levenberg-Marquardt; the runs' own unknowns are eliminated run by run."""
    cost, damping = problem.cost(p, start), 1e-4
    for _ in range(iterations):
        blocks = [problem.linear(k, p[k], start[k]) for k in range(len(problem.recordings))]
        while True:
            new_p, new_start = _step(problem, blocks, p, start, damping)
            new_cost = problem.cost(new_p, new_start)
            if new_cost <= cost or damping > 1e6:
                break
            damping *= 10.0
        drop = cost - new_cost
        if drop <= 0.0:
            break
        p, start, cost, damping = new_p, new_start, new_cost, max(damping / 10.0, 1e-9)
        if drop < SETTLED * (cost + 1.0):
            break
    residual = tuple(
        r.whitener.whiten(problem.residual(k, p[k], start[k])[:, None])[:, 0] for k, r in enumerate(problem.recordings)
    )
    return Fit(p, start, residual, free)


def _step(problem: _Problem, blocks: list[Array], p: Array, start: Array, damping: float) -> tuple[Array, Array]:
    count, runs = len(problem.shared), len(blocks)
    width = len(problem.own) + 3
    J = np.zeros((sum(b.shape[0] for b in blocks), count + runs * width))
    r, row = np.concatenate([b[:, 0] for b in blocks]), 0
    for k, b in enumerate(blocks):
        J[row : row + b.shape[0], :count] = b[:, 1 : 1 + count]
        J[row : row + b.shape[0], count + k * width : count + (k + 1) * width] = b[:, 1 + count :]
        row += b.shape[0]
    scale = np.linalg.norm(J, axis=0) + 1e-12
    J /= scale
    H, gradient = J.T @ J, J.T @ r
    stuck = _stuck(problem, p[0], gradient)
    H[stuck], H[:, stuck], gradient[stuck] = 0.0, 0.0, 0.0
    move = -np.linalg.solve(H + damping * np.diag(np.diag(H)) + 1e-12 * np.eye(len(H)), gradient) / scale
    p, start = p.copy(), start.copy()
    for i, index in enumerate(problem.shared):
        p[:, index] = np.clip(p[:, index] + move[i], *problem.bounds[i])
    for k in range(runs):
        own = move[count + k * width : count + (k + 1) * width]
        for i, index in enumerate(problem.own):
            p[k, index] += own[i]
        start[k, :3] += own[len(problem.own) :]
    return p, start


def _stuck(problem: _Problem, p: Array, gradient: Array) -> list[int]:
    """Shared parameters that lie on a bound and want to leave by it."""
    values = p[list(problem.shared)]
    low, high = problem.bounds[:, 0], problem.bounds[:, 1]
    slope = gradient[: values.size]
    return [int(i) for i in np.flatnonzero(((values <= low) & (slope > 0.0)) | ((values >= high) & (slope < 0.0)))]
