"""What many small changes of a model would do to its innovations, from one pass along the run.

A change of a law is an acceleration along the path that the filter took, a change of an instrument is a shift of its
readings; both run on through the linearised motion and the filter's gains. Exact in the law, linear in what follows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from ..compiled import law, lean
from ..lanes import WIDTH, load, store
from .filtered import FAR, THREADS, Filtered, bent, followed, share
from .kalman import Way, pushing, through
from .kernels import SIZE, Gains, folded, lasting, seen, stirred
from .layout import COLUMN, HULL, SENSOR, WAKE, WALL_MASS, Hull
from .motion import rates
from .recorded import Recorded
from .steps import FIRST, Steps

Array = NDArray[np.float64]
Cause = Callable[[slice], tuple[Array, Array] | None]  # pushes, (N, 6, W), and shifts of readings, (M, W)
AT_ONCE = WIDTH * THREADS  # changes that keep all threads at work


@law
def accelerations(hull, steps, drive, path, out):
    """Acceleration of each axis along a path, amid each step, into (N, 6)."""
    accelerated(hull, steps, drive, path, out, np.zeros(18), np.zeros(6), np.zeros(18))


@lean
def accelerated(hull, steps, drive, path, out, x, still, rate):
    """As `accelerations`; x, rate, (18,): to use; still: no disturbance, (6,)."""
    for i in range(steps.now.size):
        for a in range(12):
            x[a] = 0.5 * (path[i, a] + path[i + 1, a])
        t = steps.now[i] + 0.5 * steps.length[i]
        rates(t, x, drive.thrust[i], drive.asked[i], drive.fins[i], still, drive.known[i, 9:], hull, rate)
        for a in range(6):
            out[i, a] = rate[6 + a]


@law
def shifted(hull, here, other, apart, steps, record, drive, before, stir, out):
    """What instruments that are described otherwise, `apart`, would read over `here` along the path, all (M,)."""
    x, d, scratch = np.zeros(18), np.zeros(6), np.zeros((9, 18))
    reread(hull, here, other, apart, steps, record, drive, before, stir, out, x, d, scratch)


@lean
def reread(hull, here, other, apart, steps, record, drive, before, stir, out, x, d, scratch):
    """As `shifted`; x, d, scratch: to use."""
    for q in range(steps.which.size):
        m, i = steps.which[q], steps.upto[q]
        out[m] = 0.0
        if apart[record.sensor[m]]:
            t = record.stamp[m] - record.late[m]
            for a in range(12):
                x[a] = before[m, a]
            for a in range(6):
                d[a] = before[m, 12 + a]
            stirred(d, stir, max(i - 1, 0))
            there = seen(m, t, x, d, record, steps, drive, i, other, scratch)
            out[m] = folded(there - here[m], m, record, hull)


def tangents(way: Way, steps: Steps, column: NDArray[np.int64], gains: Gains, push: Array, shift: Array) -> None:
    """Changes of innovations under accelerations, (N, 6, L), and shifts of readings, (M, L), in place of the latter."""
    for first in range(0, shift.shape[1], WIDTH):
        some = shift[:, first : first + WIDTH]
        count, pushes, changed = some.shape[1], push[..., first : first + WIDTH], some
        if some.shape != shift.shape or count < WIDTH:  # in lanes of their own
            pushes, changed = (np.zeros((*whole.shape[:-1], WIDTH)) for whole in (push, shift))
            pushes[..., :count], changed[:, :count] = push[..., first : first + WIDTH], some
        abreast(way, steps, column, gains, pushes.reshape(-1, WIDTH), changed)
        some[:] = changed[:, :count]


@law
def abreast(way, steps, column, gains, push, shift):
    """`tangents` of as many changes as there are lanes W; push: (6 N, W)."""
    wide, (keep, mean) = shift.shape[1], np.empty((2, 6))
    X, Y = np.zeros((SIZE + gains.slow_s.size, wide)), np.empty((12, wide))
    on_the_way(way, steps, column, gains, push, shift, X, Y, keep, mean)


@lean
def on_the_way(way, steps, column, gains, push, shift, X, Y, keep, mean):
    """As `abreast`, from the changed state X on, (18 + S, W); Y, (12, W), keep, mean, (6,): to use."""
    gain, last, i = gains.of, steps.now.size - 1, FIRST
    for q in range(steps.which.size):
        m = steps.which[q]
        while i < steps.upto[q]:
            h, F = steps.length[i], way.F[i]
            for c in range(6):
                keep[c], mean[c] = lasting(h, gains.memory[c])
            for a in range(12):
                on = 0.0 * load(X, a)
                for c in range(12):
                    if F[a, c] != 0.0:
                        on = on + F[a, c] * load(X, c)
                for c in range(6):
                    f = 0.5 * h * (F[a, 6 + c] + (1.0 if a == 6 + c else 0.0))
                    if f != 0.0:
                        on = on + f * load(push, 6 * i + c)
                    f = pushing(F, h, gains.stir, i, a, c) * mean[c]
                    if f != 0.0:
                        on = on + f * load(X, 12 + c)
                store(Y, a, on)
            for a in range(12):
                store(X, a, load(Y, a))
            for a in range(12, SIZE):
                store(X, a, keep[a - 12] * load(X, a))
            for a in range(gains.slow_s.size):
                store(X, SIZE + a, math.exp(-h / gains.slow_s[a]) * load(X, SIZE + a))
            i += 1
        e, own = -load(shift, m), gains.slow[column[m]]
        if own >= 0:
            e = e - load(X, SIZE + own)
        for a in range(12):
            if way.H[m, a] != 0.0:
                e = e - way.H[m, a] * load(X, a)
        for a in range(6):
            f = through(way.H[m], gains.stir, max(i - 1, 0), a)
            if f != 0.0:
                e = e - f * load(X, 12 + a)
            if way.H[m, 12 + a] != 0.0:
                e = e - way.H[m, 12 + a] * load(push, 6 * min(i, last) + a)
        store(shift, m, e)
        for a in range(X.shape[0]):
            if gain[m, a] != 0.0:
                store(X, a, load(X, a) + gain[m, a] * e)


class Path:
    """A filter's path along one run at parameters p, from which changes are followed; its own where that runs away."""

    def __init__(self, run: Recorded, p: Array, f: Filtered) -> None:
        self.run, self.p, self.f = run, p, f
        self.hull, self.drive = run.hull(p), run.drive(p)
        self.way, self.innovation = (f.way, f.innovation) if np.array_equal(p, f.p) else followed(run, p, f)
        if not (np.isfinite(self.innovation).all() and np.isfinite(self.way.states).all()):
            self.way, self.innovation = f.way, f.innovation
        root, z = f.root, f.unmoved(f.white(self.innovation))
        slope = np.where(np.abs(z) <= FAR, 1.0, FAR / np.maximum(np.abs(bent(z)), FAR))  # when bent
        self.weight = np.where(f.judged, slope / root, 0.0)
        self.acceleration = np.empty((run.steps.now.size, 6))
        accelerations(self.hull, run.steps, self.drive, self.way.states, self.acceleration)

    def cause(self, p: Array) -> tuple[Array, Array] | None:
        """Acceleration, (N, 6), and shift of readings, (M,), of another parameter vector; None for a new memory."""
        run, (_, fins, first, _) = self.run, self.run.layout.starts
        if np.any(p[WAKE : WAKE + 6] != self.p[WAKE : WAKE + 6]):
            return None
        push, shift = np.zeros((run.steps.now.size, 6)), np.zeros(run.time_s.size)
        hull, changed = run.hull(p), p != self.p
        if changed[:first].any():
            drive = run.drive(p)
            thrust_alone = not (changed[:HULL].any() or changed[fins:first].any() or p[WALL_MASS])
            if thrust_alone and not (hull.losing or self.hull.losing):  # which then is all that changes, linearly
                push = (drive.thrust - self.drive.thrust) @ hull.inverse.T
            else:
                accelerations(hull, run.steps, drive, self.way.states, push)
                push -= self.acceleration
            push = np.where(run.moves, push, 0.0)
        if np.any(p[first:] != self.p[first:]):
            self._read(hull, self.readings, self._apart(p), shift)
        return push, shift

    def _read(self, hull: Hull, over: Array, apart: NDArray[np.bool_], out: Array) -> None:
        """What instruments that are described otherwise would read over something along the path, into (M,)."""
        shifted(
            self.hull,
            over,
            hull,
            apart,
            self.run.steps,
            self.run.record,
            self.drive,
            self.way.before,
            self.f.gains.stir,
            out,
        )

    @cached_property
    def readings(self) -> Array:
        """What the instruments read along the path, (M,); of angles, within half a turn."""
        out = np.empty(self.run.time_s.size)
        self._read(self.hull, np.zeros(out.size), np.ones(len(self.run.layout.sensors), bool), out)
        return out

    def _apart(self, p: Array) -> NDArray[np.bool_]:
        """Which instruments are described otherwise, or whose columns are, (S,)."""
        (_, _, sensors, columns), layout = self.run.layout.starts, self.run.layout
        changed = p != self.p
        blocks = changed[sensors:columns].reshape(-1, SENSOR).any(axis=1)
        for c, name in enumerate(layout.columns):
            if changed[columns + COLUMN * c : columns + COLUMN * (c + 1)].any():
                blocks[layout.sensors.index(layout.vehicle.instrument(name))] = True
        return blocks

    def follow(self, push: Array, shift: Array) -> Array:
        """Changes of the innovations over their deviations, (M, L), under pushes, (N, 6, L), and shifts, (M, L)."""
        push, shift = np.ascontiguousarray(push), np.ascontiguousarray(shift)  # as lanes are laid out
        tangents(self.way, self.run.steps, self.run.column, self.f.gains, push, shift)
        shift *= self.weight[:, None]
        if self.f.wall.any():
            aside = self.f.aside * self.weight * self.f.root
            shift -= np.outer(aside, aside @ shift) / (aside @ aside)
        return shift


def follow_lanes(paths: Sequence[Path], causes: Sequence[Cause], out: Array) -> None:
    """Make all of out, (sum M, L): what each of L causes changes the innovations by, lanes shared by threads.

    causes: of each path, for a slice of these, pushes, (N, 6, W), and shifts of readings, (M, W), of W lanes; None
    leaves out as it is.
    """

    def follow(path: Path, cause: Cause, part: Array, some: slice) -> None:
        caused = cause(some)
        if caused is not None:
            part[:, some] = path.follow(*caused)[:, : some.stop - some.start]

    count, ends = out.shape[1], np.cumsum([path.run.time_s.size for path in paths])
    lanes = [slice(n, min(n + WIDTH, count)) for n in range(0, count, WIDTH)]
    each = zip(paths, causes, np.split(out, ends[:-1]), strict=True)
    share([partial(follow, *one, some) for one in each for some in lanes])


def changes(paths: Sequence[Path], vectors: Sequence[Array]) -> tuple[Array, NDArray[np.bool_]]:
    """Changes of innovations over their deviations for other parameter vectors, (sum M, L); which were followed."""
    out = np.empty((sum(path.run.time_s.size for path in paths), len(vectors)))
    done = np.ones(len(vectors), bool)

    def moved(path: Path, some: slice) -> tuple[Array, Array]:
        push, shift = (np.zeros((*size, WIDTH)) for size in ((path.run.steps.now.size, 6), (path.run.time_s.size,)))
        for i, q in enumerate(vectors[some]):
            cause = path.cause(q)
            if cause is None:
                done[some.start + i] = False
            else:
                push[..., i], shift[:, i] = cause
        return push, shift

    follow_lanes(paths, [partial(moved, path) for path in paths], out)
    return out, done
