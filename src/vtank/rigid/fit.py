"""The fit of a whole vehicle to its runs: innovations, their derivatives, and the noise that goes with them.

Unknowns are named slots of the layout, shared by all runs; where a run starts, its filter finds. Innovations are made
with the gains of a filter at the present noise, so that a disturbance neither drifts a simulation off nor hides a force
that repeats.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from . import kernels
from .filtered import Filtered, Noise, bent, share
from .recorded import Recorded
from .tangent import Path, changes

Array = NDArray[np.float64]
RUNAWAY = 1e4  # deviations at which a residual is held


@dataclass(frozen=True, eq=False)
class Fit:
    """Runs, free slots and noise; the protocol of `estimate.optimum`.

    Attributes:
        runs: of one layout.
        base: parameters that are not free, (P,).
        free: indices of the free slots, (U,).
        step: of their finite differences, (U,).
        noise: at which the gains are made.
    """

    runs: tuple[Recorded, ...]
    base: Array
    free: NDArray[np.int64]
    step: Array
    noise: Noise

    def vector(self, theta: Array) -> Array:
        """Parameters, (P,), at the unknowns theta, (U,)."""
        p = self.base.copy()
        p[self.free] = theta
        return p

    def at(self, p: Array, noise: Noise | None = None) -> Fit:
        """The same with other fixed parameters, and at another noise."""
        return replace(self, base=p, noise=noise or self.noise)

    def filter(self, theta: Array) -> list[Filtered]:
        """Kalman filter along every run."""
        p = self.vector(theta)
        return share([partial(filtered, run, p, self.noise) for run in self.runs])

    def linearise(self, theta: Array, found: Sequence[Filtered]) -> tuple[Array, Array]:
        """Innovations over their deviations, (sum M,), and their derivative, (sum M, U), gains held."""
        sides = [self.vector(theta)]
        for i in range(theta.size):
            moved = theta.copy()
            moved[i] += self.step[i]
            sides.append(self.vector(moved))
        columns = self.residuals(sides, found)
        return columns[:, 0], (columns[:, 1:] - columns[:, :1]) / self.step

    def paths(self, p: Array, found: Sequence[Filtered]) -> list[Path]:
        """The filters' paths, from which changes are followed."""
        return [Path(run, p, f, self.noise.memory_s) for run, f in zip(self.runs, found, strict=True)]

    def residuals(self, vectors: Sequence[Array], found: Sequence[Filtered]) -> Array:
        """Innovations over their deviations at several parameter vectors, (sum M, L)."""
        work = [
            partial(_answered, run, p, f, self.noise.memory_s)
            for p in vectors
            for run, f in zip(self.runs, found, strict=True)
        ]
        parts, runs = share(work), len(self.runs)
        return np.column_stack([np.concatenate(parts[i : i + runs]) for i in range(0, len(parts), runs)])

    def answers(self, p: Array, vectors: Sequence[Array], found: Sequence[Filtered]) -> Array:
        """Change of the residuals for other parameter vectors than p, whose filter `found` is, (sum M, L).

        To first order in what follows from a change (`tangent`); a new memory of the hull is simulated.
        """
        out, followed = changes(self.runs, p, found, self.noise.memory_s, vectors)
        rest = np.flatnonzero(~followed)
        if rest.size:
            exact = self.residuals([p, *(vectors[int(i)] for i in rest)], found)
            out[:, rest] = exact[:, 1:] - exact[:, :1]
        return out

    def log_likelihood(self, found: Sequence[Filtered]) -> float:
        """Of the innovations, far ones by Huber's measure."""
        total = 0.0
        for f in found:
            z = bent(f.innovation / np.sqrt(f.variance))
            total -= 0.5 * float(np.sum(z * z + np.log(2.0 * np.pi * f.variance)))
        return total


def _answered(run: Recorded, p: Array, f: Filtered, memory_s: float) -> Array:
    return weighed(innovations(run, p, f.gain, memory_s), f)


def weighed(innovation: Array, f: Filtered) -> Array:
    """Innovations over their deviations, bent where they are far; what ran away is held."""
    e = np.nan_to_num(innovation / np.sqrt(f.variance), nan=RUNAWAY, posinf=RUNAWAY, neginf=-RUNAWAY)
    return bent(np.clip(e, -RUNAWAY, RUNAWAY))


def innovations(
    run: Recorded, p: Array, gain: Array, memory_s: float, *, track: Array | None = None, restart: Array | None = None
) -> Array:
    """Measured less predicted, (M,); zeros as gain are pure simulation. See `kernels.simulate`."""
    out, none = np.empty(run.time_s.size), np.empty((0, kernels.SIZE))
    kernels.simulate(
        run.hull(p),
        run.start,
        run.steps,
        run.record,
        run.drive(p),
        gain,
        memory_s,
        none if restart is None else restart,
        out,
        none if track is None else track,
    )
    return out


def filtered(run: Recorded, p: Array, noise: Noise) -> Filtered:
    """Extended Kalman filter along a run; InputError where the motion diverges."""
    size = run.time_s.size
    innovation, variance, explained, gain = (*np.empty((3, size)), np.zeros((size, kernels.SIZE)))
    kernels.kalman(
        run.hull(p), run.start, run.spread, run.steps, run.record, run.drive(p), noise.variance[run.column],
        noise.sigma * run.moves, noise.memory_s, innovation, variance, gain, explained,
    )  # fmt: skip
    if not np.isfinite(innovation).all():
        lost = run.time_s[~np.isfinite(innovation)].min()
        raise InputError(f"run {run.name}: the simulation diverges at {lost:.4g} s; are units and signs right?")
    return Filtered(innovation, variance, gain, explained)
