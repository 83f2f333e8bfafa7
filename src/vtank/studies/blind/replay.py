"""A run played again on the surge axis, without noise: from any state, at any parameters, with a given propeller speed.

Sensors and actuators are the pilot's own, so that every effect acts as it did in the tank.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...compiled import law
from ...effects import clock_skew, sonar_multipath, tachometer_bias, tachometer_spikes
from ...experiment import Plan, drive, stamp, tick
from ...experiment import noise as streams
from ...experiment.flight import RANGE, RANGE_RATE, READING, SPEED, SPEED_READING, Flight, prepare
from ...experiment.noise import TURBULENCE
from ...plant import STANDOFF, indices
from .cause import Cause
from .fly import pushes, quiet, recorded
from .laws import Aboard, act

Array = NDArray[np.float64]
(SKEW,), (BIAS,), (MULTIPATH, _) = (indices(e.EFFECT) for e in (clock_skew, tachometer_bias, sonar_multipath))
SPIKE_RATE, SPIKE_SIZE = indices(tachometer_spikes.EFFECT)
STEP_S = 0.05  # [s] longest step of the surge model


@law
def play(f: Flight, i: int, samples: int, steps: int, start: Array, motion: Array, laws: Aboard) -> None:
    """Run i from `start` (x, u, z, wake), laws on board; fills motion (2, K) with place [m] and speed [m/s]."""
    state = start.copy()
    for k in range(f.history.shape[2]):
        motion[0, k] = state[0]
        motion[1, k] = state[1]
        f.history[i, RANGE, k] = f.p[i, STANDOFF] - state[0]
        f.history[i, RANGE_RATE, k] = -state[1]
        tick(f, i, k)
        f.noise[i, TURBULENCE, k] = act(laws, k, state[0], state[1], f.record[i, SPEED, k])
        drive(f, i, k, steps, state)
    stamp(f, i, samples)


class Replay:
    """A run that can be played again and again.

    Attributes:
        samples: ticks in the record.
        spikes: how far the tachometer's spikes throw its readings off, shape (T,) [rev/s].
        motion: place [m] and speed [m/s] at the ticks of the last replay, shape (2, K).
    """

    def __init__(self, plan: Plan, spikes: Array | None = None) -> None:
        """spikes: where they are not the plan's own, shape (T,) [rev/s]."""
        self.plan, self.samples = quiet(plan), plan.scenario.samples
        self.spikes = spikes_of(plan) if spikes is None else spikes
        longest = self.plan.p.copy()
        longest[SKEW] = 0.02  # room for a sonar clock that runs ahead by up to 2 %
        self.flight = prepare([replace(self.plan, p=longest)])
        self.motion = np.empty((2, self.flight.history.shape[2]))
        self.steps = int(np.ceil(plan.scenario.period_s / STEP_S - 1e-9))

    def model(self, p: Array, n_read: Array, start: Array) -> Array:
        """Ranges, shape (T,) [m], that parameters p foretell from the recorded propeller speed n_read (T,) [rev/s].

        start: state (x, u, z, wake). A model that has spikes is told which readings they hit, and takes its own size of
        them off: how well they are found is not what a held-out run is to show. Its ranges have no multipath.
        """
        n = tachometer_bias.true_input(n_read, 0.0, p[BIAS])
        if p[SPIKE_RATE] > 0.0:
            n = repair(n, self.spikes, p[SPIKE_SIZE])
        clean = p.copy()
        clean[[BIAS, SPIKE_RATE, MULTIPATH]] = 0.0
        self._prepare(clean, n)
        self._play(start, ())
        return self.flight.record[0, READING, : self.samples].copy()

    def _prepare(self, p: Array, n: Array) -> None:
        f = self.flight
        f.p[0] = p
        f.setting["closed_loop"], f.setting["governor_per_s"], f.setting["n_limit_rev_s"] = False, 0.0, np.inf
        f.command[0, :, : n.size], f.command[0, :, n.size :] = n, n[-1]
        f.trim[0] = 0.0

    def pushed(self, causes: tuple[Cause, ...], n: Array | None = None) -> tuple[Array, Array, Array]:
        """Readings and true propeller speed (n_read, range, n) of the truth itself, from rest, outside laws on board.

        n: true propeller speed where it is given [rev/s]; by default what the pilot makes of the scenario.
        """
        if n is not None:
            self._prepare(self.plan.p, n)
        else:
            self.flight = prepare([self.plan])
            self.motion = np.empty((2, self.flight.history.shape[2]))
        self._play(np.zeros(4), causes)
        n_read, range_m, true = (self.flight.record[0, row, : self.samples] for row in (SPEED_READING, READING, SPEED))
        x, u = self.motion[:, : self.samples]
        return *recorded(self.plan, causes, (x, u, true), (n_read.copy(), range_m.copy())), true.copy()

    def _play(self, start: Array, causes: tuple[Cause, ...]) -> None:
        laws = pushes(self.plan, causes, self.motion.shape[1])
        play(self.flight, 0, self.samples, self.steps, start, self.motion, laws)


def repair(n: Array, spikes: Array, size: float) -> Array:
    """Propeller speed [rev/s] with a spike of `size` taken off where `spikes`, shape (T,) [rev/s], say so."""
    fixed = n.copy()
    for k in np.flatnonzero(spikes):
        fixed[k] = tachometer_spikes.repaired(n[k], spikes[k], size)
    return fixed


def spikes_of(plan: Plan) -> Array:
    """How far the spikes of a plan throw the tachometer's readings off, shape (T,) [rev/s]."""
    p = plan.p[SPIKE_RATE]
    if p == 0.0:
        return np.zeros(plan.scenario.samples)
    drawn = streams.uniform(plan.seed, plan.run, streams.SPIKE, p, plan.scenario.samples)
    return np.array([tachometer_spikes.reading(0.0, p, plan.p[SPIKE_SIZE], u) for u in drawn])
