"""The Kalman filter of a whole vehicle, and the linearisation that it leaves behind along its path.

The motion between measurements is linearised once for a path; filters at other noise, and what small changes of a law
do, are linear algebra along it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..compiled import law, lean
from .kernels import SIZE, fade, folded, lasting, lateness, moved, seen, told
from .layout import SPRING, TETHER, WALL_DRAG, WALL_MASS, WATERLINE
from .motion import rates
from .readings import ACCEL, ROLL, ROLL_RATE, SURGE
from .steps import TOUCH_S

NUDGE = 1e-6  # [SI] step of the finite differences


class Way(NamedTuple):
    """A filter's path along a run and its linearisation.

    states: at the starts of the N steps and at the end, (N + 1, 18); before: before each measurement, (M, 18);
    F: transition of the motion over each step, (N, 12, 12); H: derivative of each prediction, (M, 18), but for its slow
    error.
    """

    states: np.ndarray
    before: np.ndarray
    F: np.ndarray
    H: np.ndarray


class Told(NamedTuple):
    """Of M innovations, (M,): themselves, their variances, the part of these that the state explains.

    slow: what the slow error of each was taken for; apart: the variance if that were known.
    """

    innovation: np.ndarray
    variance: np.ndarray
    explained: np.ndarray
    slow: np.ndarray
    apart: np.ndarray


@lean
def pulled(hull):
    """Whether any force depends on place."""
    p = hull.p
    if p[WALL_DRAG] != 0.0 or p[WALL_MASS] != 0.0:
        return True
    return p[TETHER] != 0.0 or p[WATERLINE] != 0.0 or p[SPRING] != 0.0 or p[SPRING + 1] != 0.0 or p[SPRING + 2] != 0.0


@lean
def transition(t, x, y, h, i, drive, hull, F, scratch):
    """Derivative of the motion after step i of h [s] with respect to that before it, x to y, both (18,), into F.

    The Taylor series of the exponential of the rates' derivative amid the step, to the order of the Runge-Kutta steps.
    """
    amid, still, rate, base = scratch[0], scratch[1, :6], scratch[2], scratch[3]
    B, G = scratch[4:16, :12], scratch[16:28, :12]
    for a in range(18):
        amid[a] = 0.5 * (x[a] + y[a])
    for a in range(6):
        still[a] = 0.0
    now, thrust, asked, fins, known = t + 0.5 * h, drive.thrust[i], drive.asked[i], drive.fins[i], drive.known[i]
    rates(now, amid, thrust, asked, fins, still, known[9:], hull, base)
    placed = pulled(hull)
    for c in range(12):
        free = c >= 3 and not drive.knows[c - 3] if c >= 3 else placed
        if free:
            before = amid[c]
            amid[c] += NUDGE
            rates(now, amid, thrust, asked, fins, still, known[9:], hull, rate)
            amid[c] = before
        for a in range(12):
            B[a, c] = h * (rate[a] - base[a]) / NUDGE if free else 0.0
    for a in range(12):
        for c in range(12):
            F[a, c] = 0.25 * B[a, c]
        F[a, a] += 1.0
    for order in range(3, 0, -1):  # F <- 1 + B F / order
        for a in range(12):
            for c in range(12):
                G[a, c] = 0.0
            G[a, a] = 1.0
            for b in range(12):
                f = B[a, b] / order
                if f != 0.0:
                    for c in range(12):
                        G[a, c] += f * F[b, c]
        for a in range(12):
            for c in range(12):
                F[a, c] = G[a, c]
    for c in range(3, 12):
        if drive.knows[c - 3]:  # what is known does not follow from what was
            for a in range(12):
                F[a, c] = 0.0


@lean
def reach(m, record, hull):
    """Range of the motion that a measurement may depend on; of one that is wound back, all of it."""
    kind = record.kind[m]
    if abs(lateness(m, record, hull)) > TOUCH_S:
        return 0, 12
    if kind >= ACCEL:
        return 0 if pulled(hull) else 3, 12
    if kind < ROLL:
        return 0, 6
    return (3, 6) if kind < SURGE else (3, 12) if kind < ROLL_RATE else (9, 12)


@lean
def differ(m, t, s, x, d, record, steps, drive, i, hull, scratch, H):
    """Prediction of measurement m, and its derivative with respect to states and disturbances into H, (18,)."""
    for a in range(12):
        x[a] = s[a]
    for a in range(6):
        d[a] = s[12 + a]
    here = seen(m, t, x, d, record, steps, drive, i, hull, scratch)
    for c in range(SIZE):
        H[c] = 0.0
    if record.kind[m] >= ACCEL:
        late, rate = abs(lateness(m, record, hull)) > TOUCH_S, scratch[1]
        for c in range(6):
            if late:
                d[c] += NUDGE
                there = seen(m, t, x, d, record, steps, drive, i, hull, scratch)
                d[c] = s[12 + c]
            else:  # a disturbance is an acceleration itself
                rate[6 + c] += NUDGE
                there = told(m, x, rate, record, hull)
                rate[6 + c] -= NUDGE
            H[12 + c] = (there - here) / NUDGE
    first, last = reach(m, record, hull)
    for c in range(first, last):
        x[c] += NUDGE
        H[c] = (seen(m, t, x, d, record, steps, drive, i, hull, scratch) - here) / NUDGE
        x[c] = s[c]
    return here


@lean
def carry(F, h, sigma, memory, slow, slow_s, T, P, A):
    """In place, the covariance P, (18 + S, 18 + S), after a step of h [s] whose transition of the motion is F.

    A disturbance holds on with its memory, (6,), and is a speed that grows on the way through the step; slow errors, of
    deviations slow and memories slow_s, hold on with theirs. T, (18, 12), and A: scratch.
    """
    size = P.shape[0]
    for a in range(12):
        for c in range(12):
            T[c, a] = F[a, c]
    for c in range(6):
        _, mean = lasting(h, memory[c])
        for a in range(12):
            T[12 + c, a] = 0.5 * h * mean * (F[a, 6 + c] + (1.0 if a == 6 + c else 0.0)) if sigma[c] > 0.0 else 0.0
    for i in range(size):  # A = P T, of which the disturbances' columns, and those of slow errors, but fade
        for k in range(12):
            A[i, k] = 0.0
        for q in range(SIZE):
            f = P[i, q]
            if f != 0.0:
                for k in range(12):
                    A[i, k] += f * T[q, k]
    for k in range(12, SIZE):
        keep, _ = lasting(h, memory[k - 12])
        for i in range(size):
            A[i, k] = keep * P[i, k]
    for k in range(SIZE, size):
        left = math.exp(-h / slow_s[k - SIZE])
        for i in range(size):
            A[i, k] = left * P[i, k]
    for i in range(12):  # P = T' A, the upper half; what rounding makes of the lower would grow for itself
        for k in range(i, size):
            P[i, k] = 0.0
        for q in range(SIZE):
            f = T[q, i]
            if f != 0.0:
                for k in range(i, size):
                    P[i, k] += f * A[q, k]
    for i in range(12, SIZE):
        keep, _ = lasting(h, memory[i - 12])
        for k in range(i, size):
            P[i, k] = keep * A[i, k]
    for i in range(SIZE, size):
        left = math.exp(-h / slow_s[i - SIZE])
        for k in range(i, size):
            P[i, k] = left * A[i, k]
        P[i, i] += slow[i - SIZE] ** 2 * (1.0 - left * left)
    for a in range(6):
        keep, _ = lasting(h, memory[a])
        both = memory[a] * (1.0 - keep) * (1.0 - keep)
        gust = memory[a] * memory[a] * max(2.0 * h / memory[a] - 3.0 + 4.0 * keep - keep * keep, 0.0)
        s2 = sigma[a] * sigma[a]
        P[12 + a, 12 + a] += s2 * (1.0 - keep * keep)
        P[6 + a, 6 + a] += s2 * gust
        P[6 + a, 12 + a] += s2 * both
    for i in range(size):
        for k in range(i):
            P[i, k] = P[k, i]


@law
def begun(spread, sigma, slow):
    """Covariance of the start, (18 + S, 18 + S)."""
    P = np.zeros((SIZE + slow.size, SIZE + slow.size))
    for a in range(12):
        P[a, a] = spread[a] ** 2
    for a in range(6):
        P[12 + a, 12 + a] = sigma[a] ** 2
    for a in range(slow.size):
        P[SIZE + a, SIZE + a] = slow[a] ** 2
    return P


@lean
def weigh(P, H, own, noise_var, C, gain, m, told):
    """Variances of measurement m into `told`; its gain, (18 + S,), and P after it, in place.

    own: which slow error it has, -1 for none.
    """
    explained, size = 0.0, P.shape[0]
    for a in range(size):
        C[a] = P[SIZE + own, a] if own >= 0 else 0.0
    for b in range(SIZE):
        f = H[b]
        if f != 0.0:
            for a in range(size):
                C[a] += f * P[b, a]
    for a in range(SIZE):
        explained += H[a] * C[a]
    told.apart[m] = explained + noise_var
    if own >= 0:
        explained += C[SIZE + own]
        told.apart[m] += P[SIZE + own, SIZE + own] - C[SIZE + own]
    told.explained[m], told.variance[m] = explained, explained + noise_var
    for a in range(size):
        gain[a] = C[a] / (explained + noise_var)
        for b in range(a + 1):
            P[a, b] -= gain[a] * C[b]
            P[b, a] = P[a, b]


@law
def kalman(hull, soft, start, spread, steps, record, drive, noise_var, sigma, slow, gains, way, told):
    """Extended Kalman filter along a run.

    soft: the hull by which steps are linearised.
    spread: standard deviations of the start, (12,); noise_var: of each measurement, (M,); sigma [m/s2, rad/s2] and
    slow: stationary deviations of the disturbance of each axis, (6,), and of the slow errors, (S,); gains, way, told:
    to fill. With spread of shape (0,) the gains are given, and nothing but innovations and way is made.
    """
    s, x, d, y = np.zeros(SIZE), np.zeros(18), np.zeros(6), np.zeros(18)
    given, P = spread.size == 0, begun(np.zeros(12) if spread.size == 0 else spread, sigma, slow)
    T, A, C, b = np.zeros((SIZE, 12)), np.zeros_like(P), np.zeros(P.shape[0]), np.zeros(slow.size)
    gain, memory = gains.of, gains.memory
    k, z, push, scratch = np.empty((5, 18)), np.empty(18), np.zeros(6), np.zeros((28, 18))
    wake, i, t = np.zeros(6), 0, steps.now[0] if steps.now.size else 0.0
    s[:12] = start
    for q in range(steps.which.size):
        m = steps.which[q]
        while i < steps.upto[q]:
            way.states[i] = s
            x[:12], x[12:], d[:] = s[:12], wake, s[12:]
            y[:] = x
            moved(y, d, t, steps.length[i], memory, drive, i, hull, k, z, push)
            transition(t, x, y, steps.length[i], i, drive, soft, way.F[i], scratch)
            if not given:
                carry(way.F[i], steps.length[i], sigma, memory, slow, gains.slow_s, T, P, A)
            fade(b, steps.length[i], gains.slow_s)
            s[:12], s[12:], wake[:] = y[:12], d, y[12:]
            t += steps.length[i]
            i += 1
        way.before[m] = s
        x[12:] = wake
        here = differ(m, t, s, x, d, record, steps, drive, i, hull, scratch, way.H[m])
        own = gains.slow[record.column[m]]
        told.slow[m] = b[own] if own >= 0 else 0.0
        e = folded(record.value[m] - here, m, record, hull) - told.slow[m]
        told.innovation[m] = e
        if not given:
            weigh(P, way.H[m], own, noise_var[m], C, gain[m], m, told)
        for a in range(SIZE):
            s[a] += gain[m, a] * e
        for a in range(b.size):
            b[a] += gain[m, SIZE + a] * e
    way.states[i:] = s
