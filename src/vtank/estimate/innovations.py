"""Predictions and innovations of the surge model along a run, compiled.

State s = (x, u, z, wake, d): distance made good [m], surge speed [m/s], lagged thrust [m/s2], wake [m/s] and an
Ornstein-Uhlenbeck disturbance d [m/s2] that stands for turbulence. The sonar's error
may have a coloured part of its own. The sonar's range is predicted from the state and
never differentiated. Between stamps the input is held; a range is compared with the state at the time its echo was
made, so that latency and clock skew cost nothing but a shift of the instant.

`predict` runs the model with a given sequence of Kalman gains (zeros: pure simulation, output error);
`kalman` is the extended Kalman filter that yields those gains and the innovations' variances.
Ljung, System Identification (1999), ch. 7: prediction-error methods; Kristensen, Madsen, Jorgensen, Automatica 40
(2004): grey-box models with process noise.
"""

from __future__ import annotations

import math

import numpy as np

from ..compiled import law
from ..effects import clock_skew, command_delay, sonar_latency, sonar_offset, sonar_scale, tachometer_bias
from ..effects import tachometer_spikes as spikes
from ..plant.parameters import indices
from ..plant.surge import STANDOFF, TETHER, WALL_DRAG, WALL_MASS, advance

(LATENCY,), (SKEW,), (DELAY,) = (indices(e.EFFECT) for e in (sonar_latency, clock_skew, command_delay))
(SCALE,), (OFFSET,), (TACHO_BIAS,) = (indices(e.EFFECT) for e in (sonar_scale, sonar_offset, tachometer_bias))
SPIKE_SIZE = indices(spikes.EFFECT)[1]

LONGEST_STEP_S = 0.1  # [s] longest Runge-Kutta step: error below 1e-6 m over 120 s for the Phoenix (tested)
STATES = 5  # of the hull and the disturbance on it; the sonar's coloured error is carried beside them
GAINS = STATES + 1
TOUCH_S = 1e-11  # [s] instants closer than this are one: rounding of stamps, well below the steps of finite differences
NUDGE = 1e-6  # [m, m/s, m/s2] step of the finite differences in the filter's Jacobian


@law
def propeller_speed(reading, lone, p):
    """Input behind the recorded readings, shape (I,): spikes repaired, bias taken off."""
    out = np.empty(reading.size)
    for k in range(reading.size):
        n = spikes.repaired(reading[k], lone[k], p[SPIKE_SIZE])
        out[k] = tachometer_bias.true_speed(n, p[TACHO_BIAS])
    return out


@law
def echo_instant(stamp, kind, p):
    """Time by the input's clock [s] at which a measurement was true; only the sonar can be late or skewed."""
    if kind != 0:
        return stamp
    return sonar_latency.echo_time(clock_skew.echo_time(stamp, p[SKEW]), p[LATENCY])


@law
def schedule(time, kind, p):
    """Instants at which the measurements were true [s], shape (M,), and the order in which to meet them, shape (M,)."""
    instant = np.empty(time.size)
    ascending = True
    for k in range(time.size):
        instant[k] = echo_instant(time[k], kind[k], p)
        ascending = ascending and (k == 0 or instant[k] >= instant[k - 1])
    return instant, np.arange(time.size) if ascending else np.argsort(instant, kind="mergesort")


@law
def output(x, u, kind, p):
    """Noise-free measurement [m or m/s] of channel `kind` in state x, u."""
    if kind == 0:
        return sonar_offset.reading(sonar_scale.reading(p[STANDOFF] - x, p[SCALE]), p[OFFSET])
    return x if kind == 1 else u


@law
def slope(kind, p):
    """Derivative of the measurement with respect to x (range, position) or u (speed)."""
    return -(1.0 + p[SCALE]) if kind == 0 else 1.0


@law
def next_stop(now, until, j, stamps, p):
    """End of the next Runge-Kutta step [s]: the instant wanted, the next change of input, or the longest step."""
    stop = min(until, now + LONGEST_STEP_S)
    if j + 1 < stamps.size:
        stop = min(stop, stamps[j + 1] + p[DELAY])
    return stop


@law
def held_from(now, j, stamps, p):
    """Index of the input sample that is held at time `now`, searched upward from j."""
    acting = command_delay.input_time(now, p[DELAY]) + TOUCH_S
    while j + 1 < stamps.size and stamps[j + 1] <= acting:
        j += 1
    return j


@law
def step(now, stop, s, n, push, correlation_time, p):
    """State after the step from `now` to `stop` [s]: surge equation and decay of the disturbance.

    The input n and a known acceleration `push` [m/s2] are held over the step.
    """
    h = stop - now
    if s[4] == 0.0:
        x, u, z, wake = advance(now, h, s[0], s[1], s[2], s[3], n, push, p)
        return x, u, z, wake, 0.0
    keep = math.exp(-h / correlation_time)
    mean = s[4] * (1.0 - keep) * correlation_time / h + push
    x, u, z, wake = advance(now, h, s[0], s[1], s[2], s[3], n, mean, p)
    return x, u, z, wake, s[4] * keep


@law
def predict(
    p,
    start,
    correlation_time,
    stamps,
    reading,
    lone,
    time,
    value,
    kind,
    gain,
    innovation,
    forcing=None,
    track=None,
    colour_time=1.0,
):
    """Innovations [m or m/s] of the model with given Kalman gains, written into `innovation`, shape (M,).

    start: state (x, u, z, wake) at the first measurement, shape (4,); correlation_time of the disturbance [s];
    reading, lone: input as recorded, and how far its lone readings lie off, shape (I,) each;
    gain: shape (M, 6), zeros for pure simulation; forcing: known acceleration [m/s2] held like the input, shape (I,);
    track: where given, the state at each measurement is written into it, shape (M, 5);
    colour_time: memory of the sonar's coloured error [s].
    """
    n = propeller_speed(reading, lone, p)
    s = (start[0], start[1], start[2], start[3], 0.0)
    instant, order = schedule(time, kind, p)
    now, j, b = instant[order[0]], 0, 0.0
    for k in order:
        until = instant[k]
        if b != 0.0:
            b *= math.exp((now - until) / colour_time)
        while now < until - TOUCH_S:
            j = held_from(now, j, stamps, p)
            stop = next_stop(now, until, j, stamps, p)
            push = 0.0 if forcing is None else forcing[j]
            s = step(now, stop, s, n[j], push, correlation_time, p)
            now = stop
        e = value[k] - output(s[0], s[1], kind[k], p) - (b if kind[k] == 0 else 0.0)
        innovation[k] = e
        b += gain[k, 5] * e
        s = (s[0] + gain[k, 0] * e, s[1] + gain[k, 1] * e, s[2] + gain[k, 2] * e,
             s[3] + gain[k, 3] * e, s[4] + gain[k, 4] * e)  # fmt: skip
        if track is not None:
            for i in range(STATES):
                track[k, i] = s[i]


@law
def same_everywhere(p):
    """Whether the motion does not depend on where the hull is."""
    return p[TETHER] == 0.0 and p[WALL_DRAG] == 0.0 and p[WALL_MASS] == 0.0


@law
def propagate(now, stop, s, n, push, sigma, correlation_time, p, P, C, F, A):
    """State after a step; in place its covariance P -> F P F' + Q and its covariance with the sonar's error C -> F C.

    F and A are scratch, shape (5, 5).
    """
    ahead = step(now, stop, s, n, push, correlation_time, p)
    for i in range(STATES):
        if P[i, i] == 0.0 and C[i] == 0.0:  # known exactly: its column meets only zeros
            F[:, i] = 0.0
            continue
        if i == 0 and same_everywhere(p):
            F[:, i] = 0.0
            F[i, i] = 1.0
            continue
        nudged = (s[0] + NUDGE * (i == 0), s[1] + NUDGE * (i == 1), s[2] + NUDGE * (i == 2),
                  s[3] + NUDGE * (i == 3), s[4] + NUDGE * (i == 4))  # fmt: skip
        b = step(now, stop, nudged, n, push, correlation_time, p)
        F[0, i], F[1, i], F[2, i] = (b[0] - ahead[0]) / NUDGE, (b[1] - ahead[1]) / NUDGE, (b[2] - ahead[2]) / NUDGE
        F[3, i], F[4, i] = (b[3] - ahead[3]) / NUDGE, (b[4] - ahead[4]) / NUDGE
    for i in range(STATES):
        for k in range(STATES):
            total = 0.0
            for m in range(STATES):
                total += F[i, m] * P[m, k]
            A[i, k] = total
    for i in range(STATES):
        for k in range(i + 1):
            total = 0.0
            for m in range(STATES):
                total += A[i, m] * F[k, m]
            P[i, k] = total
            P[k, i] = total
    add_disturbance(P, stop - now, sigma, correlation_time)
    for i in range(STATES):
        A[0, i] = 0.0
        for m in range(STATES):
            A[0, i] += F[i, m] * C[m]
    C[:] = A[0]
    return ahead


@law
def add_disturbance(P, h, sigma, correlation_time):
    """Add to P what the disturbance, known at the start of a step of h [s], brings to x, u and d by its end.

    Exact for u and d but for the hull's own drag within the step; for x in the ratios of a doubly integrated white
    noise, the limit of short steps.
    """
    a = math.exp(-h / correlation_time)
    dd = sigma * sigma * (1.0 - a * a)
    ud = sigma * sigma * correlation_time * (1.0 - a) * (1.0 - a)
    uu = (sigma * correlation_time) ** 2 * max(2.0 * h / correlation_time - 3.0 + 4.0 * a - a * a, 0.0)
    P[0, 0] += 3.0 / 20.0 * h * h * uu
    P[0, 1] += 3.0 / 8.0 * h * uu
    P[0, 4] += h / 3.0 * ud
    P[1, 1] += uu
    P[1, 4] += ud
    P[4, 4] += dd
    P[1, 0], P[4, 0], P[4, 1] = P[0, 1], P[0, 4], P[1, 4]


@law
def kalman(p, start, start_sd, sigma, correlation_time, stamps, reading, lone, time, value, kind, noise_var,
           innovation, variance, gain, forcing=None, colour_sigma=0.0, colour_time=1.0):  # fmt: skip
    """Extended Kalman filter along a run; fills innovations (M,), their variances (M,) and gains (M, 6).

    start, start_sd: mean and standard deviation of the state (x, u, z, wake) at the first measurement, shape (4,);
    sigma [m/s2], correlation_time [s]: stationary deviation and memory of the disturbance;
    noise_var: variance of each measurement [m2 or m2/s2], shape (M,); inf skips a measurement;
    forcing: known acceleration [m/s2] held like the input, shape (I,);
    colour_sigma [m], colour_time [s]: deviation and memory of the sonar's coloured error, beside its white noise.
    """
    n = propeller_speed(reading, lone, p)
    P, F, A = np.zeros((STATES, STATES)), np.zeros((STATES, STATES)), np.zeros((STATES, STATES))
    C, V = np.zeros(STATES), colour_sigma * colour_sigma
    for i in range(4):
        P[i, i] = start_sd[i] ** 2
    P[4, 4] = sigma * sigma
    s = (start[0], start[1], start[2], start[3], 0.0)
    instant, order = schedule(time, kind, p)
    now, j, b = instant[order[0]], 0, 0.0
    for k in order:
        until = instant[k]
        fade = math.exp((now - until) / colour_time)
        while now < until - TOUCH_S:
            j = held_from(now, j, stamps, p)
            stop = next_stop(now, until, j, stamps, p)
            push = 0.0 if forcing is None else forcing[j]
            s = propagate(now, stop, s, n[j], push, sigma, correlation_time, p, P, C, F, A)
            now = stop
        b *= fade
        V = fade * fade * V + (1.0 - fade * fade) * colour_sigma * colour_sigma
        for i in range(STATES):
            C[i] *= fade
        c, h, o = (1 if kind[k] == 2 else 0), slope(kind[k], p), (1.0 if kind[k] == 0 else 0.0)
        e = value[k] - output(s[0], s[1], kind[k], p) - o * b
        S = h * h * P[c, c] + o * (2.0 * h * C[c] + V) + noise_var[k]
        innovation[k], variance[k] = e, S
        weight = 1.0 / S if S < np.inf else 0.0
        for i in range(STATES):
            gain[k, i] = (h * P[i, c] + o * C[i]) * weight
        gain[k, 5] = (h * C[c] + o * V) * weight
        for i in range(STATES):
            for m in range(i + 1):
                P[i, m] -= gain[k, i] * gain[k, m] * S if weight > 0.0 else 0.0
                P[m, i] = P[i, m]
            C[i] -= gain[k, i] * gain[k, 5] * S if weight > 0.0 else 0.0
        V -= gain[k, 5] * gain[k, 5] * S if weight > 0.0 else 0.0
        b += gain[k, 5] * e
        s = (s[0] + gain[k, 0] * e, s[1] + gain[k, 1] * e, s[2] + gain[k, 2] * e,
             s[3] + gain[k, 3] * e, s[4] + gain[k, 4] * e)  # fmt: skip
