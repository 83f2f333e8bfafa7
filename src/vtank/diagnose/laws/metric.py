"""How a force, or a sensor's error, shows in the recordings: a metric on functions of time.

The whitened innovations are linear in a small force. Pushing every run once by short blocks of force gives the matrices
by which the score test of any candidate costs a few products of small matrices: the fit's own parameters are free, so
what these can take up of a candidate is not counted (Rao's score test, as in `score.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..evidence import Fitted
from ..score import linearise

BLOCKS = 300  # blocks of a run at most: 0.4 s of two minutes, quicker than a hull follows; a choice
PATTERNS = {"force": 120, "range": BLOCKS}  # kept, those that show most: of a force, those below 0.5 Hz; a choice
PROBES = {"force": 1e-3, "range": 1e-3}  # [m/s2, m] of the finite differences, small enough to be linear
SHOWN = 1e-9  # share of the largest eigenvalue below which a pattern of force is lost to rounding


def blocks(values: np.ndarray) -> np.ndarray:
    """Functions over the instants of a run, shape (I, K), in B equal blocks, shape (B, L, K); 0 at the end."""
    count = values.shape[0]
    length = -(-count // BLOCKS)
    padded = np.pad(values, ((0, -count % length), (0, 0)))
    return padded.reshape(-1, length, values.shape[1]).astype(np.float32)


@dataclass(frozen=True)
class Seen:
    """How blocks of one run show, along patterns that show at all.

    Attributes:
        patterns: shape (E, B): white patterns, so that the square of `patterns @ f` is that of the innovations.
        pull: of the innovations on these patterns, shape (E,).
        taken: what the fit's unknowns take up, shape (size, E).
    """

    patterns: np.ndarray
    pull: np.ndarray
    taken: np.ndarray


@dataclass(frozen=True)
class Metric:
    """Score tests of any number of candidates.

    Attributes:
        runs: how each shows.
        solve: inverse of the information about the fit's unknowns, shape (size, size).
        slope: derivative of half the sum of squares in the unknowns, shape (size,).
    """

    runs: tuple[Seen, ...]
    solve: np.ndarray
    slope: np.ndarray

    def moments(self, columns: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Of columns per run, shape (E, K): what of them shows and is not taken up, shape (sum E + size, K); its pull.

        The square of the first is the information about a size, the second, shape (K,), its gradient.
        """
        taken = sum(run.taken @ c for run, c in zip(self.runs, columns, strict=True))
        pull = sum(run.pull @ c for run, c in zip(self.runs, columns, strict=True))
        return np.asarray(taken), np.asarray(pull - self.slope @ (self.solve @ taken))

    def single(self, columns: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Gain [nats] and size of each of K candidates, shapes (K,)."""
        taken, pull = self.moments(columns)
        total = sum(np.sum(c * c, axis=0) for c in columns)
        A = total - np.sum(taken * (self.solve @ taken), axis=0)
        kept = A > 1e-4 * total
        size = np.where(kept, -pull / np.where(kept, A, 1.0), 0.0)
        return _finite(-0.5 * pull * size), size

    def double(self, one: Sequence[np.ndarray], two: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Gain and sizes, shapes (K,) and (2, K), of pairs of columns with free sizes."""
        (t1, p1), (t2, p2) = self.moments(one), self.moments(two)
        s1, s2 = self.solve @ t1, self.solve @ t2
        n1, n2 = (sum(np.sum(c * c, axis=0) for c in part) for part in (one, two))
        A, D = n1 - np.sum(t1 * s1, axis=0), n2 - np.sum(t2 * s2, axis=0)
        B = sum(np.sum(a * b, axis=0) for a, b in zip(one, two, strict=True)) - np.sum(t1 * s2, axis=0)
        A, D = A + 1e-4 * n1 + 1e-30, D + 1e-4 * n2 + 1e-30  # a ridge: what hardly survives the refit is not believed
        det = np.maximum(A * D - B * B, 1e-4 * A * D)
        c1, c2 = -(D * p1 - B * p2) / det, -(A * p2 - B * p1) / det
        return _finite(-0.5 * (p1 * c1 + p2 * c2)), np.array([c1, c2])


def _finite(gain: np.ndarray) -> np.ndarray:
    """Gains, none where a candidate is beyond all numbers."""
    return np.where(np.isfinite(gain), gain, -np.inf)


def metric(fit: Fitted, acts: str) -> Metric:
    """The metric near a fit, for a force or an error of the range."""
    near, problem, theta = linearise(fit), fit.problem, fit.optimum.theta
    rows, out = np.cumsum([0] + [f.innovation.size for f in fit.filtered]), []
    for k, (run, f) in enumerate(zip(problem.runs, fit.filtered, strict=True)):
        here, count = slice(rows[k], rows[k + 1]), (run.time_s if acts == "range" else run.input_time_s).size
        block = np.arange(count) // -(-count // BLOCKS)
        held = np.bincount(block)  # instants of each; the last may have fewer
        step = PROBES[acts] / held * (block[:, None] == np.arange(held.size))
        if acts == "range":
            moved = problem.varied(theta, f, k, value=run.value[:, None] - step)
        else:
            push = problem.push(k)
            moved = problem.varied(theta, f, k, forcing=step if push is None else push[:, None] + step)
        G = (moved - near.residual[here, None]) / PROBES[acts]
        values, vectors = np.linalg.eigh(G.T @ G)
        size, vectors = np.sqrt(np.maximum(values, SHOWN * values[-1])), vectors
        size, vectors = size[-PATTERNS[acts] :], vectors[:, -PATTERNS[acts] :]
        patterns, back = (vectors * size).T, vectors / size
        left = back.T @ G.T
        out.append(Seen(patterns.astype(np.float32), left @ near.residual[here],
                        (left @ near.jacobian[here]).T))  # fmt: skip
    return Metric(tuple(out), np.linalg.inv(near.information), near.jacobian.T @ near.residual)
