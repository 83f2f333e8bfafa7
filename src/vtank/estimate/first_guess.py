"""Where the fit of drag, thrust and lag starts: a regression of coarse accelerations, for each of a few lags.

Here, and only here, the sonar is differentiated: over bins so long that its noise matters little. What comes out is
rough and never part of an estimate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from ..compiled import law
from ..plant.parameters import LAG, LOSS, slot, vector
from ..plant.surge import TAU, settle, thrust_target
from .observed import POSITION, RANGE, SPEED, Observed
from .problem import Problem

LAGS_S = (0.05, 0.15, 0.4, 0.8, 1.5, 3.0, 6.0)  # [s] lags that are tried
BINS = 200  # per run: 0.6 s for 120 s, short against the paper's periods of 9 to 31 s
FEWEST_SAMPLES = 4  # per bin
FINER = 5  # points per bin at which the lagged thrust is read
SIGNS = {"alpha": -1.0, "beta": 1.0, LOSS: -1.0}


@dataclass(frozen=True)
class Coarse:
    """Surge speed u [m/s] and acceleration a [m/s2] of a run at the same instants t [s], shape (K,), from bins [s]."""

    t: np.ndarray
    u: np.ndarray
    a: np.ndarray
    width: float


def coarse(run: Observed) -> Coarse:
    """Means over bins, and their differences; bins without a sample are left out."""
    kind = next(kind for kind in (SPEED, POSITION, RANGE) if kind in run.first)
    time, value = run.time_s[run.kind == kind], run.value[run.kind == kind]
    width = max(float(time[-1] - time[0]) / BINS, FEWEST_SAMPLES * float(np.median(np.diff(time))))
    index = ((time - time[0]) / width).astype(int)
    with np.errstate(invalid="ignore"):
        mean = np.bincount(index, value) / np.bincount(index)
    centre = time[0] + width * (np.arange(mean.size) + 0.5)
    if kind == SPEED:
        t, u, a = centre[1:-1], mean[1:-1], (mean[2:] - mean[:-2]) / (2.0 * width)
    else:
        ahead = -mean if kind == RANGE else mean
        t, u, a = centre[1:-1], (ahead[2:] - ahead[:-2]) / (2.0 * width), np.diff(ahead, 2) / width**2
    known = np.isfinite(u) & np.isfinite(a)
    return Coarse(t[known], u[known], a[known], width)


def typical_acceleration(runs: Sequence[Observed]) -> float:
    """Root mean square of the coarse accelerations of all runs [m/s2]."""
    return max(float(np.sqrt(np.mean(np.concatenate([coarse(run).a for run in runs]) ** 2))), 1e-6)


@law
def lagged_thrust(stamps: np.ndarray, reading: np.ndarray, at: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Thrust [m/s2] at the instants `at`, shape (K,), from the input held from each stamp; settled at the start."""
    out = np.empty(at.size)
    j, since, z = 0, stamps[0], thrust_target(stamps[0], reading[0], p)
    for k in range(at.size):
        while j + 1 < stamps.size and stamps[j + 1] <= at[k]:
            z = settle(z, thrust_target(since, reading[j], p), stamps[j + 1] - since, p)
            j, since = j + 1, stamps[j + 1]
        out[k] = settle(z, thrust_target(since, reading[j], p), max(at[k] - since, 0.0), p)
    return out


def first_guesses(problem: Problem, count: int = len(LAGS_S)) -> list[np.ndarray]:
    """First guesses of theta, shape (size,) each, best first: what a regression gives at the lags that suit it best."""
    tracks = [coarse(run) for run in problem.runs]
    lags = LAGS_S if LAG in problem.free else (float(problem.base[TAU]),)
    found = sorted((_regression(problem, tracks, lag) for lag in lags), key=lambda item: item[0])
    return [problem.initial(p) for _, p in found[:count]]


def _regression(problem: Problem, tracks: Sequence[Coarse], lag: float) -> tuple[float, np.ndarray]:
    """Misfit and parameter vector of the least squares on a = alpha u|u| + beta w + gamma |n|u at a given lag."""
    p = vector({LAG: lag}, problem.base)
    unit = vector({"beta": 1.0}, p)
    rows = []
    for run, c in zip(problem.runs, tracks, strict=True):
        at = (c.t[:, None] + c.width * ((np.arange(FINER) + 0.5) / FINER - 0.5)).ravel()
        thrust = lagged_thrust(run.input_time_s, run.input, at, unit).reshape(-1, FINER).mean(axis=1)
        n = np.interp(c.t, run.input_time_s, np.abs(run.input))
        rows.append(np.column_stack([c.u * np.abs(c.u), thrust, n * c.u, c.a]))
    data = np.concatenate(rows)
    names = list(SIGNS)
    free = [i for i, name in enumerate(names) if name in problem.free]
    fixed = [i for i in range(3) if i not in free]
    left = data[:, 3] - data[:, fixed] @ p[[slot(names[i]) for i in fixed]]
    columns = data[:, free] * [SIGNS[names[i]] for i in free]
    size = np.maximum(np.sqrt(np.mean(columns**2, axis=0)), 1e-12)
    found, rest = nnls(columns / size, left)
    return float(rest), vector({names[i]: SIGNS[names[i]] * x for i, x in zip(free, found / size, strict=True)}, p)
