"""Flights of blind cases in the MuJoCo tank, with the outside laws on board, and the same plans without noise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from ...experiment import Chunk, Plan, Result, Tachometer, Turbulence, noise
from ...experiment.flight import SPEED
from .cause import Cause
from .outside import OUTSIDE, Array, Memory, OutsideLaw, Sight

DISTORTION = 6  # stream of random numbers for distortions, after those of vtank.pilot.noise


@dataclass
class Passenger:
    """An outside law on board of one run, with its memory."""

    law: OutsideLaw
    size: float
    plan: Plan
    memory: Memory = field(default_factory=dict)
    before: float = 0.0

    def push(self, x: float, u: float, n: float) -> float:
        """Acceleration to be held over the coming tick [m/s2], from place [m], speed [m/s] and propeller speed now."""
        if self.law.push is None:
            return 0.0
        h, truth = self.plan.scenario.period_s, self.plan.truth
        a, self.before = (u - self.before) / h, u
        middle = u + 0.5 * h * a
        sight = Sight(h, x + 0.5 * h * u, middle, a, n, truth.alpha_per_m, truth.beta_m_per_rev2)
        return self.law.push(self.size, sight, self.memory)

    def record(self, n: Array, range_m: Array) -> tuple[Array, Array]:
        """What is written down of the readings."""
        if self.law.distort is None:
            return n, range_m
        random = noise.stream(self.plan.seed, self.plan.run, DISTORTION)
        return self.law.distort(self.size, random, n, range_m)


@dataclass(frozen=True)
class Trip(Plan):
    """A run to be flown with outside causes and a memory of the sonar's noise [s]."""

    causes: tuple[Cause, ...] = ()
    sonar_memory_s: float = 0.0


def passengers(plan: Plan, causes: Sequence[Cause]) -> list[Passenger]:
    """The outside laws among the causes, with fresh memories."""
    return [Passenger(OUTSIDE[c.name], c.size, plan) for c in causes if c.outside]


class TripChunk(Chunk):
    """Trips in one batch of the tank."""

    def __init__(self, trips: Sequence[Trip], nthread: int) -> None:
        super().__init__(trips, nthread)
        self.aboard = [(i, p) for i, trip in enumerate(trips) for p in passengers(trip, trip.causes)]
        for i, trip in enumerate(trips):
            if trip.sonar_memory_s > 0.0:
                keep = math.exp(-trip.scenario.period_s / trip.sonar_memory_s)
                white = self.flight.noise[i, noise.SONAR].copy()
                self.flight.noise[i, noise.SONAR] = noise.ornstein_uhlenbeck(white, keep)

    def _tick(self, k: int) -> None:
        super()._tick(k)
        for i, passenger in self.aboard:
            x, u, n = self.true[i, 0, k], self.true[i, 1, k], self.flight.record[i, SPEED, k]
            self.tank.disturbance_m_s2[i] += passenger.push(float(x), float(u), float(n))

    def _result(self, i: int) -> Result:
        result = super()._result(i)
        n, range_m = result.run.columns["n_rev_s"], result.run.columns["range_m"]
        for passenger in (passenger for j, passenger in self.aboard if j == i):
            n, range_m = passenger.record(n, range_m)
        return replace(result, run=replace(result.run, columns={"n_rev_s": n, "range_m": range_m}))


def quiet(plan: Plan) -> Plan:
    """The plan without noise, drop-outs, rounding and turbulence; multipath and spikes are effects and stay."""
    s = plan.scenario
    sonar = replace(s.sonar, noise_m=0.0, resolution_m=0.0, dropout=0.0)
    tachometer = Tachometer(0.0, s.tachometer.governor_per_s)
    return replace(plan, scenario=replace(s, sonar=sonar, tachometer=tachometer, turbulence=Turbulence()))
