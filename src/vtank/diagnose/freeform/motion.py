"""The motion of a fitted model, over which the free-form model draws its functions.

All of it comes from a pure simulation: functions of the filtered state would carry the sonar's noise and explain it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...compiled import law
from ...estimate.problem import Filtered, Problem
from ...plant.surge import TAU, thrust_target
from ..evidence import Fitted
from ..holdout import held

RINGS_RAD_S = np.geomspace(0.4, 8.0, 18)  # [rad/s] a fifth apart: what rings with DAMPING resonates as broadly; choices
DAMPING = 0.1  # [-] over critical, of what rings; a guess between a pendulum's and sloshing water's
MEMORIES_S = (1.0, 4.0, 15.0)  # [s] over which speed and thrust are remembered; a choice, three to the decade


def simulated(problem: Problem, theta: np.ndarray) -> list[Filtered]:
    """Pure simulation at theta."""
    return [replace(f, innovation=held(f.innovation)) for f in problem.simulate(theta)]


def simulated_tracks(problem: Problem, theta: np.ndarray) -> list[np.ndarray]:
    """States at the measurements in the same simulation, shapes (M, 5)."""
    return [held(track) for track in problem.track(theta, simulated(problem, theta))]


@dataclass(frozen=True)
class Motion:
    """Motion of one run on the instants `t` [s]: place x [m], speed u [m/s], thrust z [m/s2], input n; shapes (I,).

    lag_s: of the thrust behind the input; past: which step before an instant a rate is that of, and the input, which
    no later one has touched: 1, or 2 where readings were left out since the last; 0 for a rate about the instant. A
    controller answers to the noise of a reading at once: what goes with a reading's error must not know that answer,
    nor that to the reading just before it, of which its own error is a part where it lasts.
    """

    t: np.ndarray
    x: np.ndarray
    u: np.ndarray
    z: np.ndarray
    n: np.ndarray
    lag_s: float
    past: int = 0

    @cached_property
    def variables(self) -> dict[str, np.ndarray]:
        """What a missing term may depend on, by name."""
        a = rate(self.t, self.u, self.past)
        found = {"speed": self.u, "input": self.n, "place": self.x, "time": self.t - self.t[0], "acceleration": a}
        for memory in MEMORIES_S:
            found[f"speed of the last {memory:g} s"] = faded(self.t, self.u, memory)
            found[f"thrust of the last {memory:g} s"] = faded(self.t, self.z, memory)
        return found

    @cached_property
    def terms(self) -> dict[str, np.ndarray]:
        """The simulator's own terms, up to a factor: how the force changes with each own parameter.

        A longer lag holds back what the thrust changes by, which itself comes through the lag.
        """
        late = rate(self.t, self.z)
        late = faded(self.t, late, self.lag_s) if self.lag_s > 0.0 else late
        return {"drag": self.u * np.abs(self.u), "thrust": self.z, "lag": late}


def motions(fit: Fitted) -> list[tuple[Motion, Motion]]:
    """Per run, the motion at the input's stamps and at the measurements."""
    problem = fit.problem
    out = []
    for k, track in enumerate(simulated_tracks(problem, fit.optimum.theta)):
        run, p = problem.runs[k], problem.model(fit.optimum.theta, k)[0]
        lag_s = float(p[TAU])
        states = [track[:, i] for i in (0, 1, 2)]
        fed = [np.interp(run.input_time_s, run.time_s, state) for state in states]
        past = 2 if run.thinned else 1
        answered = np.searchsorted(run.input_time_s, _before(run.time_s, past - 1), "left")
        before = run.input[np.maximum(answered - 1, 0)]
        if np.ptp(fed[2]) == 0.0:  # no lag: the thrust is what the input makes
            pairs = (run.input_time_s, run.input), (run.time_s, before)
            fed[2], states[2] = (thrust_along(*pair, p) for pair in pairs)
        (x, u, z), (xm, um, zm) = fed, states
        out.append(
            (
                Motion(run.input_time_s, x, u, z, run.input, lag_s),
                Motion(run.time_s, xm, um, zm, before, lag_s, past),
            )
        )
    return out


def thrust_along(t: np.ndarray, n: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Thrust at instants t for inputs n, shapes (I,), as it is behind its lag [m/s2]."""
    target = np.array([thrust_target(*at, p) for at in zip(t, n, strict=True)])
    return faded(t, target, p[TAU]) if p[TAU] > 0.0 else target


def rate(t: np.ndarray, values: np.ndarray, past: int = 0) -> np.ndarray:
    """d/dt of what is sampled at t, about each instant or over a step before it; zero where there is one instant.

    past: which step, as of `Motion`. Rows of one stamp are one instant.
    """
    stamp, first, at = np.unique(t, return_index=True, return_inverse=True)
    if stamp.size < 2:
        return np.zeros(t.size)
    if not past:
        return np.asarray(np.gradient(values[first], stamp)[at])
    rate = np.diff(values[first]) / np.diff(stamp)
    return np.asarray(rate[np.maximum(at - past, 0)])


def _before(t: np.ndarray, past: int) -> np.ndarray:
    """So many instants before each of t, shape (M,); the first where there is none so early."""
    stamp, at = np.unique(t, return_inverse=True)
    return np.asarray(stamp[np.maximum(at - past, 0)])


@law
def faded(t: np.ndarray, values: np.ndarray, memory: float) -> np.ndarray:
    """Values remembered with an exponential memory [s], from rest at the first, shape (I,)."""
    out, state = np.empty(t.size), values[0]
    for k in range(t.size):
        if k > 0:
            state += (values[k] - state) * (1.0 - np.exp(-(t[k] - t[k - 1]) / memory))
        out[k] = state
    return out


def rung(t: np.ndarray, values: np.ndarray) -> np.ndarray:
    """What rings on after values in two phases, of each of RINGS_RAD_S in turn, from rest at the first, (I, 2 R).

    Of about the size of the values where it resonates least: a swinging load, water in a tank, a shaft that gives.
    """
    return np.column_stack([_rung(t, values, rad_s, DAMPING) for rad_s in RINGS_RAD_S])


@law
def _rung(t: np.ndarray, values: np.ndarray, rad_s: float, damping: float) -> np.ndarray:
    """Both parts of a state z with dz/dt = (i - damping) rad_s z + rad_s values, exact for values that are held."""
    out, z, pole = np.empty((t.size, 2)), 0j, complex(-damping, 1.0) * rad_s
    for k in range(t.size):
        if k > 0:
            turn = np.exp(pole * (t[k] - t[k - 1]))
            z = z * turn + values[k - 1] * (turn - 1.0) / pole * rad_s
        out[k, 0], out[k, 1] = z.real, z.imag
    return out


def drive_frequency(time: np.ndarray, values: np.ndarray) -> float:
    """Frequency [rad/s] at which a run's input is strongest, from its periodogram on an even grid."""
    grid = np.linspace(time[0], time[-1], time.size)
    even = np.interp(grid, time, values - np.mean(values))
    spectrum = np.abs(np.fft.rfft(even * np.hanning(even.size), 8 * even.size)) ** 2
    frequency = 2.0 * np.pi * np.fft.rfftfreq(8 * even.size, grid[1] - grid[0])
    inside = frequency < 5.0
    return float(frequency[inside][int(np.argmax(spectrum[inside]))])
