"""Laws that no catalogue has: products of factors, as tables of numbers that one compiled evaluator reads.

A factor takes a signal, does something to it in time (lag, delay, sum, play), and then bends it: a power, a threshold,
a sine. A law pushes the hull, or is an error of a sensor; where it acts in windows only, a gate multiplies it. It
shares neither code nor terms with the diagnosis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compiled import law
from ...experiment import Plan

Array = NDArray[np.float64]
SIGNALS = ("u", "n", "x", "gap", "t", "day", "a", "thrust")
U, N, X, GAP, T, DAY, A, THRUST = map(float, range(len(SIGNALS)))
NOW, LAGGED, BEHIND, DELAYED, SUMMED, PLAY = map(float, range(6))  # what is done to a signal in time
ODD, EVEN, ABOVE, ONE_SIDED, SINE = map(float, range(5))  # how it is bent
IN_TIME = ("{0}", "lag({0}, {1:.3g} s)", "({0} - lag({0}, {1:.3g} s))", "delay({0}, {1:.3g} s)", "sum({0} dt)",
           "play({0}, {1:.3g})")  # fmt: skip
BENT = ("sign(..)|{0}|^{1:.3g}", "|{0}|^{1:.3g}", "step((|{0}| - {1:.3g})/{2:.3g})", "step(({0} - {1:.3g})/{2:.3g})",
        "sin(2 pi {0}/{1:.3g} + {2:.3g})")  # fmt: skip
CHANNELS = {"force": "hydrodynamics", "thrust": "actuator", "range": "sensor", "tachometer": "sensor"}
MORNING = 1.25  # runs of one day begin this many of their durations apart; a choice
MEMORY = 8.0  # [s] longest delay


class Factor(NamedTuple):
    """One factor: signal over scale, what is done to it in time with `time` [s, or -], how it is bent by c and w."""

    signal: float
    scale: float = 1.0
    in_time: float = NOW
    time: float = 1.0
    bent: float = ODD
    c: float = 1.0
    w: float = 1.0

    def __str__(self) -> str:
        """As a formula."""
        s = IN_TIME[int(self.in_time)].format(f"{SIGNALS[int(self.signal)]}/{self.scale:.3g}", self.time)
        return BENT[int(self.bent)].format(s, self.c, self.w)


@dataclass(frozen=True)
class Law:
    """A law of no catalogue.

    Attributes:
        name: of its family, or its own.
        acts: force, thrust, range or tachometer.
        unit: of the product of the factors at size 1 [m/s2, - (of the thrust), m, rev/s].
        largest: largest plausible size [-].
        factors: multiplied with one another.
        windows: of every run, (from, to) [s] in which it acts; everywhere where there are none at all.
        swells: whether it rises and falls within a window as half a sine.
        stalls: whether the sensor repeats its last reading in the windows, in place of an error.
        solved: whether its size is solved for a wanted signal-to-noise ratio.
    """

    name: str
    acts: str
    unit: float = 1.0
    largest: float = 8.0
    factors: tuple[Factor, ...] = ()
    windows: tuple[tuple[tuple[float, float], ...], ...] = ()
    swells: bool = False
    stalls: bool = False
    solved: bool = True

    @property
    def channel(self) -> str:
        """The channel in which it acts."""
        return CHANNELS[self.acts]

    @property
    def channels(self) -> tuple[str, ...]:
        """That, and one in which something would do the very same.

        To a hull a wrong reading of the propeller is a wrong thrust, and so is a push that goes with the propeller.
        """
        driven = self.acts == "force" and any(factor.signal in (N, THRUST) for factor in self.factors)
        return (self.channel, "actuator") if driven or self.acts == "tachometer" else (self.channel,)

    def __str__(self) -> str:
        """As a formula."""
        return "repeats its last reading" if self.stalls else " * ".join([f"{self.unit:.3g}", *map(str, self.factors)])

    def gate(self, run: int, time_s: NDArray[Any]) -> Array:
        """Share with which it acts at the ticks of a run, shape (T,)."""
        if not self.windows:
            return np.ones(time_s.size)
        out = np.zeros(time_s.size)
        for start, end in self.windows[run]:
            inside = (time_s >= start) & (time_s < end)
            out[inside] = np.sin(np.pi * (time_s[inside] - start) / (end - start)) if self.swells else 1.0
        return out


class Aboard(NamedTuple):
    """Laws of one run in one place: sizes (L,), factors (L, F, 7), gates (L, K), memory (L, F, M), and the
    numbers tick [s], stand-off [m], thrust gain [m/rev2], start in the day [s], ticks ahead, speed before [m/s], and
    the most that they add together."""

    sizes: Array
    factors: Array
    gates: Array
    memory: Array
    numbers: Array


def aboard(plan: Plan, laws: Sequence[tuple[Law, float]], length: int, ahead: float, most: float) -> Aboard:
    """Laws with their sizes on board of one run of `length` ticks, with fresh memories; most that they add."""
    s, truth = plan.scenario, plan.truth
    deep = max([len(one.factors) for one, _ in laws], default=0)
    factors = np.full((len(laws), deep, len(Factor(U))), -1.0)
    gates = np.ones((len(laws), length))
    for i, (one, _) in enumerate(laws):
        gates[i] = one.gate(plan.run, s.period_s * np.arange(length))
        for j, factor in enumerate(one.factors):
            factors[i, j] = factor
    numbers = [s.period_s, s.standoff_m, truth.beta_m_per_rev2, MORNING * s.duration_s * plan.run, ahead, 0.0, most]
    memory = np.zeros((len(laws), deep, 2 + round(MEMORY / s.period_s)))
    return Aboard(np.array([one.unit * size for one, size in laws]), factors, gates, memory, np.array(numbers))


@law
def value(row, memory, sight, h):  # type: ignore[no-untyped-def]
    """One factor now; its memory goes on by a tick of h [s]."""
    s, in_time, time = sight[int(row[0])] / row[1], row[2], row[3]
    if in_time == LAGGED or in_time == BEHIND:
        before = memory[0]
        memory[0] += (s - before) * (1.0 - math.exp(-h / time))
        s = before if in_time == LAGGED else s - before
    elif in_time == DELAYED:
        slot = int(memory[0])
        memory[0] = (slot + 1) % max(min(round(time / h), memory.size - 1), 1)
        s, memory[1 + slot] = memory[1 + slot], s
    elif in_time == SUMMED:
        memory[0] += s * h
        s = memory[0]
    elif in_time == PLAY:
        memory[0] = min(max(memory[0], s - time), s + time)
        s = (s - memory[0]) / time
    bent, c, w = row[4], row[5], row[6]
    if bent == ODD:
        return math.copysign(abs(s) ** c, s)
    if bent == EVEN:
        return abs(s) ** c
    if bent == SINE:
        return math.sin(2.0 * math.pi * s / c + w)
    return 0.5 * (1.0 + math.tanh(((abs(s) if bent == ABOVE else s) - c) / w))


@law
def act(laws, k, x, u, n):  # type: ignore[no-untyped-def]
    """What the laws on board add at tick k, at place x [m], speed u [m/s] and propeller speed n [rev/s]."""
    if laws.sizes.size == 0:
        return 0.0
    h, standoff, beta, start, ahead = laws.numbers[:5]
    a = (u - laws.numbers[5]) / h
    laws.numbers[5] = u
    x, u = x + ahead * h * u, u + ahead * h * a
    sight = np.array([u, n, x, standoff - x, k * h, start + k * h, a, beta * n * abs(n)])
    total = 0.0
    for i in range(laws.sizes.size):
        product = laws.sizes[i] * laws.gates[i, k]
        for j in range(laws.factors.shape[1]):
            if laws.factors[i, j, 0] >= 0.0:
                product *= value(laws.factors[i, j], laws.memory[i, j], sight, h)
        total += product
    return min(max(total, -laws.numbers[6]), laws.numbers[6])


@law
def series(laws, x, u, n):  # type: ignore[no-untyped-def]
    """What they add at all ticks, shape (K,), along a motion x, u, n, shape (K,) each."""
    out = np.empty(n.size)
    for k in range(n.size):
        out[k] = act(laws, k, x[k], u[k], n[k])
    return out
