"""The closed loop's frequency response, measured in the tank: describing functions of position against its command."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...experiment import Excitation, Plan, Result, Scenario, clearances, plan_run, simulate_tank
from ...plant import Truth
from ...waves import Waves
from .loop import Array, Complex

FREQUENCIES_RAD_S = np.geomspace(0.05, 2.0, 20)  # [rad/s] around the paper's 0.2 to 0.7; a choice
AMPLITUDES_M = (0.05, 0.1, 0.2, 0.4)  # [m] up to what the tank's 0.8 m behind the hull allow; a choice
SETTLING_S = 60.0  # [s] several time constants of the loop, for the motion to become periodic; a choice
MEASURED_S = 60.0  # [s] least length of the measured cycles, against noise; a choice
CYCLES = 2  # fewest that are measured; a choice
RAMP_S = 10.0  # [s] over which the command is faded in; a choice
HARMONICS = 3  # fitted, of which the first counts; a choice
HALF_POWER = 1.0 / np.sqrt(2.0)  # -3 dB
NEAR = 0.98  # of the limit counts as the limit: the motor drive's governor trembles by less; a choice
TAKEN_OVER = 0.05  # share of time with n at its limit from which the limit is said to rule; a choice


@dataclass(frozen=True, eq=False)
class Response:
    """Measured responses, axes amplitude and frequency.

    Attributes:
        amplitude_m: shape (A,); rad_s: shape (W,).
        response: first harmonic of position over that of the command, shape (A, W); NaN where the hull struck a wall.
        at_limit: share of time with the propellers at their limit, shape (A, W).
        n_rms_rev_s: shape (A, W).
        distortion: second and third harmonic over the first, shape (A, W).
        unrest: change of the first harmonic from the first half of the measured cycles to the second, over the
            command, shape (A, W): what noise and slow transients leave uncertain.
    """

    amplitude_m: Array
    rad_s: Array
    response: Complex
    at_limit: Array
    n_rms_rev_s: Array
    distortion: Array
    unrest: Array

    @property
    def gain(self) -> Array:
        """Amplitude ratio, shape (A, W)."""
        return np.abs(self.response)

    @property
    def phase_rad(self) -> Array:
        """Phase of the position against the command, continuous over frequency, shape (A, W)."""
        return unwrapped(self.response)

    def bandwidth_rad_s(self) -> Array:
        """Frequency at which the gain falls below -3 dB, shape (A,); NaN where it does not within the band."""
        return np.array([crossing(self.rad_s, gain, HALF_POWER, falling=True) for gain in self.gain])

    def limit_rad_s(self) -> Array:
        """Frequency from which n is at its limit for TAKEN_OVER of the time, shape (A,); NaN where it never is."""
        return np.array([crossing(self.rad_s, share, TAKEN_OVER, falling=False) for share in self.at_limit])


def unwrapped(response: Complex) -> Array:
    """Phase, continuous along the last axis [rad], NaN left out of the count."""
    phase = np.angle(response)
    for row in phase.reshape(-1, phase.shape[-1]):
        known = np.isfinite(row)
        row[known] = np.unwrap(row[known])
    return phase


def crossing(rad_s: Array, value: Array, level: float, falling: bool) -> float:
    """First frequency at which the value passes the level for good or bad, linear in the logarithm of frequency."""
    known, sign = np.isfinite(value), -1.0 if falling else 1.0
    return float(np.exp(passage(np.log(rad_s[known]), sign * (value[known] - level))))


def passage(x: Array, over: Array) -> float:
    """Where `over` comes up to 0, linear between the x, shape (N,); the first x if it is there, NaN if it never is."""
    past = np.flatnonzero(over >= 0.0)
    if past.size == 0:
        return float("nan")
    i = int(past[0])
    return float(np.interp(0.0, over[i - 1 : i + 1], x[i - 1 : i + 1]) if i else x[0])


def measured_s(rad_s: float) -> float:
    """Length of the cycles that are measured, a whole number of them [s]."""
    cycle = 2.0 * np.pi / rad_s
    return cycle * max(CYCLES, int(np.ceil(MEASURED_S / cycle)))


def sine_plan(
    scenario: Scenario, amplitude_m: float, rad_s: float, truth: Truth | str | None = None, run: int = 0
) -> Plan:
    """The scenario with a single sinusoid in still water, as long as it takes; InputError where it would hit a wall."""
    sine = Excitation("position_sine", "position", (amplitude_m,), (rad_s,), ramp_s=RAMP_S)
    duration = SETTLING_S + measured_s(rad_s) + scenario.period_s
    name = f"{scenario.name}-{amplitude_m:g}-{rad_s:.4g}"
    still = replace(scenario, excitation=sine, duration_s=duration, waves=Waves())
    return plan_run(still, run, truth=truth, name=name)


def sweep(
    scenario: Scenario,
    amplitude_m: Sequence[float] = AMPLITUDES_M,
    rad_s: Array = FREQUENCIES_RAD_S,
    truth: Truth | str | None = None,
    nthread: int = 1,
    progress: Callable[[float], None] | None = None,
) -> Response:
    """Fly every amplitude at every frequency in the tank, and measure."""
    cases = [(a, w) for w in rad_s for a in amplitude_m]
    plans = [sine_plan(scenario, a, float(w), truth, run) for run, (a, w) in enumerate(cases)]
    points = [measure(result) for result in simulate_tank(plans, nthread, progress)]
    table = np.array(points).reshape(len(rad_s), len(amplitude_m), -1).transpose(2, 1, 0)
    limit, n_rms, distortion, unrest = table[1:].real
    return Response(np.asarray(amplitude_m), rad_s, table[0], limit, n_rms, distortion, unrest)


def measure(result: Result) -> tuple[complex, float, float, float, float]:
    """Response, share at the limit, rms of n [rev/s], distortion and unrest of one run."""
    sine = result.plan.scenario.excitation
    w, amplitude = sine.frequencies_rad_s[0], sine.amplitudes[0]
    t = result.run.time_s
    chosen = t > t[-1] - measured_s(w)
    t, x, n = t[chosen], result.true["position_m"][chosen], result.true["n_rev_s"][chosen]
    at_limit, n_rms = share_at_limit(result.plan, n), rms(n)
    if struck(result):
        return complex(np.nan, np.nan), at_limit, n_rms, float("nan"), float("nan")
    half = t.size // 2
    tones, early, late = (harmonics(t[some], x[some], w) for some in (slice(None), slice(half), slice(half, None)))
    distortion = float(np.linalg.norm(tones[1:]) / abs(tones[0]))
    return complex(tones[0] / amplitude), at_limit, n_rms, distortion, float(abs(late[0] - early[0]) / amplitude)


def share_at_limit(plan: Plan, n_rev_s: Array) -> float:
    """Share of the samples at which the propellers run at their limit."""
    return float(np.mean(np.abs(n_rev_s) >= NEAR * plan.n_limit_rev_s))


def struck(result: Result) -> bool:
    """Whether the hull came to a wall."""
    moved = result.true["position_m"]
    return min(clearances(result.plan.scenario, float(moved.max()), float(moved.min()))) <= 0.0


def rms(value: Array) -> float:
    """Root mean square of the samples."""
    return float(np.sqrt(np.mean(value * value)))


def harmonics(time_s: Array, value: Array, rad_s: float) -> Complex:
    """Complex amplitudes c_m of value = mean + sum Im(c_m exp(i m w t)), shape (HARMONICS,), by least squares."""
    angles = np.outer(time_s, rad_s * np.arange(1, HARMONICS + 1))
    basis = np.hstack([np.ones((time_s.size, 1)), np.sin(angles), np.cos(angles)])
    solution = np.linalg.lstsq(basis, value, rcond=None)[0]
    return np.asarray(solution[1 : HARMONICS + 1] + 1j * solution[HARMONICS + 1 :])
