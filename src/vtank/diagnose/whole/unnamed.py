"""What has no name: a free-form force along an axis, or a free-form error of a column, and the evidence for it.

A block is a sum of functions of the motion, the thrust, the place and time, with coefficients normally distributed
about zero at a size that is marginalised over; its gain of evidence is that of a Gaussian linear model (Rasmussen and
Williams (2006), ch. 2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...rigid.filtered import Filtered
from ...rigid.layout import AXES
from ...rigid.places import Sizes
from ...rigid.recorded import Recorded
from .model import Model
from .screen import Base

Array = NDArray[np.float64]
SHARES = (0.03, 0.1, 0.3, 1.0)  # of the usual force of an axis, or of a column's deviation: sizes of a coefficient
BUMPS = 6  # windows of time in a run
SUSPECTS = 2  # columns whose innovations are the least white, which are looked at; a choice


@dataclass(frozen=True, eq=False)
class Block:
    """A free-form part: where it acts, its gain of log evidence, and the size at which it is likeliest."""

    place: str
    channel: str
    gain: float
    columns: Array
    size: float


def forces(model: Model, base: Base, tracks: Sequence[Array], sizes: Sizes) -> list[Block]:
    """A block for every axis that is asked about, the strongest first."""
    runs = model.fit.runs
    asked = np.flatnonzero(runs[0].asked)
    p = model.vector()
    blocks = []
    for axis in map(int, asked):
        pairs = zip(runs, tracks, strict=True)
        functions = [_functions(run, p, track, sizes, axis, asked) for run, track in pairs]
        unit = sizes.force[axis] / _inertia(runs[0], p, axis)
        columns = _pushed(base, functions, axis, unit)
        gain, size = evidence(base, columns)
        blocks.append(Block(AXES[axis], "hydrodynamics", gain, columns, size))
    return sorted(blocks, key=lambda block: -block.gain)


def _inertia(run: Recorded, p: Array, axis: int) -> float:
    hull = run.hull(p)
    return float(hull.body[axis, axis] + hull.water[axis, axis])


def _functions(run: Recorded, p: Array, track: Array, sizes: Sizes, axis: int, asked: NDArray[np.int64]) -> Array:
    """Functions of the motion along a run's steps, (N, Q)."""
    steps, drive = run.steps, run.drive(p)
    order = steps.which
    times = np.maximum.accumulate(steps.now[np.minimum(steps.upto, steps.now.size - 1)][np.arange(order.size)])
    motion = np.array([np.interp(steps.now, times, track[order, i]) for i in range(12)]).T
    v = motion[:, 6:] / sizes.speed
    force = drive.thrust[:, axis]
    force = force / max(float(np.sqrt(np.mean(force**2))), 1e-9)
    x = (motion[:, axis] - motion[0, axis]) / sizes.away[axis] if axis != 5 else np.sin(motion[:, 5])
    t = (steps.now - steps.now[0]) / max(float(np.ptp(steps.now)), 1e-9)
    own = v[:, axis]
    found = [np.ones_like(own), own, own * np.abs(own), own**3, np.abs(own), own**2, np.tanh(3.0 * own)]
    found += [force, np.abs(force), force * np.abs(force), force * own, np.tanh(3.0 * force), x, x * x, x * own]
    others = [j for j in asked if j != axis]
    found += [g for j in others for g in (v[:, j], v[:, j] ** 2, v[:, j] * own, np.abs(v[:, j]) * own)]
    found += [v[:, j] * v[:, k] for n, j in enumerate(others) for k in others[n + 1 :]]
    found += [t - 0.5, own * (t - 0.5)]
    found += [np.exp(-0.5 * ((t - (b + 0.5) / BUMPS) * BUMPS * 1.5) ** 2) for b in range(BUMPS)]
    columns = np.array(found).T
    return np.asarray(columns / np.maximum(np.sqrt(np.mean(columns**2, axis=0)), 1e-9))


def _pushed(base: Base, functions: Sequence[Array], axis: int, unit: float) -> Array:
    """Innovations' answer to each function as an acceleration of an axis, over `unit`, (sum M, Q)."""
    parts = []
    for path, g in zip(base.paths, functions, strict=True):
        causes = []
        for function in g.T:
            push = np.zeros((function.size, 6))
            push[:, axis] = unit * function
            causes.append((push, np.zeros(path.run.time_s.size)))
        parts.append(path.follow(causes))
    return np.concatenate(parts)


def errors(model: Model, base: Base, found: Sequence[Filtered], tracks: Sequence[Array], sizes: Sizes) -> list[Block]:
    """A block for each of the columns whose innovations are the least white, the strongest first."""
    runs, layout = model.fit.runs, model.fit.runs[0].layout
    lag = [unwhite(runs, found, [c]) for c in range(len(layout.columns))]
    blocks = []
    for c in np.argsort(lag)[::-1][:SUSPECTS]:
        unit = float(np.std(np.concatenate([run.value[run.column == c] for run in runs]))) or 1.0
        parts = []
        for run, f, track, path in zip(runs, found, tracks, base.paths, strict=True):
            functions, causes = _readings(run, f, track, sizes, int(c), unit), []
            for function in functions.T:
                shift = np.zeros(run.time_s.size)
                shift[run.column == c] = unit * function
                causes.append((np.zeros((run.steps.now.size, 6)), shift))
            parts.append(path.follow(causes))
        columns = np.concatenate(parts)
        gain, size = evidence(base, columns)
        blocks.append(Block(layout.columns[c].rpartition(".")[0] or layout.columns[c], "sensor", gain, columns, size))
    return sorted(blocks, key=lambda block: -block.gain)


def _readings(run: Recorded, f: Filtered, track: Array, sizes: Sizes, c: int, unit: float) -> Array:
    """Functions of what a column was expected to read, which its own noise is not in, and of the motion, (M_c, Q)."""
    mine = run.column == c
    z, t = (run.value[mine] - f.innovation[mine]) / unit, run.time_s[mine]
    t = (t - t[0]) / max(float(np.ptp(t)), 1e-9)
    before = np.vstack([track[:1], track[:-1]])  # the state without what this very sample told
    v = before[mine, 6:12] / sizes.speed
    moving = [i for i in range(6) if run.asked[i]]
    found = [np.ones_like(z), z, z * z, np.abs(z), np.sin(2.0 * z), np.sin(before[mine, 5]), np.cos(before[mine, 5])]
    found += [g for i in moving for g in (v[:, i], v[:, i] * np.abs(v[:, i]))]
    found += [t - 0.5, z * (t - 0.5)]
    found += [np.exp(-0.5 * ((t - (b + 0.5) / BUMPS) * BUMPS * 1.5) ** 2) for b in range(BUMPS)]
    columns = np.array(found).T
    return np.asarray(columns / np.maximum(np.sqrt(np.mean(columns**2, axis=0)), 1e-9))


def unwhite(runs: Sequence[Recorded], found: Sequence[Filtered], columns: Sequence[int]) -> float:
    """How far innovations of these columns follow one another: their largest first autocorrelation, in deviations."""
    most = 0.0
    for c in columns:
        for run, f in zip(runs, found, strict=True):
            mine = run.column == c
            z = f.innovation[mine] / np.sqrt(f.variance[mine])
            if z.size > 2:
                most = max(most, abs(float(z[1:] @ z[:-1])) / np.sqrt(z.size))
    return most


def evidence(base: Base, columns: Array) -> tuple[float, float]:
    """Gain of log evidence of a block, own unknowns readapted, over sizes alike likely; and the likeliest size."""
    gram = base.gram(np.column_stack([base.e, columns]))
    G, b = gram[1:, 1:], gram[1:, 0]
    values, vectors = np.linalg.eigh(0.5 * (G + G.T))
    values, b = np.maximum(values, 0.0), vectors.T @ b
    gains = []
    for size in SHARES:
        s2 = size**2 / np.sqrt(columns.shape[1])
        gains.append(0.5 * float(np.sum(s2 * b * b / (1.0 + s2 * values)) - np.sum(np.log1p(s2 * values))))
    top = max(gains)
    return top + float(np.log(np.mean(np.exp(np.array(gains) - top)))), SHARES[int(np.argmax(gains))]
