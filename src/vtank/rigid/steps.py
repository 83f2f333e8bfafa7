"""The steps of a simulation of a whole vehicle, and what pushes over each of them.

Thruster forces follow from the inputs alone, but for what speed takes off, and are worked out beforehand as means over
the steps, exact for delays and first-order lags of held inputs; of rotors that lag by Simpson's rule. Inputs may go
straight from one to the next instead, or along a curve.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..compiled import law, term
from ..effects.tachometer_spikes import repaired
from .layout import (
    DEADBAND,
    DELAY,
    FIN,
    GAIN,
    HULL,
    LAG,
    LATE,
    LOST,
    MISREAD,
    PATH,
    ROTOR,
    SAG,
    SATURATION,
    SKEWED,
    SLOWER,
    SPIKED,
    SWEPT,
    THRUSTER,
    WIRED,
)  # fmt: skip

FIRST: Any = np.int64(0)  # step, as a number: all that a loop hands a literal 0 is compiled twice
TOUCH_S = 1e-10  # [s] instants closer than this are one
PARTS = 8  # of the time between two inputs, over each of which what goes between them is held; a choice


class Steps(NamedTuple):
    """The N steps of a simulation: `now` and `length` [s], (N,); measurement `which` comes after the first `upto`."""

    now: np.ndarray
    length: np.ndarray
    which: np.ndarray
    upto: np.ndarray


class Drive(NamedTuple):
    """What pushes over each step: wrench of the thrusters (N, 6), sizes of their inputs (N, K), angles of fins (N, F).

    swing, turn: half of what the wrench, (N, 6), and the angles, (N, F), change by on the way through the step.
    Motion that is known: attitude, velocity and acceleration at the start of each step, (N, 15); which of them, (15,).
    """

    thrust: np.ndarray
    swing: np.ndarray
    asked: np.ndarray
    fins: np.ndarray
    turn: np.ndarray
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


@term
def alone(before: float, reading: float, after: float) -> float:
    """By how much a reading stands out from its neighbours; 0 where it lies between them."""
    return reading - 0.5 * (before + after) if (reading - before) * (reading - after) > 0.0 else 0.0


def spike(inputs: np.ndarray) -> float:
    """Size of the largest readings that stand alone, of inputs in their order, shape (I,)."""
    lone = np.zeros(inputs.size)
    for j in range(1, inputs.size - 1):
        lone[j] = abs(alone(inputs[j - 1], inputs[j], inputs[j + 1]))
    return float(np.median(lone[lone >= 0.5 * lone.max()])) if lone.any() else 0.0


@term
def steady(n, t, table, reach, p, i):
    """Force [N] of the thruster at slot i of p under an input n that it gets at time t [s]; table: of -reach..reach."""
    place = min(max((n / reach + 1.0) * 0.5 * (table.size - 1), 0.0), table.size - 1.0)
    left = min(int(place), table.size - 2)
    force = table[left] + (place - left) * (table[left + 1] - table[left])
    return p[i + GAIN] * (1.0 - p[i + LOST]) * (force - p[i + SKEWED] * min(force, 0.0)) * math.exp(-p[i + SAG] * t)


@term
def turning(stamps, values, j):
    """Slope at the j-th of values that a curve goes through without going beyond any of them.

    Fritsch, Butland, SIAM J. Sci. Stat. Comput. 5 (1984).
    """
    if j == 0 or j + 1 >= stamps.size:
        return 0.0
    before, after = stamps[j] - stamps[j - 1], stamps[j + 1] - stamps[j]
    came, goes = (values[j] - values[j - 1]) / before, (values[j + 1] - values[j]) / after
    if came * goes <= 0.0:
        return 0.0
    return 3.0 * (before + after) / ((2.0 * after + before) / came + (after + 2.0 * before) / goes)


@term
def bow(a, b, begins, ends):
    """Mean from a to b, of 0 to 1, of a cubic that is 0 at both and has these slopes there."""
    a3, b3 = a * a * a, b * b * b
    first = 0.5 * (b * b - a * a) - 2.0 / 3.0 * (b3 - a3) + 0.25 * (b * b3 - a * a3)
    second = (b3 - a3) / 3.0 - 0.25 * (b * b3 - a * a3)
    return (begins * first - ends * second) / (b - a)


@term
def along(stamps, values, j, t, stop, path):
    """Mean from t to stop of values of which the j-th is held from its stamp on, or goes to the next.

    path: 0 where it is held, 1 where it goes straight, 2 where along a curve; between these by shares.
    """
    if path == 0.0 or j + 1 >= stamps.size:
        return values[j]
    length, rise = stamps[j + 1] - stamps[j], values[j + 1] - values[j]
    a, b = (t - stamps[j]) / length, (stop - stamps[j]) / length
    if path <= 1.0:
        return values[j] + path * 0.5 * (a + b) * rise
    begins = turning(stamps, values, j) * length - rise
    ends = turning(stamps, values, j + 1) * length - rise
    return values[j] + 0.5 * (a + b) * rise + (path - 1.0) * bow(a, b, begins, ends)


@term
def lagging(stamps, values, until, tau, path, z):
    """What lags values by tau [s], at a time; it is z at the first of them. path: as of `along`, in PARTS."""
    parts = PARTS if path > 0.0 else 1
    for j in range(stamps.size):
        if stamps[j] >= until - TOUCH_S:
            break
        length = ((min(stamps[j + 1], until) if j + 1 < stamps.size else until) - stamps[j]) / parts
        for part in range(parts):
            t = stamps[j] + part * length
            goal = along(stamps, values, j, t, t + length, path)
            z = goal + (z - goal) * math.exp(-length / tau)
    return z


@law
def smeared(length, rates, tau):
    """Rates over steps of such lengths [s], (N, A), as their means when they lag by tau [s], in place."""
    for c in range(rates.shape[1] if tau > 0.0 else 0):
        z = 0.0
        for i in range(length.size):
            goal, fade = rates[i, c], math.exp(-length[i] / tau)
            rates[i, c] = goal + (z - goal) * (tau / length[i]) * (1.0 - fade)
            z = goal + (z - goal) * fade


@law
def thrust_of(k, now, length, stamps, inputs, table, reach, p, resting):
    """Mean force [N] of thruster k over each step, half its change, mean size of what it was asked for; each (N,).

    inputs: of all thrusters, held from their stamps on, (I, K); table: steady force over -reach..reach, (T,); resting:
    whether the force is nothing at the first input, else where this brings it, which has been there before. A share of
    the lag may be that of a rotor, whose input lags and not its force.
    """
    steps, (force, swing, size) = now.size, np.zeros((3, now.size))
    samples, i = stamps.size, HULL + THRUSTER * k
    made, told = np.empty(samples), np.empty(samples)
    wire = int(p[i + WIRED]) - 1 if p[i + WIRED] > 0.0 else k
    for j in range(samples):
        n = inputs[j, wire]
        if p[i + SPIKED] > 0.0 and 0 < j < samples - 1:
            lone = alone(inputs[j - 1, wire], n, inputs[j + 1, wire])
            n = repaired(n, lone, p[i + SPIKED])
        n = min(max(n - p[i + MISREAD], -p[i + SATURATION]), p[i + SATURATION])
        n = n - min(max(n, -p[i + DEADBAND]), p[i + DEADBAND])
        made[j] = steady(n, stamps[j], table, reach, p, i)
        told[j] = n
    tau, rotor, path, j = p[i + LAG] + p[i + SLOWER], p[i + ROTOR], p[i + PATH], 0
    z, turns = (0.0, 0.0) if resting else (made[0], told[0])
    if tau > 0.0 and steps > 0:
        z = lagging(stamps, made, now[0] - p[i + DELAY], tau, path, z)
        turns = lagging(stamps, told, now[0] - p[i + DELAY], tau, path, turns)
    for s in range(steps):
        a, b = now[s] - p[i + DELAY], now[s] + length[s] - p[i + DELAY]
        while j + 1 < samples and stamps[j + 1] <= a + TOUCH_S:
            j += 1
        t, goal, spin, wanted, q = a, 0.0, 0.0, 0.0, j
        while t < b - TOUCH_S:
            stop = b
            if t < stamps[0] - TOUCH_S:
                stop = min(b, stamps[0])
                if not resting:
                    goal += (stop - t) * made[0]
                    spin += (stop - t) * abs(told[0])
                    wanted += (stop - t) * told[0]
            elif q + 1 < samples and stamps[q + 1] < b:
                stop = max(stamps[q + 1], t)
            if t >= stamps[0] - TOUCH_S:
                n, f = told[q], made[q]
                if path > 0.0:
                    n = along(stamps, told, q, t, stop, path)
                    f = steady(n, 0.5 * (t + stop), table, reach, p, i)
                goal += (stop - t) * f
                spin += (stop - t) * abs(n)
                wanted += (stop - t) * n
            t = stop
            if q + 1 < samples and stamps[q + 1] <= t + TOUCH_S:
                q += 1
        goal, spin = goal / length[s], spin / length[s]
        size[s] = spin
        if tau > 0.0:
            fade = math.exp(-length[s] / tau)
            force[s] = goal + (z - goal) * (tau / length[s]) * (1.0 - fade)
            swing[s] = 0.5 * (goal - z) * (1.0 - fade)
            z = goal + (z - goal) * fade
            if rotor != 0.0:
                wanted = wanted / length[s]
                amid, ends = wanted + (turns - wanted) * math.sqrt(fade), wanted + (turns - wanted) * fade
                first = steady(turns, now[s], table, reach, p, i)
                middle = steady(amid, now[s] + 0.5 * length[s], table, reach, p, i)
                last = steady(ends, now[s] + length[s], table, reach, p, i)
                force[s] += rotor * ((first + 4.0 * middle + last) / 6.0 - force[s])  # Simpson's rule
                swing[s] += rotor * (0.5 * (last - first) - swing[s])
                turns = ends
        else:
            force[s] = goal
    return force, swing, size


@law
def held(now, length, stamps, inputs, p, first):
    """Mean angles of fins, (I, F), over each step, and half of what they turn there, (N, F).

    On their path from stamp to stamp, of `along`; the first ones before it. first: slot of the first fin.
    """
    out, turn = np.zeros((2, now.size, inputs.shape[1]))
    for f in range(inputs.shape[1]):
        late, path, j = p[first + FIN * f + LATE], p[first + FIN * f + SWEPT], 0
        for s in range(now.size):
            t, b = now[s] - late, now[s] + length[s] - late
            while j + 1 < stamps.size and stamps[j + 1] <= t + TOUCH_S:
                j += 1
            q = j
            while t < b - TOUCH_S:
                stop = b if q + 1 >= stamps.size else min(b, max(stamps[q + 1], t))
                way = path if t >= stamps[q] - TOUCH_S else 0.0
                out[s, f] += (stop - t) * along(stamps, inputs[:, f], q, t, stop, way) / length[s]
                if way != 0.0 and q + 1 < stamps.size:
                    whole = min(way, 1.0) * (inputs[q + 1, f] - inputs[q, f])
                    turn[s, f] += 0.5 * whole * (stop - t) / (stamps[q + 1] - stamps[q])
                t = stop
                if q + 1 < stamps.size and stamps[q + 1] <= t + TOUCH_S:
                    q += 1
    return out, turn
