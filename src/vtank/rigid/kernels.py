"""The compiled kernels of a whole vehicle: steps between instants, forces of thrusters, simulation, Kalman filter.

What an estimator carries is the motion x, 12 numbers, and on each axis a disturbance, an Ornstein-Uhlenbeck
acceleration that stands for turbulence. Thruster forces follow from the inputs alone, but for what speed takes off,
and are worked out beforehand as means over the steps, exact for delays and first-order lags of held inputs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..compiled import law
from .layout import (
    DEADBAND,
    DELAY,
    FIN,
    GAIN,
    HULL,
    LAG,
    LATENCY,
    MISREAD,
    SAG,
    SATURATION,
    SENSOR,
    SHARE,
    SKEW,
    SKEWED,
    SLOWER,
    SPRING,
    TETHER,
    THRUSTER,
    WATERLINE,
    WIRED,
)  # fmt: skip
from .motion import advance, rates
from .readings import ACCEL, ANGLES, read

TOUCH_S = 1e-10  # [s] instants closer than this are one
NUDGE = 1e-6  # [SI] step of the finite differences in the filter
SIZE = 18  # states and disturbances
ROLL, HEADING = ANGLES[0], ANGLES[2]


class Steps(NamedTuple):
    """The N steps of a simulation: `now` and `length` [s], (N,); measurement `which` comes after the first `upto`."""

    now: np.ndarray
    length: np.ndarray
    which: np.ndarray
    upto: np.ndarray


class Record(NamedTuple):
    """M measurements: channel, instrument, column, value, stamp [s] and nominal delay [s]; and the wall ahead.

    They are compared in the order in which they were true at the nominal delays, whatever delays are tried: gains
    belong to an order. What is later or earlier than that is read from a state that is wound back or on.
    """

    kind: np.ndarray
    sensor: np.ndarray
    column: np.ndarray
    value: np.ndarray
    stamp: np.ndarray
    late: np.ndarray
    wall: float
    bearing: float


class Drive(NamedTuple):
    """What pushes over each step: wrench of the thrusters (N, 6), sizes of their inputs (N, K), angles of fins (N, F).

    Motion that is known: attitude, velocity and acceleration at the start of each step, (N, 15); which of them, (15,).
    """

    thrust: np.ndarray
    asked: np.ndarray
    fins: np.ndarray
    known: np.ndarray
    knows: np.ndarray


@law
def plan(at, stamps, longest):
    """Steps through measurements that were true at the times `at`, (M,), and inputs that change at `stamps`, (I,).

    longest: step [s].
    """
    count, first = at.size, at.min()
    which = np.argsort(at, kind="mergesort")
    room = count + stamps.size + int((at.max() - first) / longest) + 2
    now, length, upto = np.empty(room), np.empty(room), np.empty(count, np.int64)
    t, i, j = first, 0, np.searchsorted(stamps, first + TOUCH_S)
    for m in range(count):
        until = at[which[m]]
        while t < until - TOUCH_S:
            stop = until
            while j < stamps.size and stamps[j] <= t + TOUCH_S:
                j += 1
            if j < stamps.size and stamps[j] < stop - TOUCH_S:
                stop = stamps[j]
            if stop - t > longest + TOUCH_S:
                stop = t + (stop - t) / math.ceil((stop - t) / longest - 1e-9)
            now[i], length[i] = t, stop - t
            t, i = stop, i + 1
        upto[m] = i
    return now[:i], length[:i], which, upto


@law
def thrusts(now, length, stamps, inputs, tables, reach, p, thrusters, resting):
    """Mean force [N] of K thrusters over each step, and mean size of what they were asked for; shapes (N, K).

    inputs: held from their stamps on, (I, K); tables: steady force over -reach..reach, (K, T); resting: whether the
    forces begin at nothing, else where the first inputs bring them.
    """
    steps, force, size = now.size, np.zeros((now.size, thrusters)), np.zeros((now.size, thrusters))
    samples, points = stamps.size, tables.shape[1]
    made, turned, upto = np.empty(samples), np.empty(samples), np.empty(samples)
    for k in range(thrusters):
        i = HULL + THRUSTER * k
        wire = int(p[i + WIRED]) - 1 if p[i + WIRED] > 0.0 else k
        for j in range(samples):
            n = min(max(inputs[j, wire] - p[i + MISREAD], -p[i + SATURATION]), p[i + SATURATION])
            n = n - min(max(n, -p[i + DEADBAND]), p[i + DEADBAND])
            place = min(max((n / reach[k] + 1.0) * 0.5 * (points - 1), 0.0), points - 1.0)
            left = min(int(place), points - 2)
            steady = tables[k, left] + (place - left) * (tables[k, left + 1] - tables[k, left])
            steady = p[i + GAIN] * p[i + SHARE] * (steady + p[i + SKEWED] * abs(steady))
            made[j], turned[j] = steady * math.exp(-p[i + SAG] * stamps[j]), abs(n)
            upto[j] = stamps[j]
        z, tau, j = 0.0, p[i + LAG] + p[i + SLOWER], 0
        for s in range(steps):
            a, b = now[s] - p[i + DELAY], now[s] + length[s] - p[i + DELAY]
            while j + 1 < samples and upto[j + 1] <= a + TOUCH_S:
                j += 1
            t, goal, spin, q = a, 0.0, 0.0, j
            while t < b - TOUCH_S:
                stop = b
                if q + 1 < samples and upto[q + 1] < b:
                    stop = max(upto[q + 1], t)
                if t >= upto[0] - TOUCH_S:
                    goal += (stop - t) * made[q]
                    spin += (stop - t) * turned[q]
                t = stop
                if q + 1 < samples and upto[q + 1] <= t + TOUCH_S:
                    q += 1
            goal, spin = goal / length[s], spin / length[s]
            if s == 0 and not resting:
                z = goal
            size[s, k] = spin
            if tau > 0.0:
                fade = math.exp(-length[s] / tau)
                force[s, k] = goal + (z - goal) * (tau / length[s]) * (1.0 - fade)
                z = goal + (z - goal) * fade
            else:
                force[s, k] = goal
    return force, size


@law
def held(now, length, stamps, inputs, p, first):
    """Mean angles of fins, (I, F), held from their stamps on, over each step, (N, F); 0 before the first stamp.

    first: slot of their delay, of the first fin; the others follow.
    """
    out = np.zeros((now.size, inputs.shape[1]))
    for f in range(inputs.shape[1]):
        late, j = p[first + FIN * f], -1
        for s in range(now.size):
            t, b = now[s] - late, now[s] + length[s] - late
            while j + 1 < stamps.size and stamps[j + 1] <= t + TOUCH_S:
                j += 1
            q = j
            while t < b - TOUCH_S:
                stop = b if q + 1 >= stamps.size else min(b, max(stamps[q + 1], t))
                if q >= 0:
                    out[s, f] += (stop - t) * inputs[q, f] / length[s]
                t = stop
                if q + 1 < stamps.size and stamps[q + 1] <= t + TOUCH_S:
                    q += 1
    return out


@law
def tied(x, drive, i):
    """Set the motion that is known at the start of step i, in place on x, shape (12,)."""
    for a in range(9):
        if drive.knows[a]:
            x[3 + a] = drive.known[i, a]


@law
def moved(x, d, t, h, memory, drive, i, hull, k, y, push):
    """State x and disturbances d, in place, after step i of h [s]."""
    keep = math.exp(-h / memory)
    mean = (1.0 - keep) * memory / h
    for a in range(6):
        push[a] = d[a] * mean
        d[a] *= keep
    tied(x, drive, i)
    advance(t, x, h, drive.thrust[i], drive.asked[i], drive.fins[i], push, drive.known[i, 9:], hull, k, y)


@law
def wound(x, d, t, late, steps, drive, i, hull, k, y):
    """The state wound back by `late` [s], in place, through the steps before step i; on where that is negative."""
    while late > TOUCH_S and i > 0:
        i -= 1
        h = min(late, steps.length[i])
        advance(t, x, -h, drive.thrust[i], drive.asked[i], drive.fins[i], d, drive.known[i, 9:], hull, k, y)
        t, late = t - h, late - h
    while late < -TOUCH_S and i < steps.length.size:
        h = min(-late, steps.length[i])
        advance(t, x, h, drive.thrust[i], drive.asked[i], drive.fins[i], d, drive.known[i, 9:], hull, k, y)
        t, late, i = t + h, late + h, i + 1


@law
def seen(m, t, x, d, record, steps, drive, i, hull, scratch):
    """Prediction of measurement m in the state x under disturbances d; i is the step that comes next."""
    p, x0, rate, k, y = hull.p, scratch[0], scratch[1], scratch[2:6], scratch[6]
    s = HULL + THRUSTER * hull.counts[0] + FIN * hull.counts[1] + SENSOR * record.sensor[m]
    late = p[s + LATENCY] + p[s + SKEW] * record.stamp[m] - record.late[m]
    here = x
    if abs(late) > TOUCH_S:
        x0[:] = x
        wound(x0, d, t, late, steps, drive, i, hull, k, y)
        here = x0
    if record.kind[m] >= ACCEL:
        j, thrust = min(i, drive.thrust.shape[0] - 1), scratch[7]
        for a in range(6):  # between the means over the steps before and after
            thrust[a] = 0.5 * (drive.thrust[max(i - 1, 0), a] + drive.thrust[j, a])
        rates(t, here, thrust, drive.asked[j], drive.fins[j], d, drive.known[j, 9:], hull, rate)
    return read(
        record.kind[m], record.sensor[m], record.column[m], here, rate, p, hull.counts, record.wall, record.bearing
    )


@law
def parted(e, kind):
    """A difference; that of angles within half a turn."""
    if ROLL <= kind <= HEADING:
        return e - 2.0 * math.pi * round(e / (2.0 * math.pi))
    return e


@law
def simulate(hull, start, steps, record, drive, gain, memory, restart, out, track):
    """Measured less predicted along a run with given gains, into `out`, (M,).

    gain: (M, 18), zeros for pure simulation; start: (12,); track: the states at every measurement, (M, 18), or of
    shape (0, 18); restart: states to begin anew with before some measurements, NaN elsewhere, (M, 18) or (0, 18).
    """
    x, d, k, y = np.zeros(18), np.zeros(6), np.empty((4, 18)), np.empty(18)
    push, scratch, i, t = np.zeros(6), np.zeros((8, 18)), 0, steps.now[0] if steps.now.size else 0.0
    x[:12] = start
    for q in range(steps.which.size):
        m = steps.which[q]
        while i < steps.upto[q]:
            moved(x, d, t, steps.length[i], memory, drive, i, hull, k, y, push)
            t += steps.length[i]
            i += 1
        if restart.shape[0] and not math.isnan(restart[m, 0]):
            x[:12], d[:] = restart[m, :12], restart[m, 12:]
        out[m] = parted(record.value[m] - seen(m, t, x, d, record, steps, drive, i, hull, scratch), record.kind[m])
        for a in range(12):
            x[a] += gain[m, a] * out[m]
        for a in range(6):
            d[a] += gain[m, 12 + a] * out[m]
        if track.shape[0]:
            track[m, :12], track[m, 12:] = x[:12], d


@law
def kalman(hull, start, spread, steps, record, drive, noise_var, sigma, memory, out, variance, gain, explained):
    """Extended Kalman filter along a run: innovations `out`, their variances, gains (M, 18), and H P H' `explained`.

    spread: standard deviations of the start, (12,); noise_var: of each measurement, (M,), inf skips it; sigma [m/s2,
    rad/s2]: stationary deviation of the disturbance of each axis, (6,); memory [s].
    """
    s, P = np.zeros(SIZE), np.zeros((SIZE, SIZE))
    s[:12] = start
    for a in range(12):
        P[a, a] = spread[a] ** 2
    for a in range(6):
        P[12 + a, 12 + a] = sigma[a] ** 2
    F, A, x, d = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE)), np.zeros(18), np.empty(6)
    k, y, push, H, C = np.empty((4, 18)), np.empty(18), np.zeros(6), np.zeros(SIZE), np.zeros(SIZE)
    scratch = np.zeros((8, 18))
    base, wake, later, i, t = np.zeros(SIZE), np.zeros(6), np.zeros(6), 0, steps.now[0] if steps.now.size else 0.0
    for q in range(steps.which.size):
        m = steps.which[q]
        while i < steps.upto[q]:
            h = steps.length[i]
            keep = math.exp(-h / memory)
            mean = (1.0 - keep) * memory / h
            for c in range(-1, 12):
                if 0 <= c < 3 and not pulled(hull):
                    F[c, c] = 1.0
                    continue
                x[:12], x[12:], d[:] = s[:12], wake, s[12:]
                if c >= 0:
                    x[c] += NUDGE
                moved(x, d, t, h, memory, drive, i, hull, k, y, push)
                if c < 0:
                    base[:12], base[12:], later[:] = x[:12], d, x[12:]
                else:
                    for a in range(12):
                        F[a, c] = (x[a] - base[a]) / NUDGE
            for c in range(6):  # an acceleration through the step is a speed that grows on the way through
                F[12 + c, 12 + c] = keep
                for a in range(12):
                    begun = 1.0 if a == 6 + c else 0.0
                    F[a, 12 + c] = 0.5 * h * mean * (F[a, 6 + c] + begun) if sigma[c] > 0.0 else 0.0
            s[:], wake[:] = base, later
            carry(F, P, A)
            for a in range(6):
                if sigma[a] > 0.0:
                    disturb(P, h, sigma[a], memory, 6 + a, 12 + a)
            t += h
            i += 1
        if noise_var[m] == np.inf:
            out[m], variance[m] = np.nan, np.inf
            continue
        x[12:] = wake
        differ(m, t, s, x, d, record, steps, drive, i, hull, scratch, sigma, H)
        e = parted(record.value[m] - seen(m, t, x, d, record, steps, drive, i, hull, scratch), record.kind[m])
        S = 0.0
        for a in range(SIZE):
            C[a] = 0.0
            for b in range(SIZE):
                C[a] += P[a, b] * H[b]
            S += H[a] * C[a]
        explained[m] = S
        S += noise_var[m]
        out[m], variance[m] = e, S
        for a in range(SIZE):
            gain[m, a] = C[a] / S
            s[a] += gain[m, a] * e
            for b in range(SIZE):
                P[a, b] -= gain[m, a] * C[b]


@law
def pulled(hull):
    """Whether any force depends on place."""
    p = hull.p
    return p[TETHER] != 0.0 or p[WATERLINE] != 0.0 or p[SPRING] != 0.0 or p[SPRING + 1] != 0.0 or p[SPRING + 2] != 0.0


@law
def differ(m, t, s, x, d, record, steps, drive, i, hull, scratch, sigma, H):
    """Derivative of the prediction of measurement m with respect to states and disturbances into H, (18,)."""
    x[:12], d[:] = s[:12], s[12:]
    here, accelerated = seen(m, t, x, d, record, steps, drive, i, hull, scratch), record.kind[m] >= ACCEL
    for c in range(SIZE):
        H[c] = 0.0
        if c < 12:
            x[c] += NUDGE
            H[c] = (seen(m, t, x, d, record, steps, drive, i, hull, scratch) - here) / NUDGE
            x[c] = s[c]
        elif accelerated and sigma[c - 12] > 0.0:
            d[c - 12] += NUDGE
            H[c] = (seen(m, t, x, d, record, steps, drive, i, hull, scratch) - here) / NUDGE
            d[c - 12] = s[c]


@law
def carry(F, P, A):
    """In place, P -> F P F'; A is scratch."""
    for i in range(SIZE):
        for k in range(SIZE):
            A[i, k] = 0.0
        for q in range(SIZE):
            f = F[i, q]
            if f != 0.0:
                for k in range(SIZE):
                    A[i, k] += f * P[q, k]
    for i in range(SIZE):
        for k in range(i + 1):
            total = 0.0
            for q in range(SIZE):
                total += A[i, q] * F[k, q]
            P[i, k] = P[k, i] = total


@law
def disturb(P, h, sigma, memory, v, d):
    """Add to P what a disturbance brings to its axis' speed within a step; as the kernels of one axis have it."""
    a = math.exp(-h / memory)
    both = sigma * sigma * memory * (1.0 - a) * (1.0 - a)
    P[d, d] += sigma * sigma * (1.0 - a * a)
    P[v, v] += (sigma * memory) ** 2 * max(2.0 * h / memory - 3.0 + 4.0 * a - a * a, 0.0)
    P[v, d] += both
    P[d, v] = P[v, d]
