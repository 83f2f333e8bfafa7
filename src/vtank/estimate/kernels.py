"""The compiled kernels of estimation, written once and made for every plant: simulation, filter, linearisation.

What an estimator carries is the plant's state and a disturbance on each axis, an Ornstein-Uhlenbeck acceleration that
stands for turbulence; beside it, a coloured error of the sensor. Measurements are predicted from the state and never
differentiated. Between stamps the input is held; a measurement is compared with the state at the instant it was true,
so that latency and clock skew cost nothing but a shift of the instant.

`simulate` moves W parameter sets, or one set in W neighbouring states, at the price of one (`lanes`; W is its WIDTH).
Ljung, System Identification (1999), ch. 7: prediction-error methods; Kristensen, Madsen, Jorgensen, Automatica 40
(2004): grey-box models with process noise.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload

from ..channels import channels
from ..channels.channel import readers
from ..compiled import bind, term
from ..lanes import WIDTH, lane, load, rows, store
from ..plant.plant import Plant

LONGEST_STEP_S = 0.1  # [s] longest Runge-Kutta step: error below 1e-6 m over 120 s for the Phoenix (tested)
TOUCH_S = 1e-11  # [s] instants closer than this are one: rounding of stamps, well below the steps of finite differences
NUDGE = 1e-6  # [m, m/s, m/s2] step of the finite differences in the filter's Jacobian
PUSH = 1e-5  # [m, m/s, m/s2] the same in a simulation that is linearised


class Record(NamedTuple):
    """What was recorded of a run: I readings of the input with their stamps, and M measurements.

    `lone`: how far each reading of the input that stands alone lies off; `kind`: channel of each measurement;
    `colour`: 1 where its error may have a coloured part, else 0.
    """

    stamp: np.ndarray
    reading: np.ndarray
    lone: np.ndarray
    time: np.ndarray
    value: np.ndarray
    kind: np.ndarray
    colour: np.ndarray


class Steps(NamedTuple):
    """The K steps of a simulation, and the measurements in the order in which they were true.

    `now` and `length` [s] of each step and `held`, the sample of the input, shapes (K,); measurement `which` comes
    after the first `upto` steps, at the instant `at` [s], shapes (M,).
    """

    now: np.ndarray
    length: np.ndarray
    held: np.ndarray
    which: np.ndarray
    upto: np.ndarray
    at: np.ndarray


class Kernels(NamedTuple):
    """The compiled kernels of a plant with its channels: the templates below."""

    plan: Any
    simulate: Any
    kalman: Any
    linearise: Any


@cache
def kernels(plant: Plant) -> Kernels:
    """The kernels of a plant; each is compiled when it is first called (seconds, once) and kept on disk."""
    found = {**plant.laws, **readers(plant, channels(plant)), **_tuples(plant)}
    axes = {"SPEEDS": tuple(a.speed for a in plant.axes), "PLACES": tuple(a.place for a in plant.axes)}
    found |= {"SIZE": plant.size, "STATES": len(plant.states), **axes}
    for helper in (begun, renewed, nudge, differentiate, carry, disturb):
        found[helper.__name__] = bind(helper, f"{plant.name}_{helper.__name__}", found, term)
    made = {t.__name__: bind(t, f"{plant.name}_{t.__name__}", found) for t in (plan, simulate, kalman, linearise)}
    return Kernels(**made)


def _tuples(plant: Plant) -> dict[str, Any]:
    """What kernels do with the tuple of states and disturbances, written out."""
    states, size = len(plant.states), plant.size
    texts = {
        "opened(start)": [f"load(start, {i})" for i in range(states)] + ["0.0 * load(start, 0)"] * (size - states),
        "loaded(x)": [f"load(x, {i})" for i in range(size)],
        "corrected(s, gain, k, e)": [f"s[{i}] + gain[k, {i}] * e" for i in range(size)],
        "first(s)": [f"lane(s[{i}], 0)" for i in range(size)],
        "taken(p)": [f"p[{i}]" for i in range(plant.parameters.null.size)],
    }
    found: dict[str, Any] = {"load": load, "lane": lane}
    for head, items in texts.items():
        exec(f"def {head}:\n    return ({', '.join(items)},)\n", found)
        name = head.partition("(")[0]
        found[name] = term(found[name])
    lines = "\n    ".join(f"store(x, {i}, s[{i}])" for i in range(size))
    found["store"] = store
    exec(f"def written(x, s):\n    {lines}\n", found)
    found["written"] = term(found["written"])
    return found


# --- names in the place of which `bind` puts what they mean for a plant
unbound: Any = None
SIZE = STATES = SPEEDS = PLACES = acts = inputs = instant = read = fades = step = opened = loaded = corrected = (
    first
) = written = taken = unbound


def forced(forcing, j):
    """Known acceleration that is held with sample j of the input; none where there is no forcing."""
    return 0.0 if forcing is None else load(forcing, j)


@overload(forced, strict=False)
def _forced(forcing, j):
    if getattr(forcing, "ndim", 0) == 0:
        return lambda forcing, j: 0.0
    return lambda forcing, j: load(forcing, j)


# --- templates -------------------------------------------------------------------------------------------------------
def plan(record, p):
    """The steps of a run at parameters p, shape (P,), which matter here only where they shift instants."""
    count = record.time.size
    at = np.empty(count)
    ascending = True
    for k in range(count):
        at[k] = instant(record.kind[k], record.time[k], p)
        ascending = ascending and (k == 0 or at[k] >= at[k - 1])
    which = np.arange(count) if ascending else np.argsort(at, kind="mergesort")
    upto = np.empty(count, np.int64)
    room = count + record.stamp.size + int(max(at.max() - at.min(), 0.0) / LONGEST_STEP_S) + 2
    start, length, held = np.empty(room), np.empty(room), np.empty(room, np.int64)
    t, i, j = at[which[0]], 0, 0
    for m in range(count):
        until = at[which[m]]
        while t < until - TOUCH_S:
            acting = acts(t, p)
            while j + 1 < record.stamp.size and record.stamp[j + 1] <= acting + TOUCH_S:
                j += 1
            stop = min(until, t + LONGEST_STEP_S)
            if j + 1 < record.stamp.size:
                stop = min(stop, t + (record.stamp[j + 1] - acting))
            even = i > 0 and abs(stop - t - length[i - 1]) < TOUCH_S
            start[i], length[i], held[i] = t, length[i - 1] if even else stop - t, j
            t, i = stop, i + 1
        upto[m] = i
    return Steps(start[:i], length[:i], held[:i], which, upto, at[which])


def begun(record, forcing, p):
    """What is held over a step, before the first: see `renewed`."""
    return -1, -1.0, inputs(record.reading, record.lone, 0, p), forced(forcing, 0), 0.0, 0.0, fades(1.0, p)


def renewed(i, over, steps, record, forcing, memory, p):
    """What is held over step i, worked out anew where it changes.

    The sample of the input, the step's length, the inputs and the known acceleration, the share of a disturbance that
    the step leaves and its mean within it, and what half a step leaves of the lags.
    """
    held, length, n, push, keep, mean, fade = over
    if steps.held[i] != held:
        held = steps.held[i]
        n, push = inputs(record.reading, record.lone, held, p), forced(forcing, held)
    if steps.length[i] != length:
        length = steps.length[i]
        keep, fade = math.exp(-length / memory), fades(length, p)
        mean = (1.0 - keep) * memory / length
    return held, length, n, push, keep, mean, fade


def simulate(parameters, start, steps, record, value, forcing, gain, memory, out, track):
    """Innovations [unit of the channel] of W models with given Kalman gains, written into `out`, shape (M, W).

    parameters: shape (P, W); start: states at the first measurement, shape (S, W); value: measurements, shape (M,) or,
    each model its own, (M, W); forcing: known acceleration [m/s2] on the first axis, held like the input, shape (I,) or
    (I, W), or None; gain: shape (M, S + A + 1), the last of the coloured error, zeros for pure simulation;
    memory [s]: of the disturbance and of the coloured error; track: where given, shape (M, S + A), the states of the
    first model at each measurement.
    """
    p = taken(rows(parameters))
    s, b, before, i, gap, fade = opened(start), 0.0 * p[0], steps.at[0], 0, 0.0, 1.0
    over = begun(record, forcing, p)
    for m in range(steps.which.size):
        k, at = steps.which[m], steps.at[m]
        while i < steps.upto[m]:
            over = renewed(i, over, steps, record, forcing, memory[0], p)
            s = step(steps.now[i], over[1], s, over[2], over[3], over[4], over[5], over[6], p)
            i += 1
        if at - before != gap:
            gap = at - before
            fade = math.exp(-gap / memory[1])
        b, before = b * fade, at
        e = load(value, k) - read(record.kind[k], at, s, over[2], over[3], p) - record.colour[k] * b
        store(out, k, e)
        b = b + gain[k, SIZE] * e
        s = corrected(s, gain, k, e)
        if track is not None:
            here = first(s)
            for state in range(SIZE):
                track[k, state] = here[state]


def kalman(
    parameters, start, start_sd, steps, record, forcing, noise_var, sigma, memory, colour_sigma, out, variance, gain
):
    """Extended Kalman filter along a run; fills innovations `out` (M,), their variances (M,) and gains (M, S + A + 1).

    parameters: shape (P, W), all columns the same; start, start_sd: mean and standard deviation of the states at the
    first measurement, shape (S,); sigma [m/s2]: stationary deviation of the disturbance on each axis, shape (A,);
    memory [s]: of the disturbance and of the coloured error, whose deviation is colour_sigma [m]; noise_var: variance
    of each measurement, shape (M,); inf skips a measurement.
    """
    p, blocks = taken(rows(parameters)), (SIZE + WIDTH) // WIDTH
    x, y = np.zeros((blocks, SIZE, WIDTH)), np.zeros((1, WIDTH))
    P, F, A = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    s, H, C, V, b = np.zeros(SIZE), np.zeros(SIZE), np.zeros(SIZE), colour_sigma * colour_sigma, 0.0
    for i in range(STATES):
        s[i], P[i, i] = start[i], start_sd[i] ** 2
    for axis in range(SIZE - STATES):
        P[STATES + axis, STATES + axis] = sigma[axis] * sigma[axis]
    over, done, before = begun(record, forcing, p), 0, steps.at[0]
    for m in range(steps.which.size):
        k, at, o = steps.which[m], steps.at[m], record.colour[steps.which[m]]
        while done < steps.upto[m]:
            nudge(s, x)
            over = renewed(done, over, steps, record, forcing, memory[0], p)
            for c in range(blocks):
                ahead = step(steps.now[done], over[1], loaded(x[c]), over[2], over[3], over[4], over[5], over[6], p)
                written(x[c], ahead)
            differentiate(x, s, F)
            carry(F, P, C, A)
            for axis in range(SIZE - STATES):
                disturb(P, over[1], sigma[axis], memory[0], SPEEDS[axis], PLACES[axis], STATES + axis)
            done += 1
        fade = math.exp((before - at) / memory[1])
        before, b, V = at, b * fade, fade * fade * V + (1.0 - fade * fade) * colour_sigma * colour_sigma
        nudge(s, x)
        here = 0.0
        for c in range(blocks):
            store(y, 0, read(record.kind[k], at, loaded(x[c]), over[2], over[3], p))
            here = y[0, 0] if c == 0 else here
            for i in range(max(WIDTH * c, 1), min(WIDTH * (c + 1), SIZE + 1)):
                H[i - 1] = (y[0, i - WIDTH * c] - here) / NUDGE
        e, S, shared = record.value[k] - here - o * b, o * V + noise_var[k], o * V
        for i in range(SIZE):
            C[i] *= fade
            A[0, i] = 0.0
            for q in range(SIZE):
                A[0, i] += P[i, q] * H[q]
            S += H[i] * (A[0, i] + 2.0 * o * C[i])
            shared += H[i] * C[i]
        weight = 1.0 / S if S < np.inf else 0.0
        out[k], variance[k], gain[k, SIZE] = e, S, shared * weight
        b += gain[k, SIZE] * e
        for i in range(SIZE):
            gain[k, i] = (A[0, i] + o * C[i]) * weight
            s[i] += gain[k, i] * e
        if weight > 0.0:
            V -= gain[k, SIZE] * gain[k, SIZE] * S
            for i in range(SIZE):
                C[i] -= gain[k, i] * gain[k, SIZE] * S
                for q in range(i + 1):
                    P[i, q] -= gain[k, i] * gain[k, q] * S
                    P[q, i] = P[i, q]


def linearise(parameters, start, steps, record, error, gap, transition, row):
    """A run along its simulation, in the order in which its measurements were true, for plants of one axis.

    Fills the error of each measurement, shape (M,), the time since the one before [s], shape (M,), the transition in
    that time of place and speed, and by a unit acceleration, shape (M, 2, 3), and the derivative of the measurement
    with respect to place, speed and its coloured error, shape (M, 3). parameters: shape (P, W); start: shape (S, W).
    """
    p = taken(rows(parameters))
    place, speed = PLACES[0], SPEEDS[0]
    x, y, pushes = start.copy(), np.zeros((SIZE, WIDTH)), np.zeros((1, WIDTH))
    pushes[0, 3] = PUSH
    written(y, opened(start))
    over, i, before = begun(record, pushes, p), 0, steps.at[0]
    for m in range(steps.which.size):
        k, at = steps.which[m], steps.at[m]
        for state in range(SIZE):
            y[state, :] = y[state, 0]
        y[place, 1] += PUSH
        y[speed, 2] += PUSH
        s = loaded(y)
        while i < steps.upto[m]:
            over = renewed(i, over, steps, record, None, 1.0, p)
            s = step(steps.now[i], over[1], s, over[2], load(pushes, 0), 1.0, 1.0, over[6], p)
            i += 1
        written(y, s)
        gap[m], before = at - before, at
        for c in range(3):
            transition[m, 0, c] = (y[place, c + 1] - y[place, 0]) / PUSH
            transition[m, 1, c] = (y[speed, c + 1] - y[speed, 0]) / PUSH
        for state in range(SIZE):
            y[state, :] = y[state, 0]
        y[place, 1] += PUSH
        y[speed, 2] += PUSH
        store(x, 0, read(record.kind[k], at, loaded(y), over[2], 0.0, p))
        error[m] = record.value[k] - x[0, 0]
        row[m, 0], row[m, 1], row[m, 2] = (x[0, 1] - x[0, 0]) / PUSH, (x[0, 2] - x[0, 0]) / PUSH, record.colour[k]


# --- the filter's algebra --------------------------------------------------------------------------------------------
def nudge(s, x):
    """Fill x, shape (B, S, W), with states s, shape (S,): in each lane but the first, one is nudged."""
    for i in range(SIZE):
        for c in range(x.shape[0]):
            for q in range(WIDTH):
                x[c, i, q] = s[i]
        x[(i + 1) // WIDTH, i, (i + 1) % WIDTH] += NUDGE


def differentiate(x, s, F):
    """The nudged states one step later, shape (B, S, W): new states into s, shape (S,), and their Jacobian into F."""
    for i in range(SIZE):
        s[i] = x[0, i, 0]
        for q in range(SIZE):
            F[i, q] = (x[(q + 1) // WIDTH, i, (q + 1) % WIDTH] - s[i]) / NUDGE


def carry(F, P, C, A):
    """In place, the covariance P -> F P F' and the covariance with the sensor's error C -> F C; A is scratch."""
    for i in range(SIZE):
        for k in range(SIZE):
            A[i, k] = 0.0
            for q in range(SIZE):
                A[i, k] += F[i, q] * P[q, k]
    for i in range(SIZE):
        for k in range(i + 1):
            P[i, k] = 0.0
            for q in range(SIZE):
                P[i, k] += A[i, q] * F[k, q]
            P[k, i] = P[i, k]
    for i in range(SIZE):
        A[0, i] = 0.0
        for q in range(SIZE):
            A[0, i] += F[i, q] * C[q]
    C[:] = A[0]


def disturb(P, h, sigma, memory, v, x, d):
    """Add to P what the disturbance d, known at the start of a step of h [s], brings to speed v and place x by its end.

    Exact for v and d but for the hull's own drag within the step; for x, where it is a state, in the ratios of a doubly
    integrated white noise, the limit of short steps.
    """
    a = math.exp(-h / memory)
    ud = sigma * sigma * memory * (1.0 - a) * (1.0 - a)
    uu = (sigma * memory) ** 2 * max(2.0 * h / memory - 3.0 + 4.0 * a - a * a, 0.0)
    P[d, d] += sigma * sigma * (1.0 - a * a)
    P[v, v] += uu
    P[v, d] += ud
    P[d, v] = P[v, d]
    if x >= 0:
        P[x, x] += 3.0 / 20.0 * h * h * uu
        P[x, v] += 3.0 / 8.0 * h * uu
        P[x, d] += h / 3.0 * ud
        P[v, x], P[d, x] = P[x, v], P[x, d]
