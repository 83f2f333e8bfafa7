"""The compiled kernels that move a whole vehicle along a recording and read its instruments.

What an estimator carries is the motion x, 12 numbers, on each axis a disturbance, an Ornstein-Uhlenbeck acceleration
(or, in place of the first three, the speed of the water north, east, and down), and the slow error of each column that
has one, such a process as well. Farrell, Aided Navigation (2008), ch. 4: errors of inertial instruments as white noise
and Gauss-Markov processes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..compiled import law, lean, term
from .layout import COLUMN, FIN, HULL, LATENCY, SCALE, SENSOR, SKEW, THRUSTER
from .motion import advance, rates
from .readings import ACCEL, ANGLES, read
from .steps import FIRST, TOUCH_S

SIZE = 18  # states and disturbances
LEAST = 0.01  # of a turn, of which an instrument makes nothing
ROLL, HEADING = ANGLES[0], ANGLES[2]


class Record(NamedTuple):
    """M measurements: channel, instrument, column, value, stamp [s] and nominal delay [s]; and the wall: of `read`.

    They are compared in the order in which they were true at the nominal delays, whatever delays are tried: gains
    belong to an order. What is later or earlier than that is read from a state that is wound back or on.
    """

    kind: np.ndarray
    sensor: np.ndarray
    column: np.ndarray
    value: np.ndarray
    stamp: np.ndarray
    late: np.ndarray
    home: np.ndarray
    wall: float
    facing: float


class Gains(NamedTuple):
    """What M innovations do to states, disturbances and S slow errors, (M, 18 + S), and how soon the latter are over.

    memory: of the disturbance of each axis [s], (6,); slow_s: of the slow errors [s], (S,); slow: which of these a
    column has, (C,), -1 for none. stir: how a speed of the water north, east, and down accelerates each axis over
    each step [1/s], (N, 6, 3); (0, 6, 3) where disturbances are accelerations.
    """

    of: np.ndarray
    memory: np.ndarray
    slow: np.ndarray
    slow_s: np.ndarray
    stir: np.ndarray


@term
def stirred(d, stir, i):
    """Disturbances, (6,), as the accelerations that they are in step i, in place."""
    if stir.shape[0]:
        u, v, w = d[0], d[1], d[2]
        for a in range(6):
            own = d[a] if a >= 3 else 0.0
            d[a] = own + stir[i, a, 0] * u + stir[i, a, 1] * v + stir[i, a, 2] * w


@lean
def tied(x, drive, i):
    """Set the motion that is known at the start of step i, in place on x, shape (12,)."""
    for a in range(9):
        if drive.knows[a]:
            x[3 + a] = drive.known[i, a]


@term
def lasting(h, memory):
    """What is left of a disturbance after h [s], and its mean over them, as shares."""
    keep = math.exp(-h / memory)
    return keep, (1.0 - keep) * memory / h


@lean
def moved(x, d, t, h, memory, stir, drive, i, hull, k, y, push):
    """State x and disturbances d, in place, after step i of h [s]."""
    for a in range(6):
        keep, mean = lasting(h, memory[a])
        push[a] = d[a] * mean
        d[a] *= keep
    stirred(push, stir, i)
    tied(x, drive, i)
    step, change = h / hull.often, 2.0 / hull.often
    for n in range(hull.often):
        advance(t + n * step, x, step, drive, i, n * change - 1.0, (n + 1) * change - 1.0, push, hull, k, y)


@lean
def wound(x, d, t, late, steps, drive, i, hull, k, y):
    """The state wound back by `late` [s], in place, through the steps before step i; on where that is negative."""
    while late > TOUCH_S and i > 0:
        i -= 1
        h = min(late, steps.length[i])
        advance(t, x, -h, drive, i, 0.0, 0.0, d, hull, k, y)
        t, late = t - h, late - h
    while late < -TOUCH_S and i < steps.length.size:
        h = min(-late, steps.length[i])
        advance(t, x, h, drive, i, 0.0, 0.0, d, hull, k, y)
        t, late, i = t + h, late + h, i + 1


@term
def lateness(m, record, hull):
    """How much later [s] than at the nominal delay the state is that measurement m tells of; earlier where negative."""
    p, s = hull.p, HULL + THRUSTER * hull.counts[0] + FIN * hull.counts[1] + SENSOR * record.sensor[m]
    return p[s + LATENCY] + p[s + SKEW] * record.stamp[m] - record.late[m]


@term
def told(m, x, rate, record, hull):
    """What measurement m reads in the state x where that changes at `rate`, both (18,)."""
    kind, sensor, column = record.kind[m], record.sensor[m], record.column[m]
    return read(kind, sensor, column, x, rate, hull.p, hull.counts, record.home, record.wall, record.facing)


@term
def seen(m, t, x, d, record, steps, drive, i, hull, scratch):
    """Prediction of measurement m in the state x under accelerations d; i is the step that comes next."""
    if record.kind[m] < ACCEL and abs(lateness(m, record, hull)) <= TOUCH_S:
        return told(m, x, scratch[1], record, hull)
    return elsewhere(m, t, x, d, record, steps, drive, i, hull, scratch)


@lean
def elsewhere(m, t, x, d, record, steps, drive, i, hull, scratch):
    """As `seen`, of what is true at another time than that of the state, or goes by its rates."""
    x0, rate, k, y = scratch[0], scratch[1], scratch[2:7], scratch[7]
    late, here = lateness(m, record, hull), x
    if abs(late) > TOUCH_S:
        for a in range(18):
            x0[a] = x[a]
        wound(x0, d, t, late, steps, drive, i, hull, k, y)
        here = x0
    if record.kind[m] >= ACCEL:
        before, j, thrust = max(i - 1, 0), min(i, drive.thrust.shape[0] - 1), scratch[8]
        fins = drive.fins[j]
        for a in range(6):  # between the end of the step before and the start of that after
            ended, begins = drive.thrust[before, a] + drive.swing[before, a], drive.thrust[j, a] - drive.swing[j, a]
            thrust[a] = 0.5 * (ended + begins)
        if drive.fins.shape[1] <= y.size:  # of more fins than there is room for, those after
            fins = y
            for a in range(drive.fins.shape[1]):
                fins[a] = 0.5 * (drive.fins[before, a] + drive.turn[before, a] + drive.fins[j, a] - drive.turn[j, a])
        rates(t, here, thrust, drive.asked[j], fins, d, drive.known[j, 9:], hull, rate)
    return told(m, here, rate, record, hull)


@term
def folded(e, m, record, hull):
    """A difference of readings such as measurement m; of angles within half a turn of what its instrument calls one."""
    if ROLL <= record.kind[m] <= HEADING:
        c = (
            HULL
            + THRUSTER * hull.counts[0]
            + FIN * hull.counts[1]
            + SENSOR * hull.counts[2]
            + COLUMN * record.column[m]
        )
        turn = 2.0 * math.pi * max(abs(hull.p[c + SCALE]), LEAST)
        return e - turn * round(e / turn)
    return e


@term
def fade(b, h, slow_s):
    """Slow errors after h [s], in place, (S,)."""
    for k in range(b.size):
        b[k] *= math.exp(-h / slow_s[k])


@law
def simulate(hull, start, steps, record, drive, gains, restart, out, track):
    """Measured less predicted along a run with given gains, into `out`, (M,).

    gains: zeros for pure simulation; start: (12,); track: the states at every measurement, (M, 18), or of
    shape (0, 18); restart: states to begin anew with before some measurements, NaN elsewhere, (M, 18) or (0, 18).
    """
    x, d, k, y, b = np.zeros(18), np.zeros(6), np.empty((5, 18)), np.empty(18), np.zeros(gains.slow_s.size)
    x[:12] = start
    along(hull, steps, record, drive, gains, restart, out, track, x, d, b, k, y, np.zeros(6), np.zeros((9, 18)))


@lean
def along(hull, steps, record, drive, gains, restart, out, track, x, d, b, k, y, push, scratch):
    """As `simulate`, from the motion x, disturbances d and slow errors b on, in place; k, y, push, scratch: to use."""
    gain, i, t = gains.of, FIRST, steps.now[0] if steps.now.size else 0.0
    for q in range(steps.which.size):
        m = steps.which[q]
        while i < steps.upto[q]:
            moved(x, d, t, steps.length[i], gains.memory, gains.stir, drive, i, hull, k, y, push)
            fade(b, steps.length[i], gains.slow_s)
            t += steps.length[i]
            i += 1
        if restart.shape[0] and not math.isnan(restart[m, 0]):
            for a in range(12):
                x[a] = restart[m, a]
            for a in range(6):
                d[a] = restart[m, 12 + a]
        for a in range(6):
            push[a] = d[a]
        stirred(push, gains.stir, max(i - 1, 0))
        here = seen(m, t, x, push, record, steps, drive, i, hull, scratch)
        out[m], slow = folded(record.value[m] - here, m, record, hull), gains.slow[record.column[m]]
        if slow >= 0:
            out[m] -= b[slow]
        for a in range(12):
            x[a] += gain[m, a] * out[m]
        for a in range(6):
            d[a] += gain[m, 12 + a] * out[m]
        for a in range(b.size):
            b[a] += gain[m, SIZE + a] * out[m]
        for a in range(SIZE if track.shape[0] else 0):
            track[m, a] = x[a] if a < 12 else d[a - 12]
