"""The state region: which force the refit lacks, over input, speed and place.

The range of each variable is cut into bins. A constant acceleration in every bin shifts the innovations linearly, so
the accelerations that explain them best, and their covariance, are closed form: the smoothed residual force, averaged
in each bin. The bands hold for all bins of all variables together (Bonferroni). Where they exclude zero, the
refit lacks a force of that size; what the diagnosed simulator still lacks is found the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import norm

from ..dynamics.surge import STANDOFF
from ..identify.observed import RANGE
from .discrepancy import simulated
from .evidence import Fitted
from .selection import Selection
from .verdict import Verdict
from .where_gap import whitened

BINS = 10  # bins of each variable; a choice
FEWEST = 0.02  # share of the samples a bin must hold; thinner ones join their neighbour towards the middle
LEVEL = 0.05  # probability that any band of any variable misses
PROBE = 1e-4  # [m/s2] acceleration of the finite differences, small enough to be linear


@dataclass(frozen=True)
class Profile:
    """Residual acceleration over one variable.

    Attributes:
        name: "surge_m_s", "distance_m" (to the wall), "position_m" (ahead), or the input's column.
        edges: of the bins, shape (B + 1,) [unit in the name].
        force: that the refit lacks, shape (B,) [m/s2].
        half_width: of its simultaneous band, shape (B,) [m/s2].
        left: force that the diagnosed simulator lacks, shape (B,) [m/s2].
    """

    name: str
    edges: np.ndarray
    force: np.ndarray
    half_width: np.ndarray
    left: np.ndarray

    @property
    def significant(self) -> np.ndarray:
        """Bins whose band excludes zero, shape (B,) of bool."""
        return np.abs(self.force) > self.half_width

    def document(self) -> list[dict[str, Any]]:
        """Bins whose band excludes zero, as plain data."""
        bins = []
        for b in np.flatnonzero(self.significant):
            f, w = float(self.force[b]), float(self.half_width[b])
            bins.append({"from": float(self.edges[b]), "to": float(self.edges[b + 1]), "acceleration": f,
                         "band": [f - w, f + w], "unit": "m/s2"})  # fmt: skip
        return bins


def residual_force(selection: Selection, verdict: Verdict) -> tuple[Profile, ...]:
    """Residual force of the refit over input, speed and place, with simultaneous bands."""
    refit, last = selection.refit, verdict.fit
    spread = max(1.0, float(np.sqrt(np.mean(np.clip(whitened(last), -5.0, 5.0) ** 2))))
    variables = motion(refit)
    edges = {name: bin_edges(np.concatenate(values)) for name, values in variables.items()}
    z = float(norm.isf(0.5 * LEVEL / sum(e.size - 1 for e in edges.values())))
    profiles = []
    for name, values in variables.items():
        force, sd = binned_force(refit, values, edges[name])
        left, _ = binned_force(last, values, edges[name])
        profiles.append(Profile(name, edges[name], force, z * spread * sd, left))
    return tuple(profiles)


def motion(fit: Fitted) -> dict[str, list[np.ndarray]]:
    """Input, speed and place at the input's stamps, by column name, per run, shape (I,), from a pure simulation.

    The filtered motion would carry the sonar's noise, and the residual with it.
    """
    problem, theta = fit.problem, fit.optimum.theta
    tracks = problem.track(theta, simulated(problem, theta))
    pairs = list(zip(problem.runs, tracks, strict=True))
    place = [np.interp(run.input_time_s, run.time_s, track[:, 0]) for run, track in pairs]
    speed = [np.interp(run.input_time_s, run.time_s, track[:, 1]) for run, track in pairs]
    found = {"surge_m_s": speed, problem.runs[0].input_name: [run.input for run in problem.runs]}
    if all(np.any(run.kind == RANGE) for run in problem.runs):
        found["distance_m"] = [fit.vector()[STANDOFF] - x for x in place]
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


def binned_force(fit: Fitted, values: Sequence[np.ndarray], edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration missing in each bin and its standard deviation, shapes (B,) [m/s2].

    The shared parameters stay where they are; the runs' own unknowns, initial states above all, move along: fitted
    without the force, they have taken up some of it.
    """
    problem, theta, base = fit.problem, fit.optimum.theta, whitened(fit)
    place = [np.clip(np.searchsorted(edges, v, side="right") - 1, 0, edges.size - 2) for v in values]
    count, shared = edges.size - 1, len(problem.free)
    own = problem.jacobian(theta, fit.filtered, base)[:, shared:]
    A = np.column_stack([np.empty((base.size, count)), own])
    for b in range(count):
        push = tuple(PROBE * (k == b) for k in place)
        A[:, b] = (replace(problem, forcing=push).residuals(theta, fit.filtered) - base) / PROBE
    prior = np.concatenate([np.zeros(count), fit.prior.sd[shared:] ** -2.0])
    pull = np.concatenate([np.zeros(count), theta[shared:] - fit.prior.mean[shared:]])
    scale = np.maximum(np.sqrt(np.sum(A**2, axis=0) + prior), 1e-12)
    information = (A / scale).T @ (A / scale) + np.diag(prior / scale**2)
    inverse = np.linalg.pinv(information, rcond=1e-10, hermitian=True)
    found = -inverse @ ((A.T @ base + prior * pull) / scale) / scale
    return found[:count], (np.sqrt(np.diag(inverse)) / scale)[:count]
