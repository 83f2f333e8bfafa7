"""What many small changes of a model would do to its innovations, from one pass along the run.

A change of a law is an acceleration along the path that the filter took, a change of an instrument is a shift of its
readings; both run on through the linearised motion and the filter's gains. Exact in the law, linear in what follows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..compiled import law
from .filtered import FAR, Filtered, bent, share
from .kernels import NUDGE, SIZE, differ, moved, parted, pulled, seen
from .layout import WAKE
from .motion import rates
from .recorded import Recorded

Array = NDArray[np.float64]
WIDE = 96  # changes that are followed at a time; a choice


@law
def followed(hull, start, steps, record, drive, gain, memory, path, before):
    """States and disturbances of a filter at the starts of steps, (N + 1, 18), and before measurements, (M, 18)."""
    x, d, k, y = np.zeros(18), np.zeros(6), np.empty((4, 18)), np.empty(18)
    push, scratch, i, t = np.zeros(6), np.zeros((8, 18)), 0, steps.now[0] if steps.now.size else 0.0
    x[:12] = start
    for q in range(steps.which.size):
        m = steps.which[q]
        while i < steps.upto[q]:
            path[i, :12], path[i, 12:] = x[:12], d
            moved(x, d, t, steps.length[i], memory, drive, i, hull, k, y, push)
            t += steps.length[i]
            i += 1
        before[m, :12], before[m, 12:] = x[:12], d
        e = parted(record.value[m] - seen(m, t, x, d, record, steps, drive, i, hull, scratch), record.kind[m])
        for a in range(12):
            x[a] += gain[m, a] * e
        for a in range(6):
            d[a] += gain[m, 12 + a] * e
    path[i:, :12], path[i:, 12:] = x[:12], d


@law
def accelerations(hull, steps, drive, path, out):
    """Acceleration of each axis along a path, amid each step, into (N, 6)."""
    x, still, rate = np.zeros(18), np.zeros(6), np.zeros(18)
    for i in range(steps.now.size):
        for a in range(12):
            x[a] = 0.5 * (path[i, a] + path[i + 1, a])
        t = steps.now[i] + 0.5 * steps.length[i]
        rates(t, x, drive.thrust[i], drive.asked[i], drive.fins[i], still, drive.known[i, 9:], hull, rate)
        out[i] = rate[6:12]


@law
def shifted(hull, other, steps, record, drive, before, out):
    """What an instrument that is described otherwise would read over what it reads, along the path, into (M,)."""
    x, d, scratch = np.zeros(18), np.zeros(6), np.zeros((8, 18))
    for q in range(steps.which.size):
        m, i = steps.which[q], steps.upto[q]
        t = record.stamp[m] - record.late[m]
        x[:12], d[:] = before[m, :12], before[m, 12:]
        here = seen(m, t, x, d, record, steps, drive, i, hull, scratch)
        out[m] = seen(m, t, x, d, record, steps, drive, i, other, scratch) - here


@law
def tangents(hull, start, steps, record, drive, gain, memory, push, shift, out):
    """Change of the innovations, (M, W), under accelerations `push`, (W, N, 6), and shifts of readings, (W, M)."""
    wide = out.shape[1]
    x, d, k, y = np.zeros(18), np.zeros(6), np.empty((4, 18)), np.empty(18)
    scratch, along, H = np.zeros((8, 18)), np.zeros(6), np.zeros(SIZE)
    X, Y, E, F = np.zeros((SIZE, wide)), np.zeros((SIZE, wide)), np.zeros(wide), np.zeros((SIZE, SIZE))
    s, base, everywhere, i, t = np.zeros(18), np.zeros(18), np.ones(6), 0, steps.now[0] if steps.now.size else 0.0
    x[:12] = start
    for q in range(steps.which.size):
        m = steps.which[q]
        while i < steps.upto[q]:
            h = steps.length[i]
            keep = math.exp(-h / memory)
            mean = (1.0 - keep) * memory / h
            s[:12], s[12:] = x[:12], d
            wakes = x[12:].copy()
            for c in range(-1, 12):
                if 0 <= c < 3 and not pulled(hull):
                    F[c, c] = 1.0
                    continue
                x[:12], x[12:], d[:] = s[:12], wakes, s[12:]
                if c >= 0:
                    x[c] += NUDGE
                moved(x, d, t, h, memory, drive, i, hull, k, y, along)
                if c < 0:
                    base[:] = x
                else:
                    for a in range(12):
                        F[a, c] = (x[a] - base[a]) / NUDGE
            x[:] = base
            for a in range(12):
                for w in range(wide):
                    Y[a, w] = 0.0
                for c in range(12):
                    f = F[a, c]
                    if f != 0.0:
                        for w in range(wide):
                            Y[a, w] += f * X[c, w]
                for c in range(6):
                    f = 0.5 * h * (F[a, 6 + c] + (1.0 if a == 6 + c else 0.0))
                    if f != 0.0:
                        for w in range(wide):
                            Y[a, w] += f * (mean * X[12 + c, w] + push[w, i, c])
            for w in range(wide):
                for a in range(12):
                    X[a, w] = Y[a, w]
                for a in range(12, SIZE):
                    X[a, w] *= keep
            t += h
            i += 1
        s[:12], s[12:] = x[:12], d
        differ(m, t, s, x, d, record, steps, drive, i, hull, scratch, everywhere, H)
        e = parted(record.value[m] - seen(m, t, x, d, record, steps, drive, i, hull, scratch), record.kind[m])
        j = min(i, push.shape[1] - 1)
        for w in range(wide):
            E[w] = -shift[w, m]
        for a in range(SIZE):
            if H[a] != 0.0:
                for w in range(wide):
                    E[w] -= H[a] * X[a, w]
                if a >= 12:
                    for w in range(wide):
                        E[w] -= H[a] * push[w, j, a - 12]
        for w in range(wide):
            out[m, w] = E[w]
        for a in range(SIZE):
            g = gain[m, a]
            if g != 0.0:
                for w in range(wide):
                    X[a, w] += g * E[w]
                if a < 12:
                    x[a] += g * e
                else:
                    d[a - 12] += g * e


class Path:
    """A filter's path along one run, from which changes are followed."""

    def __init__(self, run: Recorded, p: Array, f: Filtered, memory_s: float) -> None:
        self.run, self.p, self.f, self.memory_s = run, p, f, memory_s
        self.hull, self.drive = run.hull(p), run.drive(p)
        self.states = np.empty((run.steps.now.size + 1, SIZE))
        self.before = np.empty((run.time_s.size, SIZE))
        followed(self.hull, run.start, run.steps, run.record, self.drive, f.gain, memory_s, self.states, self.before)
        self.acceleration = np.empty((run.steps.now.size, 6))
        accelerations(self.hull, run.steps, self.drive, self.states, self.acceleration)

    def cause(self, p: Array) -> tuple[Array, Array] | None:
        """Acceleration, (N, 6), and shift of readings, (M,), of another parameter vector; None for a new memory."""
        run, first = self.run, self.run.layout.starts[2]
        if np.any(p[WAKE : WAKE + 6] != self.p[WAKE : WAKE + 6]):
            return None
        push, shift = np.zeros((run.steps.now.size, 6)), np.zeros(run.time_s.size)
        hull = run.hull(p)
        if np.any(p[:first] != self.p[:first]):
            accelerations(hull, run.steps, run.drive(p), self.states, push)
            push = np.where(run.moves, push - self.acceleration, 0.0)
        if np.any(p[first:] != self.p[first:]):
            shifted(self.hull, hull, run.steps, run.record, self.drive, self.before, shift)
        return push, shift

    def follow(self, causes: Sequence[tuple[Array, Array]]) -> Array:
        """Changes of the innovations over their deviations, (M, L)."""
        run, size = self.run, len(causes)
        found = np.empty((run.time_s.size, size))

        def part(first: int) -> None:
            some = causes[first : first + WIDE]
            out = np.empty((run.time_s.size, len(some)))
            tangents(
                self.hull, run.start, run.steps, run.record, self.drive, self.f.gain, self.memory_s,
                np.array([push for push, _ in some]), np.array([shift for _, shift in some]), out,
            )  # fmt: skip
            found[:, first : first + WIDE] = out

        share([partial(part, first) for first in range(0, size, WIDE)])
        root = np.sqrt(self.f.variance)
        z = self.f.innovation / root
        slope = np.where(np.abs(z) <= FAR, 1.0, FAR / np.maximum(np.abs(bent(z)), FAR))  # of the bent residuals
        return found * (slope / root)[:, None]


def changes(
    runs: Sequence[Recorded], p: Array, found: Sequence[Filtered], memory_s: float, vectors: Sequence[Array]
) -> tuple[Array, NDArray[np.bool_]]:
    """Changes of innovations over their deviations for other parameter vectors, (sum M, L); which were followed."""
    parts, done = [], np.ones(len(vectors), bool)
    for run, f in zip(runs, found, strict=True):
        path = Path(run, p, f, memory_s)
        causes = share([partial(path.cause, q) for q in vectors])
        for i, cause in enumerate(causes):
            if cause is None:
                done[i] = False
                causes[i] = np.zeros((run.steps.now.size, 6)), np.zeros(run.time_s.size)
        parts.append(path.follow(causes))
    return np.concatenate(parts), done
