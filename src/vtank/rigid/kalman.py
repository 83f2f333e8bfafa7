"""The Kalman filter of a whole vehicle, and the linearisation that it leaves behind along its path.

The motion between measurements is linearised once for a path; filters at other noise, and what small changes of a law
do, are linear algebra along it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..compiled import law, lean, term
from .kernels import SIZE, fade, folded, lasting, lateness, moved, seen, stirred, told
from .layout import SPRING, TETHER, WALL_DRAG, WALL_MASS, WATERLINE
from .motion import rates
from .readings import ACCEL, ROLL, ROLL_RATE, SURGE
from .steps import FIRST, TOUCH_S

NUDGE = 1e-6  # [SI] step of the finite differences
JUMP = 1e3  # [SI] derivative that no step could follow, from which a difference went across a jump; a choice


class Way(NamedTuple):
    """A filter's path along a run and its linearisation.

    states: at the starts of the N steps and at the end, (N + 1, 18); before: before each measurement, (M, 18);
    F: transition of the motion over each step, (N, 12, 12); H: derivative of each prediction with respect to the motion
    and the acceleration of each axis, (M, 18).
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


@term
def pulled(hull):
    """Whether any force depends on place."""
    p = hull.p
    if p[WALL_DRAG] != 0.0 or p[WALL_MASS] != 0.0:
        return True
    return p[TETHER] != 0.0 or p[WATERLINE] != 0.0 or p[SPRING] != 0.0 or p[SPRING + 1] != 0.0 or p[SPRING + 2] != 0.0


@lean
def gentle(by, t, x, i, c, drive, hull, D, scratch):
    """Column c of D by a difference to one side; whether it went across no jump. scratch: as `slope` leaves it."""
    still, rate, base, steepest, before = scratch[1, :6], scratch[2], scratch[3], 0.0, x[c]
    x[c] += by
    rates(t, x, drive.thrust[i], drive.asked[i], drive.fins[i], still, drive.known[i, 9:], hull, rate)
    x[c] = before
    for a in range(12):
        D[a, c] = (rate[a] - base[a]) / by
        steepest = max(steepest, abs(D[a, c]))
    return steepest < JUMP


@lean
def slope(t, x, i, drive, hull, D, scratch):
    """Derivative of the rates with respect to the motion, at x, (18,), and time t in step i, into D, (12, 12).

    Beside a jump, as of the drag of a fin at its stall, that on this side of it.
    """
    still, base = scratch[1, :6], scratch[3]
    for a in range(6):
        still[a] = 0.0
    rates(t, x, drive.thrust[i], drive.asked[i], drive.fins[i], still, drive.known[i, 9:], hull, base)
    placed = pulled(hull)
    for c in range(12):
        for a in range(12):
            D[a, c] = 0.0
        free = not drive.knows[c - 3] if c >= 3 else placed
        if free and not gentle(NUDGE, t, x, i, c, drive, hull, D, scratch):
            gentle(-NUDGE, t, x, i, c, drive, hull, D, scratch)


@lean
def transition(t, x, y, h, i, drive, hull, F, D, scratch):
    """Derivative of the motion after step i of h [s] with respect to that before it, x to y, both (18,), into F.

    The Taylor series of the exponential of D, the `slope` amid the step, to the order of the Runge-Kutta steps.
    """
    amid, B, G = scratch[0], scratch[4:16, :12], scratch[16:28, :12]
    for a in range(18):
        amid[a] = 0.5 * (x[a] + y[a])
    slope(t + 0.5 * h, amid, i, drive, hull, D, scratch)
    for a in range(12):
        for c in range(12):
            B[a, c] = h * D[a, c]
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


@term
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


@term
def swept(D, x, stir, i):
    """How a speed of the water north, east, and down accelerates a hull whose rates have the slope D at x, into row i.

    As the opposite speed of the hull does, in water that stays as it is while the hull turns.
    """
    p, q, r = x[9], x[10], x[11]
    sr, cr, sp, cp, sy, cy = (
        math.sin(x[3]), math.cos(x[3]), math.sin(x[4]), math.cos(x[4]), math.sin(x[5]), math.cos(x[5]),
    )  # fmt: skip
    for a in range(6):
        u, v, w = -D[6 + a, 6], -D[6 + a, 7], -D[6 + a, 8]
        if a == 0:
            v, w = v + r, w - q
        elif a == 1:
            u, w = u - r, w + p
        elif a == 2:
            u, v = u + q, v - p
        stir[i, a, 0] = cy * cp * u + (cy * sp * sr - sy * cr) * v + (cy * sp * cr + sy * sr) * w
        stir[i, a, 1] = sy * cp * u + (sy * sp * sr + cy * cr) * v + (sy * sp * cr - cy * sr) * w
        stir[i, a, 2] = -sp * u + cp * sr * v + cp * cr * w


@term
def through(H, stir, i, c):
    """Derivative of a prediction with respect to the disturbance of axis c in step i; H: of `Way`, (18,)."""
    if c >= 3 or stir.shape[0] == 0:
        return H[12 + c]
    by = 0.0
    for a in range(6):
        by += H[12 + a] * stir[i, a, c]
    return by


@term
def pushing(F, h, stir, i, a, c):
    """By how much the motion's a-th number changes in step i of h [s] by a disturbance of axis c that stays."""
    if c >= 3 or stir.shape[0] == 0:
        return 0.5 * h * (F[a, 6 + c] + (1.0 if a == 6 + c else 0.0))
    by = 0.0
    for b in range(6):
        by += 0.5 * h * (F[a, 6 + b] + (1.0 if a == 6 + b else 0.0)) * stir[i, b, c]
    return by


@lean
def differ(m, t, s, x, d, stir, record, steps, drive, i, hull, D, scratch, H):
    """Prediction of measurement m, and its derivative with respect to states and accelerations into H, (18,).

    D: slope of the rates near here, by which an accelerometer sees what moves them, and what is read late what was.
    """
    for a in range(12):
        x[a] = s[a]
    for a in range(6):
        d[a] = s[12 + a]
    stirred(d, stir, max(i - 1, 0))
    here = seen(m, t, x, d, record, steps, drive, i, hull, scratch)
    for c in range(SIZE):
        H[c] = 0.0
    late, shaken, rate = lateness(m, record, hull), record.kind[m] >= ACCEL, scratch[1]
    wound_back, (first, last) = abs(late) > TOUCH_S, reach(m, record, hull)
    then = scratch[0] if wound_back else x  # the motion of which it tells
    there, faster = scratch[9], scratch[10]
    for a in range(12):
        there[a] = then[a]
    for c in range(first, last):
        there[c] += NUDGE
        for a in range(12 if wound_back else 0):  # exp(-late D), to second order
            twice = 0.0
            for b in range(12):
                twice += D[a, b] * D[b, c]
            there[a] -= NUDGE * late * (D[a, c] - 0.5 * late * twice)
        for a in range(6, 12 if shaken else 6):
            faster[a] = rate[a] if wound_back else rate[a] + NUDGE * D[a, c]
            for b in range(12 if wound_back else 0):
                faster[a] += D[a, b] * (there[b] - then[b])
        H[c] = (told(m, there, faster, record, hull) - here) / NUDGE
        for a in range(12 if wound_back else 0):
            there[a] = then[a]
        there[c] = then[c]
    for c in range(6 if shaken else 0):
        rate[6 + c] += NUDGE
        there[6 + c] -= NUDGE * late if wound_back else 0.0
        H[12 + c] = (told(m, there, rate, record, hull) - here) / NUDGE
        rate[6 + c] -= NUDGE
        there[6 + c] = then[6 + c]
    return here


@lean
def carry(F, h, sigma, memory, slow, slow_s, stir, jolts, i, T, P, A):
    """In place, the covariance P, (18 + S, 18 + S), after step i of h [s] whose transition of the motion is F.

    A disturbance holds on with its memory, (6,), and is a speed that grows on the way through the step; slow errors, of
    deviations slow and memories slow_s, hold on with theirs; jolts, (N, 6), add to the variance of each speed at a rate
    of their own. T, (18, 12), and A: scratch.
    """
    size = P.shape[0]
    for a in range(12):
        for c in range(12):
            T[c, a] = F[a, c]
    for c in range(6):
        _, mean = lasting(h, memory[c])
        for a in range(12):
            T[12 + c, a] = mean * pushing(F, h, stir, i, a, c) if sigma[c] > 0.0 else 0.0
    for j in range(size):  # A = P T, of which the disturbances' columns, and those of slow errors, but fade
        for k in range(12):
            A[j, k] = 0.0
        for q in range(SIZE):
            f = P[j, q]
            if f != 0.0:
                for k in range(12):
                    A[j, k] += f * T[q, k]
    for k in range(12, SIZE):
        keep, _ = lasting(h, memory[k - 12])
        for j in range(size):
            A[j, k] = keep * P[j, k]
    for k in range(SIZE, size):
        left = math.exp(-h / slow_s[k - SIZE])
        for j in range(size):
            A[j, k] = left * P[j, k]
    for j in range(12):  # P = T' A, the upper half; what rounding makes of the lower would grow for itself
        for k in range(j, size):
            P[j, k] = 0.0
        for q in range(SIZE):
            f = T[q, j]
            if f != 0.0:
                for k in range(j, size):
                    P[j, k] += f * A[q, k]
    for j in range(12, SIZE):
        keep, _ = lasting(h, memory[j - 12])
        for k in range(j, size):
            P[j, k] = keep * A[j, k]
    for j in range(SIZE, size):
        left = math.exp(-h / slow_s[j - SIZE])
        for k in range(j, size):
            P[j, k] = left * A[j, k]
        P[j, j] += slow[j - SIZE] ** 2 * (1.0 - left * left)
    for c in range(6):
        keep, _ = lasting(h, memory[c])
        both = memory[c] * (1.0 - keep) * (1.0 - keep)
        gust = memory[c] * memory[c] * max(2.0 * h / memory[c] - 3.0 + 4.0 * keep - keep * keep, 0.0)
        s2 = sigma[c] * sigma[c]
        P[6 + c, 6 + c] += h * jolts[i, c]
        P[12 + c, 12 + c] += s2 * (1.0 - keep * keep)
        if c >= 3 or stir.shape[0] == 0:
            P[6 + c, 6 + c] += s2 * gust
            P[6 + c, 12 + c] += s2 * both
        else:
            for a in range(6):
                P[6 + a, 12 + c] += stir[i, a, c] * s2 * both
                for b in range(a, 6):
                    P[6 + a, 6 + b] += stir[i, a, c] * stir[i, b, c] * s2 * gust
    for j in range(size):
        for k in range(j):
            P[j, k] = P[k, j]


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
    root = math.sqrt(explained + noise_var)
    for a in range(size):
        C[a] /= root
    for a in range(size):  # symmetric, to the last bit
        for b in range(size):
            P[a, b] -= C[a] * C[b]


class Scratch(NamedTuple):
    """What a filter works with: motion and disturbances s, (18,), and slow errors b, (S,), that it takes for true.

    x, y: motion with wakes before and after a step, (18,); d: disturbances, wake: (6,); P: covariance, T, A, C: of
    `carry` and `weigh`; D: slope of the rates, (12, 12); k, z, push, more: of `moved`, `transition` and `differ`.
    """

    s: np.ndarray
    b: np.ndarray
    x: np.ndarray
    y: np.ndarray
    d: np.ndarray
    wake: np.ndarray
    P: np.ndarray
    T: np.ndarray
    A: np.ndarray
    C: np.ndarray
    D: np.ndarray
    k: np.ndarray
    z: np.ndarray
    push: np.ndarray
    more: np.ndarray


@law
def kalman(hull, soft, start, spread, steps, record, drive, noise_var, sigma, slow, jolts, gains, way, told):
    """Extended Kalman filter along a run.

    soft: the hull by which steps are linearised.
    spread: standard deviations of the start, (12,); noise_var: of each measurement, (M,); sigma [m/s2, rad/s2] and
    slow: stationary deviations of the disturbance of each axis, (6,), and of the slow errors, (S,); jolts: growth of
    the variance of each speed over each step, (N, 6) [SI per s]; gains, way, told: to fill.
    With spread of shape (0,) the gains are given, and nothing but innovations and way is made.
    """
    given = spread.size == 0
    P = begun(np.zeros(12) if given else spread, sigma, slow)
    w = Scratch(
        s=np.zeros(SIZE), b=np.zeros(slow.size), x=np.zeros(18), y=np.zeros(18), d=np.zeros(6), wake=np.zeros(6),
        P=P, T=np.zeros((SIZE, 12)), A=np.zeros_like(P), C=np.zeros(P.shape[0]), D=np.zeros((12, 12)),
        k=np.empty((5, 18)), z=np.empty(18), push=np.zeros(6), more=np.zeros((28, 18)),
    )  # fmt: skip
    w.s[:12] = start
    along(hull, soft, steps, record, drive, noise_var, sigma, slow, jolts, gains, way, told, given, w)


@lean
def along(hull, soft, steps, record, drive, noise_var, sigma, slow, jolts, gains, way, told, given, w):
    """As `kalman`, from the motion and the covariance in the scratch w on."""
    s, x, y, b, memory, i = w.s, w.x, w.y, w.b, gains.memory, FIRST
    t = steps.now[0] if steps.now.size else 0.0
    for a in range(12):
        x[a] = s[a]
    stirs = gains.stir.shape[0] > 0 and not given
    if steps.now.size:
        slope(t, x, i, drive, soft, w.D, w.more)
        if stirs:
            swept(w.D, x, gains.stir, i)
    for q in range(steps.which.size):
        m = steps.which[q]
        while i < steps.upto[q]:
            h = steps.length[i]
            for a in range(12):
                x[a] = y[a] = s[a]
            for a in range(6):
                x[12 + a] = y[12 + a] = w.wake[a]
                w.d[a] = s[12 + a]
            for a in range(SIZE):
                way.states[i, a] = s[a]
            if stirs:
                swept(w.D, x, gains.stir, i)
            moved(y, w.d, t, h, memory, gains.stir, drive, i, hull, w.k, w.z, w.push)
            transition(t, x, y, h, i, drive, soft, way.F[i], w.D, w.more)
            if not given:
                carry(way.F[i], h, sigma, memory, slow, gains.slow_s, gains.stir, jolts, i, w.T, w.P, w.A)
            fade(b, h, gains.slow_s)
            for a in range(12):
                s[a] = y[a]
            for a in range(6):
                s[12 + a], w.wake[a] = w.d[a], y[12 + a]
            t += h
            i += 1
        for a in range(SIZE):
            way.before[m, a] = s[a]
        for a in range(6):
            x[12 + a] = w.wake[a]
        here = differ(m, t, s, x, w.d, gains.stir, record, steps, drive, i, hull, w.D, w.more, way.H[m])
        own = gains.slow[record.column[m]]
        told.slow[m] = b[own] if own >= 0 else 0.0
        e = folded(record.value[m] - here, m, record, hull) - told.slow[m]
        told.innovation[m] = e
        if not given:
            for a in range(12):
                w.z[a] = way.H[m, a]
            for a in range(6):
                w.z[12 + a] = through(way.H[m], gains.stir, max(i - 1, 0), a)
            weigh(w.P, w.z, own, noise_var[m], w.C, gains.of[m], m, told)
        for a in range(SIZE):
            s[a] += gains.of[m, a] * e
        for a in range(b.size):
            b[a] += gains.of[m, SIZE + a] * e
    for n in range(i, way.states.shape[0]):
        for a in range(SIZE):
            way.states[n, a] = s[a]
