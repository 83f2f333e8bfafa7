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
from scipy.linalg import block_diag

from ...effects import PARAMETERS, Effect, Parameter
from ...plant import LAG, LOSS, slot
from .replay import Replay
from .whitening import Whitener

Array = NDArray[np.float64]
OWN = ("alpha", "beta", LOSS, LAG)  # own parameters of a nominal, where it has them
FAR = 5.0  # [-] largest factor on an own parameter: beyond it a simulation may run away; a choice
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


def own_parameters(p: Array) -> tuple[str, ...]:
    """What a refit of p, shape (P,) or (R, P), frees: drag, gain, and loss and lag where it has them."""
    return tuple(name for name in OWN if np.any(p[..., slot(name)] != 0.0))


def refit(
    recordings: Sequence[Recording],
    p: Array,
    free: Sequence[str] | None = None,
    iterations: int = ITERATIONS,
    start: Array | None = None,
) -> Fit:
    """Least squares over the free parameters and the initial states.

    p: where to begin, shape (P,), or (R, P) where runs differ; free: by default the own parameters that p has; start:
    initial states, shape (R, 4), at rest where the first ranges are by default.

    Parameters of effects are kept within their bounds; a parameter that runs have for themselves (a phase) is freed
    for each.
    """
    free = own_parameters(p) if free is None else free
    shared = [name for name in free if not _per_run(name)]
    own = [name for name in free if _per_run(name)]
    bounds = _bounds(shared, p if p.ndim == 1 else p[0])
    problem = _Problem(recordings, [slot(name) for name in shared], [slot(name) for name in own], bounds)
    if start is None:
        start = np.array([[r.replay.plan.scenario.standoff_m - _first(r.range_m), 0.0, 0.0, 0.0] for r in recordings])
    p = np.tile(p, (len(recordings), 1)) if p.ndim == 1 else p.copy()
    return _descend(problem, p, start, iterations)


def _per_run(name: str) -> bool:
    return name in PARAMETERS and PARAMETERS[name].per_run


def _bounds(names: Sequence[str], p: Array) -> Array:
    """Lowest and highest values, shape (N, 2): of own parameters within a factor of FAR of those in p, shape (P,)."""
    spans = []
    for name in names:
        value = float(p[slot(name)])
        own = name in OWN and value != 0.0
        spans.append(sorted((value / FAR, value * FAR)) if own else PARAMETERS[name].bounds)
    return np.array(spans, dtype=float).reshape(-1, 2)


def _first(range_m: Array) -> float:
    return float(np.mean(range_m[np.isfinite(range_m)][:3]))


@dataclass(frozen=True)
class _Problem:
    recordings: Sequence[Recording]
    shared: list[int]
    own: list[int]
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

    def whitened(self, p: Array, start: Array) -> tuple[Array, ...]:
        """Whitened residuals of every run."""
        return tuple(
            r.whitener.whiten(self.residual(k, p[k], start[k])[:, None])[:, 0] for k, r in enumerate(self.recordings)
        )

    def cost(self, p: Array, start: Array) -> float:
        total = float(sum(r @ r for r in self.whitened(p, start)))
        return total if np.isfinite(total) else np.inf


def _descend(problem: _Problem, p: Array, start: Array, iterations: int) -> Fit:
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
    return Fit(p, start, problem.whitened(p, start))


def _step(problem: _Problem, blocks: list[Array], p: Array, start: Array, damping: float) -> tuple[Array, Array]:
    count = len(problem.shared)
    r = np.concatenate([b[:, 0] for b in blocks])
    J = np.hstack([np.vstack([b[:, 1 : 1 + count] for b in blocks]), block_diag(*(b[:, 1 + count :] for b in blocks))])
    scale = np.linalg.norm(J, axis=0) + 1e-12
    J /= scale
    H, gradient = J.T @ J, J.T @ r
    stuck = _stuck(problem, p[0], gradient)
    H[stuck], H[:, stuck], gradient[stuck] = 0.0, 0.0, 0.0
    move = -np.linalg.solve(H + damping * np.diag(np.diag(H)) + 1e-12 * np.eye(len(H)), gradient) / scale
    own = move[count:].reshape(len(blocks), -1)
    p, start = p.copy(), start.copy()
    p[:, problem.shared] = np.clip(p[:, problem.shared] + move[:count], *problem.bounds.T)
    p[:, problem.own] += own[:, :-3]
    start[:, :3] += own[:, -3:]
    return p, start


def _stuck(problem: _Problem, p: Array, gradient: Array) -> list[int]:
    """Shared parameters that lie on a bound and want to leave by it."""
    (low, high), values = problem.bounds.T, p[problem.shared]
    slope = gradient[: values.size]
    return [int(i) for i in np.flatnonzero(((values <= low) & (slope > 0.0)) | ((values >= high) & (slope < 0.0)))]
