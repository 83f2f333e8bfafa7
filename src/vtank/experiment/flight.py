"""The arrays in which the pilots of N runs work: settings, noise, commands, memory and records.

One row per run. The compiled laws of this package take a Flight, the number of a run and the number of a tick.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..effects import clock_skew, sonar_multipath, tachometer_spikes
from ..plant.parameters import indices
from ..waves import orbit
from . import noise as streams
from .clearance import vehicle_of
from .excitation import fade_in
from .plan import Plan
from .sonar_filter import steady_state

Array = NDArray[np.float64]

(SKEW,), (MULTIPATH, _), (SPIKES, _) = (indices(e.EFFECT) for e in (clock_skew, sonar_multipath, tachometer_spikes))

# What the laws need of a plan besides the effects' parameters, which stand in the vector p: name -> where it is found
SETTING: dict[str, Callable[[Plan], float]] = {
    "period_s": lambda plan: plan.scenario.period_s,
    "closed_loop": lambda plan: plan.scenario.excitation.loop != "speed",
    "standoff_m": lambda plan: plan.scenario.standoff_m,
    "n_limit_rev_s": lambda plan: plan.n_limit_rev_s,
    "position_gain": lambda plan: plan.scenario.control.position_per_s2,
    "speed_gain": lambda plan: plan.scenario.control.speed_per_s,
    "thrust_m_per_rev2": lambda plan: plan.thrust_m_per_rev2,
    "blunt_rev_s": lambda plan: plan.scenario.control.blunt_rev_s,
    "governor_per_s": lambda plan: plan.scenario.tachometer.governor_per_s,
    "filter_q": lambda plan: plan.scenario.filter.q_m2_per_s5,
    "filter_r": lambda plan: plan.scenario.filter.r_m2,
    "ping_ticks": lambda plan: round(1.0 / (plan.scenario.sonar.rate_hz * plan.scenario.period_s)),
    "resolution_m": lambda plan: plan.scenario.sonar.resolution_m,
    "dropout": lambda plan: plan.scenario.sonar.dropout,
    "max_range_m": lambda plan: plan.scenario.sonar.max_range_m,
}

# Rows of Flight.command, .history and .record
COMMAND, COMMAND_RATE = range(2)
RANGE, RANGE_RATE = range(2)
READING, SPEED, SPEED_READING = range(3)


class Flight(NamedTuple):
    """Arrays of N runs over K ticks.

    Attributes:
        setting: shape (N,), records of the numbers in SETTING.
        p: parameter vectors, shape (N, SIZE).
        noise: shape (N, STREAMS, K).
        command: shape (N, 2, K): range to the wall [m] or propeller speed [rev/s], and its rate.
        history: shape (N, 2, K): true range at the tick [m] and its rate [m/s].
        record: shape (N, 3, K): range read [m], propeller speed and propeller speed read [rev/s].
        estimate, covariance: of the on-board filter, shapes (N, 3) and (N, 3, 3).
        trim: what the motor's governor adds to the wanted speed, shape (N,) [rev/s].
        water: velocity of the water at the ticks, ahead and up, shape (N, 2, K + 1) [m/s], linear in between; shape
            (N, 2, 0) where no run has waves.
    """

    setting: NDArray[np.void]
    p: Array
    noise: Array
    command: Array
    history: Array
    record: Array
    estimate: Array
    covariance: Array
    trim: Array
    water: Array


def ticks(plan: Plan) -> int:
    """Ticks to simulate: those of the record, and more where the sonar's clock runs ahead."""
    beyond = max(float(plan.p[SKEW]), 0.0) * plan.scenario.duration_s / plan.scenario.period_s
    return plan.scenario.samples + (int(np.ceil(beyond)) + 1 if beyond > 0.0 else 0)


def prepare(plans: Sequence[Plan]) -> Flight:
    """A Flight ready for its first tick; K is that of the longest plan."""
    count, length = len(plans), max(map(ticks, plans))
    flight = Flight(
        setting=np.zeros(count, np.dtype([(name, "f8") for name in SETTING])),
        p=np.array([plan.p for plan in plans]),
        noise=np.empty((count, streams.STREAMS, length)),
        command=np.empty((count, 2, length)),
        history=np.empty((count, 2, length)),
        record=np.full((count, 3, length), np.nan),
        estimate=np.full((count, 3), np.nan),
        covariance=np.empty((count, 3, 3)),
        trim=np.zeros(count),
        water=np.zeros((count, 2, length + 1 if any(moves(plan) for plan in plans) else 0)),
    )
    for i, plan in enumerate(plans):
        flight.setting[i] = tuple(found(plan) for found in SETTING.values())
        flight.noise[i] = _noise(plan, length)
        flight.command[i] = _command(plan, length)
        s = plan.scenario
        flight.covariance[i] = steady_state(s.period_s, s.filter.q_m2_per_s5, s.filter.r_m2)[1]
        if moves(plan):
            flight.water[i] = _water(plan, length + 1)
    return flight


def moves(plan: Plan) -> bool:
    """Whether there are waves."""
    return plan.scenario.waves.kind != "none"


def orders(plan: Plan, length: int) -> Array:
    """Orders to the excited axis, other than surge, at the ticks, shape (length, 3) as those of `hold`."""
    s = plan.scenario
    value, rate = s.excitation.command(_times(plan, length), s.duration_s)
    if s.excitation.loop == "force":
        return np.transpose([0.0 * value, 0.0 * value, value])
    return np.transpose([value, rate, np.full(length, np.nan)])


def _times(plan: Plan, length: int) -> Array:
    return np.arange(length, dtype=np.float64) * plan.scenario.period_s


def _noise(plan: Plan, length: int) -> Array:
    s, of = plan.scenario, (plan.seed, plan.run)
    rows = np.empty((streams.STREAMS, length))
    rows[streams.SONAR] = streams.normal(*of, streams.SONAR, s.sonar.noise_m, length)
    rows[streams.DROPOUT] = streams.uniform(*of, streams.DROPOUT, s.sonar.dropout, length)
    rows[streams.MULTIPATH] = streams.uniform(*of, streams.MULTIPATH, plan.p[MULTIPATH], length)
    rows[streams.TACHOMETER] = streams.normal(*of, streams.TACHOMETER, s.tachometer.noise_rev_s, length)
    rows[streams.SPIKE] = streams.uniform(*of, streams.SPIKE, plan.p[SPIKES], length)
    level, memory = s.turbulence.acceleration_m_s2, s.turbulence.time_s
    rows[streams.TURBULENCE] = streams.turbulence(*of, level, memory, s.period_s, length)
    return rows


def _command(plan: Plan, length: int) -> Array:
    s = plan.scenario
    if s.excitation.axis != "surge":
        return np.array([np.full(length, s.standoff_m), np.zeros(length)])
    value, rate = s.excitation.command(_times(plan, length), s.duration_s)
    return np.array([s.standoff_m - value, -rate] if s.excitation.loop == "position" else [value, rate])


def _water(plan: Plan, length: int) -> Array:
    s = plan.scenario
    to_wall = s.standoff_m + vehicle_of(s.vehicle).sonar_x_m
    sea = orbit(s.waves, s.depth_m, to_wall, streams.stream(plan.seed, plan.run, streams.WAVES))
    fade, _ = fade_in(_times(plan, length), s.waves.ramp_s)
    return np.asarray((fade[:, None] * sea.ticks(s.period_s, length)).T)
