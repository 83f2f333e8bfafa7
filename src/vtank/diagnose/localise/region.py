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
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import norm

from ...estimate.observed import RANGE, Observed
from ...plant.surge import STANDOFF
from ..discrepancy import simulated_tracks
from ..evidence import Fitted
from ..selection import Selection
from ..verdict import Verdict
from .gap import whitened

BINS = 10  # bins of each variable; a choice
FEWEST = 0.02  # share of the samples a bin must hold; thinner ones join their neighbour towards the middle
LEVEL = 0.05  # probability that any band of any variable misses
PROBE = 1e-4  # [m/s2] acceleration of the finite differences, small enough to be linear
BLOCK_S = 10.0  # [s] blocks of the recording taken as independent
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


@dataclass(frozen=True)
class Force:
    """Missing acceleration over all variables.

    Attributes:
        mean: by variable, shape (B,) [m/s2].
        sd: its standard deviation, shape (B,) [m/s2].
        gain: by variable, log-likelihood that it adds to the others.
    """

    mean: dict[str, np.ndarray]
    sd: dict[str, np.ndarray]
    gain: dict[str, float]


def residual_force(selection: Selection, verdict: Verdict) -> tuple[Profile, ...]:
    """Force that the refit lacks, with simultaneous bands, and what the diagnosed simulator still lacks."""
    moved = motion(verdict.fit)
    edges = {name: bin_edges(np.concatenate(list(values))) for name, values in moved.items()}
    z = float(norm.isf(0.5 * LEVEL / sum(e.size - 1 for e in edges.values())))
    lacks, left = missing_force(selection.refit, moved, edges), missing_force(verdict.fit, moved, edges)
    return tuple(
        Profile(name, edges[name], lacks.mean[name], z * lacks.sd[name], left.mean[name], lacks.gain[name])
        for name in moved
    )


def motion(fit: Fitted) -> dict[str, list[np.ndarray]]:
    """Speed, input and place at the input's stamps, by column name, per run, shape (I,), from a pure simulation.

    The filtered motion would carry the sonar's noise, and the residual with it.
    """
    problem, theta = fit.problem, fit.optimum.theta
    tracks = simulated_tracks(problem, theta)
    pairs = list(zip(problem.runs, tracks, strict=True))
    place = [np.interp(run.input_time_s, run.time_s, track[:, 0]) for run, track in pairs]
    speed = [np.interp(run.input_time_s, run.time_s, track[:, 1]) for run, track in pairs]
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


def missing_force(fit: Fitted, moved: Motion, edges: Mapping[str, np.ndarray]) -> Force:
    """Acceleration that a fit lacks in every bin of every variable.

    The shared parameters stay where they are; the runs' own unknowns, initial states above all, move along: fitted
    without the force, they have taken up some of it.
    """
    problem, theta, base = fit.problem, fit.optimum.theta, whitened(fit)
    shared = len(problem.free)
    own = problem.jacobian(theta, fit.filtered)[:, shared:]
    centred = {name: _centring(moved[name], edges[name], k > 0) for k, name in enumerate(moved)}
    A = np.column_stack([_columns(fit, base, moved[name], edges[name]) @ centred[name] for name in moved] + [own])
    prior = np.concatenate([np.zeros(A.shape[1] - own.shape[1]), fit.prior.sd[shared:] ** -2.0])
    pull = np.concatenate([np.zeros(A.shape[1] - own.shape[1]), theta[shared:] - fit.prior.mean[shared:]])
    scale = np.maximum(np.sqrt(np.sum(A**2, axis=0) + prior), 1e-12)
    information = (A / scale).T @ (A / scale) + np.diag(prior / scale**2)
    inverse = np.linalg.pinv(information, rcond=1e-9, hermitian=True) / np.outer(scale, scale)
    found = -inverse @ (A.T @ base + prior * pull)
    by_blocks = _blocked(A * (base + A @ found)[:, None], problem.runs)
    robust = inverse @ (by_blocks.T @ by_blocks) @ inverse

    out, start = Force({}, {}, {}), 0
    for name, T in centred.items():
        here = slice(start, start + T.shape[0])
        own_covariance = T @ inverse[here, here] @ T.T
        variances = np.diag(own_covariance), np.diag(T @ robust[here, here] @ T.T)
        out.mean[name] = T @ found[here]
        out.sd[name] = np.sqrt(np.maximum(np.maximum(*variances), 0.0))
        weight = np.linalg.pinv(own_covariance, rcond=1e-8, hermitian=True)
        out.gain[name] = 0.5 * float(out.mean[name] @ weight @ out.mean[name])
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
    places = _places(values, edges)
    columns = np.empty((base.size, edges.size - 1))
    for b in range(edges.size - 1):
        pushed = replace(fit.problem, forcing=tuple(PROBE * (place == b) for place in places))
        columns[:, b] = (pushed.residuals(fit.optimum.theta, fit.filtered) - base) / PROBE
    return columns


def _blocked(rows: np.ndarray, runs: Sequence[Observed]) -> np.ndarray:
    """Sums of rows (sum M, K) over blocks of time, shape (blocks, K)."""
    length = sum(float(run.time_s[-1] - run.time_s[0]) for run in runs)
    block_s = min(BLOCK_S, length / FEWEST_BLOCKS)
    numbers, start = [], 0
    for run in runs:
        numbers.append(start + ((run.time_s - run.time_s[0]) / block_s).astype(int))
        start = int(numbers[-1][-1]) + 1
    sums = np.zeros((start, rows.shape[1]))
    np.add.at(sums, np.concatenate(numbers), rows)
    return sums
