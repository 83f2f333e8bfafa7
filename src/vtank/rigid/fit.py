"""A whole vehicle and its runs: innovations at parameters, and how they change with these.

Where a run starts, its filter finds. Innovations are made with the gains of a filter at the present noise, so that a
disturbance neither drifts a simulation off nor hides a force that repeats.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .filtered import TINY, Filtered, Left, Noise, bent, filtered, innovations, share
from .recorded import Recorded
from .tangent import Path, changes

Array = NDArray[np.float64]
RUNAWAY = 1e4  # deviations at which a residual is held
CLEARLY = 4.6  # log-likelihood from which thrusters began otherwise than the motion says: odds of a hundred
APART = 0.3  # of that, by which phases are tried; a choice
ANYWHERE_M = 10.0  # [m] standard deviation from which nothing is told of where a wall is; a choice


@dataclass(frozen=True, eq=False)
class Fit:
    """Runs of one layout, and the noise at which gains are made."""

    runs: tuple[Recorded, ...]
    noise: Noise

    def filter(self, p: Array) -> list[Filtered]:
        """Kalman filter along every run."""
        return share([partial(filtered, run, p, self.noise) for run in self.runs])

    def paths(self, p: Array, found: Sequence[Filtered]) -> list[Path]:
        """The filters' paths, from which changes are followed."""
        return [Path(run, p, f) for run, f in zip(self.runs, found, strict=True)]

    def residuals(self, vectors: Sequence[Array], found: Sequence[Filtered]) -> Array:
        """Innovations over their deviations at several parameter vectors, (sum M, L)."""
        work = [partial(_answered, run, p, f) for p in vectors for run, f in zip(self.runs, found, strict=True)]
        parts, runs = share(work), len(self.runs)
        return np.column_stack([np.concatenate(parts[i : i + runs]) for i in range(0, len(parts), runs)])

    def answers(self, paths: Sequence[Path], vectors: Sequence[Array]) -> Array:
        """Change of the residuals for other parameter vectors than that of the paths, (sum M, L).

        To first order in what follows from a change (`tangent`); a new memory of the hull is simulated.
        """
        out, done = changes(paths, vectors)
        rest = np.flatnonzero(~done)
        if rest.size:
            exact = self.residuals([paths[0].p, *(vectors[int(i)] for i in rest)], [path.f for path in paths])
            out[:, rest] = exact[:, 1:] - exact[:, :1]
        return out


def begun(fit: Fit, p: Array) -> Fit:
    """The fit whose runs begin at rest, or less so, where nothing tells of a speed: whichever is likelier.

    Where little tells of the motion a filter that doubts it without need takes the wrong path (the moment of an
    oblique flow goes with the product of two such speeds). And with thrusters that have pushed already, or not yet.
    A beginning from which the filter runs away is none.
    """

    def likelier(run: Recorded, other: Recorded | None, by: float = 0.0) -> Recorded:
        if other is None:
            return run
        try:
            before, after = map(log_likelihood, replace(fit, runs=(run, other)).filter(p))
        except InputError:
            return run
        return other if after > before + by else run

    runs = (likelier(run, run.drifting) for run in fit.runs)
    return replace(fit, runs=tuple(likelier(run, run.switched, CLEARLY) for run in runs))


def walled(fit: Fit, found: Sequence[Filtered]) -> Fit:
    """The fit with every wall where the innovations have it; where they say: no place, all are alike."""

    def moved(run: Recorded, f: Filtered) -> Recorded:
        way, z = f.white(f.wall), f.white(f.innovation)
        if way @ way * ANYWHERE_M**2 < 1.0:
            return run
        return replace(run, wall=float(run.wall + way @ (f.unmoved(z) - z) / (way @ way)))

    return replace(fit, runs=tuple(moved(run, f) for run, f in zip(fit.runs, found, strict=True)))


def phased(fit: Fit, p: Array) -> Fit:
    """The fit with the inputs of each run as early or late of the others' as it has them.

    Nothing ties a logger to what it logs: rows of one run may come later after a pilot's turn than those of another. A
    step of Newton's towards the likeliest phases whose sum is nothing: how late all are own parameters tell.
    """
    told = [k for k, run in enumerate(fit.runs) if run.tick_s]
    if len(told) < 2:
        return fit
    found = fit.filter(p)
    slope, bend = np.array(share([partial(_phase, fit.runs[k], found[k], fit.noise) for k in told])).T
    now, usual = (np.array([getattr(fit.runs[k], part) for k in told]) for part in ("phase_s", "usual_s"))
    loose = np.divide(1.0, bend, out=np.zeros_like(bend), where=bend > 0.0)
    phase = now + np.clip(slope * loose, -usual, usual)
    phase -= loose * phase.sum() / max(float(loose.sum()), TINY)
    runs = list(fit.runs)
    for k, by_s in zip(told, phase - now, strict=True):
        runs[k] = runs[k].shifted(float(by_s))
    return replace(fit, runs=tuple(runs))


def _phase(run: Recorded, f: Filtered, noise: Noise) -> tuple[float, float]:
    """Slope of the log-likelihood over when inputs come [1/s], and its bend [1/s2], prior included; 0 for no answer."""
    by = APART * run.usual_s * np.array([-1.0, 0.0, 1.0])
    try:
        there = [filtered(run.shifted(b), f.p, noise) if b else f for b in by]
    except InputError:
        return 0.0, 0.0
    early, here, late = np.array([*map(log_likelihood, there)]) - 0.5 * ((run.phase_s + by) / run.usual_s) ** 2
    return (late - early) / (2.0 * by[2]), (2.0 * here - early - late) / by[2] ** 2


def log_likelihood(f: Left) -> float:
    """Of innovations, far ones by Huber's measure; none where rounding left nothing of a covariance."""
    if not np.all(f.variance > 0.0):
        return -np.inf
    z = bent(f.z)
    return -0.5 * float(np.sum(z * z + np.log(2.0 * np.pi * f.variance)))


def partial_likelihood(f: Filtered) -> float:
    """`log_likelihood` of the measurements that are judged by."""
    z = bent(f.z[f.judged])
    return -0.5 * float(np.sum(z * z + np.log(2.0 * np.pi * f.variance[f.judged])))


def level(found: Sequence[Filtered]) -> float:
    """Log of the partial likelihood but for the squares of the innovations."""
    return -0.5 * sum(float(np.sum(np.log(f.variance[f.judged]))) for f in found)


def _answered(run: Recorded, p: Array, f: Filtered) -> Array:
    try:
        return weighed(innovations(run, p, f.gains), f)
    except InputError:  # masses that no body has: as far off as can be
        return np.full(run.time_s.size, RUNAWAY)


def weighed(innovation: Array, f: Filtered) -> Array:
    """Innovations over their deviations, bent where they are far; what ran away is held, what is not judged by is 0.

    The wall is where they have it.
    """
    most = RUNAWAY * np.sqrt(f.variance)
    e = np.clip(np.nan_to_num(innovation, nan=np.inf), -most, most)
    return np.where(f.judged, bent(f.unmoved(np.clip(f.white(e), -RUNAWAY, RUNAWAY))), 0.0)
