"""The state region: which force the refit lacks, over speed, input and place.

The range of each variable is cut into bins, and the missing acceleration is a sum of one function of each variable,
constant in every bin. The innovations are linear in it, so that the accelerations that explain them best are closed
form. Because all variables are there at once, a force that goes with one of them does not show under another.

Bands hold for all bins of all variables together (Bonferroni). Their width is the larger of what the noise level says
and of what blocks of the recording say (Liang, Zeger, Biometrika 73 (1986)): a gap that is no function of speed, input
and place, such as a wave, would otherwise pass for many small forces.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ndtri

from ...estimate.observed import RANGE, Observed
from ...plant.surge import STANDOFF
from ..evidence import Fitted
from ..freeform import PROBE_M_S2, simulated_tracks
from ..selection import Selection
from ..verdict import Verdict
from .gap import whitened
from .time import WINDOW_S

BINS = 10  # bins of each variable; a choice
FEWEST = 0.02  # share of the samples a bin must hold; thinner ones join their neighbour towards the middle
LEVEL = 0.05  # probability that any band of any variable misses
FEWEST_BLOCKS = 40  # shorter recordings get shorter blocks

Motion = Mapping[str, Sequence[np.ndarray]]


@dataclass(frozen=True)
class Profile:
    """Missing acceleration over one variable.

    Attributes:
        name: "surge_m_s", the input's column, "distance_m" (to the wall) or "position_m" (ahead).
        edges: of the bins, shape (B + 1,) [unit in the name].
        force: that the refit lacks, shape (B,) [m/s2]; its mean over the samples is kept with the speed.
        half_width: of its simultaneous band, shape (B,) [m/s2].
        left: force that the diagnosed simulator lacks, shape (B,) [m/s2].
        gain: log-likelihood that this variable adds to the others.
    """

    name: str
    edges: np.ndarray
    force: np.ndarray
    half_width: np.ndarray
    left: np.ndarray
    gain: float

    @property
    def significant(self) -> np.ndarray:
        """Bins whose band excludes zero, shape (B,) of bool."""
        return np.abs(self.force) > self.half_width

    def document(self, evidence: float) -> dict[str, Any]:
        """Bins whose band excludes zero, as plain data; evidence: log-likelihood that there is to be gained at all."""
        bins = []
        for b in np.flatnonzero(self.significant):
            f, w = float(self.force[b]), float(self.half_width[b])
            bins.append({"from": float(self.edges[b]), "to": float(self.edges[b + 1]), "acceleration": f,
                         "band": [f - w, f + w], "unit": "m/s2"})  # fmt: skip
        return {"log_likelihood_gain": self.gain, "share": min(self.gain / evidence, 1.0), "bins": bins}


def residual_force(selection: Selection, verdict: Verdict) -> tuple[Profile, ...]:
    """Force that the refit lacks, with simultaneous bands, and what the diagnosed simulator still lacks."""
    moved = motion(verdict.fit)
    edges = {name: bin_edges(np.concatenate(list(values))) for name, values in moved.items()}
    z = float(-ndtri(0.5 * LEVEL / sum(e.size - 1 for e in edges.values())))
    lacks, left = missing_force(selection.refit, moved, edges), missing_force(verdict.fit, moved, edges)
    found = ((name, *lacks[name], left[name][0]) for name in moved)
    return tuple(Profile(name, edges[name], mean, z * sd, rest, gain) for name, mean, sd, gain, rest in found)


def motion(fit: Fitted) -> dict[str, list[np.ndarray]]:
    """Speed, input and place at the input's stamps, by column name, per run, shape (I,), from a pure simulation.

    The filtered motion would carry the sonar's noise, and the residual with it.
    """
    problem, theta = fit.problem, fit.optimum.theta
    tracks = simulated_tracks(problem, theta)
    pairs = list(zip(problem.runs, tracks, strict=True))
    place, speed = ([np.interp(r.input_time_s, r.time_s, track[:, i]) for r, track in pairs] for i in range(2))
    found = {"surge_m_s": speed, problem.runs[0].input_name: [run.input for run in problem.runs]}
    if all(np.any(run.kind == RANGE) for run in problem.runs):
        standoffs = [problem.model(theta, k)[0][STANDOFF] for k in range(len(place))]
        found["distance_m"] = [standoff - x for standoff, x in zip(standoffs, place, strict=True)]
    elif all(run.has_position for run in problem.runs):
        found["position_m"] = place
    return found


def bin_edges(values: np.ndarray) -> np.ndarray:
    """Edges of even bins, shape (B + 1,); zero is one where both signs occur, and thin outer bins join the next."""
    low, high = float(np.min(values)), float(np.max(values))
    if high - low < 1e-12:
        return np.array([low - 0.5, high + 0.5])
    edges = np.linspace(low, high, BINS + 1)
    if low < 0.0 < high:
        below = min(max(round(-low / (high - low) * BINS), 1), BINS - 1)
        edges = np.concatenate([np.linspace(low, 0.0, below + 1), np.linspace(0.0, high, BINS - below + 1)[1:]])
    counts = np.histogram(values, edges)[0]
    while counts.size > 2 and np.min(counts) < FEWEST * values.size:
        thin = int(np.argmin(counts))
        inner = thin + 1 if thin < counts.size / 2 else thin
        edges = np.delete(edges, inner)
        counts = np.histogram(values, edges)[0]
    return edges


def missing_force(
    fit: Fitted, moved: Motion, edges: Mapping[str, np.ndarray]
) -> dict[str, tuple[np.ndarray, np.ndarray, float]]:
    """Acceleration that a fit lacks in every bin of every variable, by variable: mean and deviation [m/s2], and gain.

    Mean and standard deviation have shape (B,); the gain is the log-likelihood that the variable adds to the others.
    The shared parameters stay where they are; the runs' own unknowns, initial states above all, move along: fitted
    without the force, they have taken up some of it.
    """
    problem, theta, base = fit.problem, fit.optimum.theta, whitened(fit)
    shared = len(problem.free)
    own = problem.jacobian(theta, fit.filtered)[:, shared:]
    centred = {name: _centring(moved[name], edges[name], k > 0) for k, name in enumerate(moved)}
    A = np.column_stack([_columns(fit, base, moved[name], edges[name]) @ centred[name] for name in moved] + [own])
    prior, pull = (
        np.pad(part[shared:], (A.shape[1] - own.shape[1], 0)) for part in (fit.prior.weight, theta - fit.prior.mean)
    )
    scale = np.maximum(np.sqrt(np.sum(A**2, axis=0) + prior), 1e-12)
    information = (A / scale).T @ (A / scale) + np.diag(prior / scale**2)
    inverse = np.linalg.pinv(information, rcond=1e-9, hermitian=True) / np.outer(scale, scale)
    found = -inverse @ (A.T @ base + prior * pull)
    by_blocks = _blocked(A * (base + A @ found)[:, None], problem.runs)
    robust = inverse @ (by_blocks.T @ by_blocks) @ inverse

    out, start = {}, 0
    for name, T in centred.items():
        here = slice(start, start + T.shape[0])
        mean, covariance = T @ found[here], T @ inverse[here, here] @ T.T
        variance = np.maximum(np.diag(covariance), np.diag(T @ robust[here, here] @ T.T))
        weight = np.linalg.pinv(covariance, rcond=1e-8, hermitian=True)
        out[name] = mean, np.sqrt(np.maximum(variance, 0.0)), 0.5 * float(mean @ weight @ mean)
        start = here.stop
    return out


def _places(values: Sequence[np.ndarray], edges: np.ndarray) -> list[np.ndarray]:
    """Bin of every sample, per run, shape (I,)."""
    return [np.clip(np.searchsorted(edges, v, side="right") - 1, 0, edges.size - 2) for v in values]


def _centring(values: Sequence[np.ndarray], edges: np.ndarray, centre: bool) -> np.ndarray:
    """Projection that takes the mean over the samples off a function of the bins, where asked, shape (B, B)."""
    count = edges.size - 1
    share = np.bincount(np.concatenate(_places(values, edges)), minlength=count) / sum(v.size for v in values)
    return np.eye(count) - (np.outer(np.ones(count), share) if centre else 0.0)


def _columns(fit: Fitted, base: np.ndarray, values: Sequence[np.ndarray], edges: np.ndarray) -> np.ndarray:
    """Change of all whitened innovations per unit of acceleration in each bin, shape (sum M, B)."""
    pushes = [PROBE_M_S2 * (place[:, None] == np.arange(edges.size - 1)) for place in _places(values, edges)]
    parts = zip(fit.filtered, pushes, strict=True)
    pushed = [fit.problem.varied(fit.optimum.theta, f, k, forcing=push) for k, (f, push) in enumerate(parts)]
    return np.asarray((np.concatenate(pushed) - base[:, None]) / PROBE_M_S2)


def _blocked(rows: np.ndarray, runs: Sequence[Observed]) -> np.ndarray:
    """Sums of rows (sum M, K) over blocks of time, which are taken as independent, shape (blocks, K)."""
    length = sum(float(run.time_s[-1] - run.time_s[0]) for run in runs)
    block_s = min(WINDOW_S, length / FEWEST_BLOCKS)
    numbers, start = [], 0
    for run in runs:
        numbers.append(start + ((run.time_s - run.time_s[0]) / block_s).astype(int))
        start = int(numbers[-1][-1]) + 1
    sums = np.zeros((start, rows.shape[1]))
    np.add.at(sums, np.concatenate(numbers), rows)
    return sums
