"""Flights of blind cases in the MuJoCo tank, with laws and noise of their own on board, and plans without noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...experiment import Chunk, Plan, Result, Tachometer, Turbulence
from ...experiment import noise as streams
from ...experiment.flight import SPEED
from .cause import Cause
from .laws import Aboard, Array, aboard, act, series
from .noise import JITTER, LOST, SHAPE, Noise

Columns = tuple[Array, Array]  # propeller speed [rev/s] and range [m] on record


@dataclass(frozen=True)
class Trip(Plan):
    """A run to be flown with causes that no catalogue has, and a family of sensor noise."""

    causes: tuple[Cause, ...] = ()
    noise: Noise = Noise("white")


def pushes(plan: Plan, causes: Sequence[Cause], length: int) -> Aboard:
    """The laws that push the hull, evaluated half a tick ahead: holding them over a tick costs second order only.

    Together they push no harder than the propellers can.
    """
    laws = [(c.law, c.size) for c in causes if c.law is not None and c.law.acts in ("force", "thrust")]
    most = plan.truth.beta_m_per_rev2 * plan.truth.n_limit_rev_s**2
    return aboard(plan, laws, length, 0.5, most)


def recorded(plan: Plan, causes: Sequence[Cause], motion: tuple[Array, Array, Array], columns: Columns) -> Columns:
    """What is written down of the readings; motion: true place [m], speed [m/s], propeller speed [rev/s]."""
    out, time_s = [], plan.scenario.period_s * np.arange(columns[0].size)
    for acts, column in zip(("tachometer", "range"), columns, strict=True):
        laws = [(c.law, c.size) for c in causes if c.law is not None and c.law.acts == acts]
        errors = [(law, size) for law, size in laws if not law.stalls]
        column = column + series(aboard(plan, errors, column.size, 0.0, np.inf), *motion) if errors else column
        for law, _ in laws:
            if law.stalls:
                column = stalled(column, law.gate(plan.run, time_s) > 0.0)
        out.append(column)
    return out[0], out[1]


def stalled(column: Array, still: NDArray[np.bool_]) -> Array:
    """Readings that repeat the last one before, where `still`, shape (T,) of bool; lost ones stay lost."""
    last = np.maximum.accumulate(np.where(still | np.isnan(column), 0, np.arange(column.size)))
    return np.where(still & ~np.isnan(column), column[last], column)


class TripChunk(Chunk):
    """Trips in one batch of the tank."""

    def __init__(self, trips: Sequence[Trip], nthread: int) -> None:
        super().__init__(trips, nthread)
        self.trips, (_, _, length) = trips, self.flight.noise.shape
        self.aboard = [(i, a) for i, trip in enumerate(trips) if (a := pushes(trip, trip.causes, length)).sizes.size]
        for i, trip in enumerate(trips):
            random, s = streams.stream(trip.seed, trip.run, SHAPE), trip.scenario
            rows = self.flight.noise[i]
            rows[streams.SONAR] = s.sonar.noise_m * trip.noise.unit(random, length, s.period_s)
            rows[streams.DROPOUT, trip.noise.blocks(random, length, s.period_s)] = LOST

    def _tick(self, k: int) -> None:
        for i, trip in enumerate(self.trips):
            if trip.noise.by_range or trip.noise.by_speed:
                away, speed = -self.tank.qpos[i, 0], self.tank.qvel[i, 0]
                self.flight.noise[i, streams.SONAR, k] *= trip.noise.growth(away, speed)
        super()._tick(k)
        for i, laws in self.aboard:
            self.tank.disturbance_m_s2[i] += act(laws, k, *self.true[i, :2, k], self.flight.record[i, SPEED, k])

    def _result(self, i: int) -> Result:
        result, trip = super()._result(i), self.trips[i]
        n, range_m = result.run.columns["n_rev_s"], result.run.columns["range_m"]
        motion = result.true["position_m"], result.true["surge_m_s"], result.true["n_rev_s"]
        n, range_m = recorded(trip, trip.causes, motion, (n, range_m))
        time_s = result.run.time_s
        if trip.noise.jitter:
            late = streams.stream(trip.seed, trip.run, JITTER).uniform(-1.0, 1.0, time_s.size)
            time_s = time_s + trip.noise.jitter * trip.scenario.period_s * late
            time_s[0] = 0.0
        return replace(result, run=replace(result.run, time_s=time_s, columns={"n_rev_s": n, "range_m": range_m}))


def quiet(plan: Plan) -> Plan:
    """The plan without noise, drop-outs, rounding and turbulence; multipath and spikes are effects and stay."""
    s = plan.scenario
    sonar = replace(s.sonar, noise_m=0.0, resolution_m=0.0, dropout=0.0, max_range_m=np.inf)
    tachometer = Tachometer(0.0, s.tachometer.governor_per_s)
    return replace(plan, scenario=replace(s, sonar=sonar, tachometer=tachometer, turbulence=Turbulence()))
