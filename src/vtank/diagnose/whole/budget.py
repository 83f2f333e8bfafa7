"""The gap budget of a whole vehicle: whose the error of simulation is, in each measured column and in all.

Each model is simulated through stretches of a recording from where its own filter stands at their beginning, with
parameters from which the stretch has been left out (the normal equations without it), and mean squares are compared:
what own parameters take off, what each effect takes off, what is sensor noise, and what is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...rigid.filtered import Filtered, free, innovations, share
from ...rigid.recorded import Recorded
from ..budget import Line
from .lesser import without
from .model import Model
from .score import based
from .selection import Selection

Array = NDArray[np.float64]
STRETCH_S = 15.0  # [s] that a simulation runs free: long against a vehicle's own times, short of drifting off; a choice
FOLDS = 5  # parts of time that are left out in turn where there are fewer than MANY runs; a choice
MANY = 4
SPIKE = 10.0  # deviations of an innovation beyond which a reading is its instrument's own; a choice
HELD = 10.0  # ranges of a column at which the error of a simulation that runs away is held; a choice
REDRAWN, SEED = 200, 0  # of stretches, for intervals


@dataclass(frozen=True, eq=False)
class Budget:
    """Lines in all and by column; root mean square errors by column of nominal, refit and diagnosed, and the noise.

    visible: by effect, how much it takes off the error that is left without it: at best (95 %) of all together, or at
        least (5 %) of one column, where others may drift far beyond what an instrument can be off by.
    """

    lines: tuple[Line, ...]
    columns: dict[str, tuple[Line, ...]]
    rms: dict[str, dict[str, float]]
    visible: dict[str, float]

    @property
    def left(self) -> float:
        """Share that neither own parameters, effects nor noise explain."""
        return sum(line.share for line in self.lines if line.kind in ("repeatable", "disturbance"))


def ladder(selection: Selection) -> list[tuple[str, str, Model]]:
    """Models from the nominal to the diagnosed one: what each adds, its kind, and the model."""
    steps = [("nominal", "nominal", selection.nominal), ("own parameters", "parameters", selection.own)]
    chain: list[tuple[str, str, Model]] = []
    model = selection.best
    while model.effects:
        if len(model.effects) == 1:
            chain.append((model.effects[0].name, "effect", model))
            break
        lesser = [(without(model, selection.layout, [placed], selection.found), placed) for placed in model.effects]
        smaller, placed = max(lesser, key=lambda pair: pair[0].log_evidence)
        chain.append((placed.name, "effect", model))
        model = smaller
    return steps + chain[::-1]


def budget(selection: Selection) -> Budget:
    """The budget; simulations of every model of the ladder."""
    steps, noise = ladder(selection), selection.best.fit.noise.errors
    best, found = selection.best, selection.found
    spikes = spikes_of(best, found)  # of the instruments themselves: they are the same whatever the model
    work = [partial(_squares, model, spikes, found if model is best else None) for _, _, model in steps]
    errors = share(work)  # each (stretches, C), and counts
    count = errors[0][1]
    seen = count.sum(axis=0) > 0
    squares = np.array([e for e, _ in errors])
    names = selection.layout.columns

    def levels(weight: Array, columns: NDArray[np.bool_]) -> Array:
        """Mean square errors over the noise, of every model."""
        n = np.maximum(weight @ count, 1e-12)
        return np.array([np.sum((weight @ e / n / noise)[columns]) for e in squares])

    def lines(weight: Array, columns: NDArray[np.bool_]) -> Array:
        """Shares along the ladder, then what is left and noise."""
        level = levels(weight, columns)
        floor = float(columns.sum())
        total = max(level[0], 1e-12)
        steps_ = (level[:-1] - level[1:]) / total
        quiet = min(floor, level[-1]) / total
        return np.concatenate([steps_, [level[-1] / total - quiet, quiet]])

    rng, size = np.random.default_rng(SEED), count.shape[0]
    draws = [np.bincount(rng.integers(size, size=size), minlength=size).astype(float) for _ in range(REDRAWN)]
    kinds = [(name, kind) for name, kind, _ in steps[1:]]
    repeats = any(block.repeats for block in selection.blocks)
    kinds += [("unnamed, repeats" if repeats else "disturbance", "repeatable" if repeats else "disturbance")]
    kinds += [("sensor noise", "noise")]

    def shares(columns: NDArray[np.bool_]) -> tuple[Line, ...]:
        now = lines(np.ones(size), columns)
        others = np.array([lines(weight, columns) for weight in draws])
        low, high = np.percentile(others, [5.0, 95.0], axis=0)
        return tuple(Line(name, kind, float(v), (float(a), float(b)))
                     for (name, kind), v, a, b in zip(kinds, now, low, high, strict=True))  # fmt: skip

    each = {name: shares(np.arange(len(names)) == c) for c, name in enumerate(names) if seen[c]}
    rms = {}
    for c in np.flatnonzero(seen):
        root = [float(np.sqrt(e[:, c].sum() / count[:, c].sum())) for e in squares]
        rms[names[c]] = {"nominal": root[0], "refit": root[1], "diagnosed": root[-1], "noise": float(np.sqrt(noise[c]))}

    def taken(columns: NDArray[np.bool_], percentile: float) -> Array:
        """Share of the error that each step of the ladder takes off what is left before it."""
        drawn = np.array([levels(weight, columns) for weight in draws])
        gone = 1.0 - drawn[:, 1:] / np.maximum(drawn[:, :-1], 1e-12)
        return np.asarray(np.percentile(gone, percentile, axis=0))

    surely = [taken(np.arange(len(names)) == c, 5.0) for c in np.flatnonzero(seen)]
    most = np.max([taken(seen, 95.0), *surely], axis=0)
    still = {placed.name for placed in selection.best.effects if not any(q.slots for q in placed.parameters)}
    effects = zip(steps[1:], most, strict=True)  # but those of readings that stand alone, which move no simulation
    visible = {name: float(share) for (name, kind, _), share in effects if kind == "effect" and name not in still}
    return Budget(shares(seen), each, rms, visible)


def _squares(
    model: Model, spikes: Sequence[NDArray[np.bool_]], found: Sequence[Filtered] | None
) -> tuple[Array, Array]:
    """`free_errors` with parameters from which each part has been left out; found: the filter, where there is one."""
    found = found or model.fit.filter(model.vector())
    folds = _folds(model)
    return free_errors(model, spikes, found, folds, [model.vector(theta) for theta in _left_out(model, found, folds)])


def spikes_of(model: Model, found: Sequence[Filtered] | None = None) -> list[NDArray[np.bool_]]:
    """Readings of each run that are their instrument's own, as far off as they are from the filter, (M,)."""
    return [np.abs(f.innovation) > SPIKE * np.sqrt(f.variance) for f in found or model.fit.filter(model.vector())]


def free_errors(
    model: Model, spikes: Sequence[NDArray[np.bool_]] | None = None, found: Sequence[Filtered] | None = None,
    folds: Sequence[NDArray[np.int64]] | None = None, vectors: Sequence[Array] | None = None,
) -> tuple[Array, Array]:  # fmt: skip
    """Sums of squared errors of free simulation through stretches, and counts, by stretch and column, (R, C).

    spikes: readings that count for no model (default: none). folds: part of every measurement, and the parameters for
    it; by default the model's own for all.
    """
    fit, columns = model.fit, len(model.fit.runs[0].layout.columns)
    found = found or fit.filter(model.vector())
    folds = folds or [np.zeros(run.time_s.size, dtype=np.int64) for run in fit.runs]
    spikes = spikes or [np.zeros(run.time_s.size, dtype=bool) for run in fit.runs]
    vectors, sums, counts = vectors or [model.vector()], [], []
    for run, f, fold, spike in zip(fit.runs, found, folds, spikes, strict=True):
        stretch = _stretches(run.time_s - run.late)
        for part in np.unique(fold):
            e = _free(run, vectors[part], f, stretch)
            for s in np.unique(stretch[fold == part]):
                mine = (stretch == s) & (fold == part) & ~spike & run.layout.judged[run.column]
                sums.append(np.bincount(run.column[mine], e[mine] ** 2, columns))
                counts.append(np.bincount(run.column[mine], minlength=columns))
    return np.array(sums), np.array(counts)


def _free(run: Recorded, p: Array, f: Filtered, stretch: NDArray[np.int64]) -> Array:
    """Measured less simulated, (M,), begun anew in each stretch where the filter stands, without its disturbance."""
    track, restart = np.empty((run.time_s.size, 18)), np.full((run.time_s.size, 18), np.nan)
    innovations(run, p, f.gains, track=track)
    run = run.as_measured()
    order = run.steps.which
    first = np.flatnonzero(np.diff(stretch[order])) + 1
    restart[order[first], :12], restart[order[first], 12:] = track[order[first - 1], :12], 0.0
    e = innovations(run, p, free(run), restart=restart)
    moves = np.array([np.ptp(run.value[run.column == c]) if (run.column == c).any() else 0.0
                      for c in range(len(run.layout.columns))])  # fmt: skip
    most = HELD * moves[run.column]
    return np.clip(np.nan_to_num(e, nan=np.inf), -most, most)


def _stretches(time_s: Array) -> NDArray[np.int64]:
    """Number of the stretch of each measurement; two at least, so that one can be left out and the other tells."""
    span = float(np.ptp(time_s)) or 1.0
    many = max(2, round(span / STRETCH_S))
    return np.minimum(((time_s - time_s.min()) / span * many).astype(int), many - 1)


def _folds(model: Model) -> list[NDArray[np.int64]]:
    """Which part every measurement belongs to that is left out at a time: whole runs, or parts of time."""
    runs = model.fit.runs
    if len(runs) >= MANY:
        return [np.full(run.time_s.size, k) for k, run in enumerate(runs)]
    found = []
    for k, run in enumerate(runs):
        stretch = _stretches(run.time_s - run.late)
        parts = min(FOLDS, int(stretch.max()) + 1)
        found.append(k * FOLDS + stretch * parts // (int(stretch.max()) + 1))
    return found


def _left_out(model: Model, found: Sequence[Filtered], folds: Sequence[NDArray[np.int64]]) -> list[Array]:
    """Unknowns with each part left out, by one Newton step of the normal equations without it, if a body allows it."""
    count = max(int(fold.max()) for fold in folds) + 1
    if not model.unknowns:
        return [model.theta] * count
    base = based(model, found)
    J, e = base.J, base.e
    H = J.T @ J + np.diag(np.array([u.scale for u in model.unknowns]) ** -2.0)
    part = np.concatenate(list(folds))
    low, high = np.array([u.low for u in model.unknowns]), np.array([u.high for u in model.unknowns])
    thetas = []
    for fold in range(count):
        mine = part == fold
        move = np.linalg.solve(H - J[mine].T @ J[mine], J[mine].T @ e[mine]) if mine.any() else 0.0
        tried = (np.clip(model.theta + length * move, low, high) for length in (1.0, 0.5, 0.25, 0.1))
        thetas.append(next((theta for theta in tried if _is_a_body(model, theta)), model.theta))
    return thetas


def _is_a_body(model: Model, theta: Array) -> bool:
    """Whether the masses at these unknowns are positive definite."""
    try:
        model.fit.runs[0].hull(model.vector(theta))
    except InputError:
        return False
    return True
