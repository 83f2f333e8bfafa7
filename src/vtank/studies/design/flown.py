"""A plan of experiments, flown once on the surge model: what would be recorded, and with what noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...estimate import Noise, Observed, observe, rounded_variance
from ...experiment import Plan, Result, Scenario, plan_run, simulate_surge
from ...plant import BETA, TAU, Truth

Array = NDArray[np.float64]
SPEED_SD = 0.01  # [m/s] noise of a speed sensor that could be added: a Doppler log's, a guess


@dataclass(frozen=True, eq=False)
class Flown:
    """One experiment of a plan.

    Attributes:
        scenario: what was commanded, sensed and disturbed.
        truth: the preset behind it.
        p: true parameter vector, effects included, shape (SIZE,).
        run: what was recorded.
        noise: the true noise, that of the tachometer as a disturbance of the hull.
        surge_m_s: true speed at the scenario's ticks, shape (T,).
        top_rev_s: fastest propeller speed either way [rev/s].
    """

    scenario: Scenario
    truth: Truth
    p: Array
    run: Observed
    noise: Noise
    surge_m_s: Array
    top_rev_s: float

    @property
    def minutes(self) -> float:
        """Length of the record [min]."""
        return self.scenario.duration_s / 60.0


def sonar_variance(scenario: Scenario) -> float:
    """Variance of a range [m2]; InputError where it is none, and no bound."""
    variance = rounded_variance(scenario.sonar.noise_m, scenario.sonar.resolution_m)
    if not variance > 0.0:
        raise InputError(f"{scenario.path}: sonar.noise_m: bounds need a noise above 0, such as 0.006")
    return variance


def noise_of(scenario: Scenario, p: Array, n_rev_s: Array) -> Noise:
    """The noise as the likelihood knows it: white on the range, and one disturbance with the memory of the stronger.

    p: the truth; n_rev_s: recorded propeller speed, shape (T,).
    """
    variance, turbulence = sonar_variance(scenario), scenario.turbulence
    strongest, memory = tachometer_disturbance(scenario, p, n_rev_s)
    if turbulence.acceleration_m_s2 > strongest:
        memory = turbulence.time_s
    sigma = float(np.hypot(strongest, turbulence.acceleration_m_s2))
    return Noise((variance, variance, SPEED_SD**2), sigma, memory)


def tachometer_disturbance(scenario: Scenario, p: Array, n_rev_s: Array) -> tuple[float, float]:
    """Deviation [m/s2] and memory [s] of what an error of the recorded propeller speed does to the thrust.

    White from tick to tick at the tachometer, 2 beta |n| as large in thrust (|n| at its rms), then through the lag:
    with a = exp(-T / tau) its variance falls to (1 - a)/(1 + a) and its memory is tau. Without a lag the disturbance
    is held over a tick, as strong at low frequencies as a memory of half a tick.
    """
    period, tau = scenario.period_s, float(p[TAU])
    white = 2.0 * float(p[BETA]) * float(np.sqrt(np.mean(n_rev_s**2))) * scenario.tachometer.noise_rev_s
    if tau == 0.0:
        return white, 0.5 * period
    a = np.exp(-period / tau)
    return white * float(np.sqrt((1.0 - a) / (1.0 + a))), tau


def check(scenario: Scenario) -> None:
    """InputError where the surge model cannot say what the experiment tells."""
    if scenario.excitation.axis != "surge":
        raise InputError(f"{scenario.path}: excitation.axis: expected surge, found {scenario.excitation.axis}")
    if scenario.waves.kind != "none":
        raise InputError(f"{scenario.path}: waves.kind: the surge model is identified in still water, expected none")
    sonar_variance(scenario)


def fly(scenarios: Sequence[Scenario], truth: Truth, seed: int) -> list[Flown]:
    """Each scenario once; InputError where one hits a wall."""
    plans = [plan_run(scenario, i, seed, truth) for i, scenario in enumerate(scenarios)]
    return [flown(plan, result) for plan, result in zip(plans, simulate_surge(plans), strict=True)]


def flown(plan: Plan, result: Result) -> Flown:
    """A simulated plan; InputError where it hit a wall."""
    result.check_clearance()
    top = float(np.max(np.abs(result.true["n_rev_s"])))
    run = observe(result.run)
    noise = noise_of(plan.scenario, plan.p, run.input)
    return Flown(plan.scenario, plan.truth, plan.p, run, noise, result.true["surge_m_s"], top)
