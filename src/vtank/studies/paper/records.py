"""Many seeds of the four experiments on the surge model, and the speed and propeller speed that an estimator is shown.

What the paper's regression sees of a run is u = -(velocity of the filtered range) and the filtered n. The filter is
linear, so that u falls apart exactly into true speed + distortion by the filter + filtered noise, and each part can be
left out:

    exact       true u, true n                                       what the time step alone does
    filter u    filter's u of the noise-free range, true n           and the filter on u
    filter u,n  filter's u of the noise-free range, filter's n       and the filter on n, as in the paper
    noise       true u + filtered noise, true n                      noise in u alone
    recorded    filter's u of the readings, filter's n of the tachometer's: the paper's way
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...estimate.paper import Array, PaperSettings, Signals, decimated, sonar_filter_compiled
from ...experiment import Result, Scenario, load_scenario, plan_run, simulate_surge
from ...plant import Truth
from ...units import FOOT_M
from .campaign import SCENARIOS
from .published import SETS

CASES = ("exact", "filter u", "filter u,n", "noise", "recorded")


def records(
    truth: Truth | str, seeds: int, seed: int, settings: Sequence[str] = (), amplitude: float = 1.0
) -> list[list[Result]]:
    """Runs by seed and data set. The noise of a seed is the same for every truth and experiment.

    settings: KEY=VALUE laid over the scenarios. amplitude: of the command, over that of each scenario.
    """
    scenarios = [louder(load_scenario(name, settings), amplitude) for name in SCENARIOS]
    plans = [
        plan_run(scenario, run=k * SETS + i, seed=seed, truth=truth)
        for k in range(seeds)
        for i, scenario in enumerate(scenarios)
    ]
    flat = simulate_surge(plans)
    return [flat[k * SETS : (k + 1) * SETS] for k in range(seeds)]


def louder(s: Scenario, factor: float) -> Scenario:
    amplitudes = tuple(factor * amplitude for amplitude in s.excitation.amplitudes)
    return replace(s, excitation=replace(s.excitation, amplitudes=amplitudes))


def signals(r: Result, settings: PaperSettings, case: str = "recorded") -> Signals:
    """What the estimator sees of a run in one of CASES; the same instants in all of them."""
    return decimated(*filtered_speed(r, settings, case), r.plan.scenario.period_s, settings.regression_step_s)


def filtered_speed(r: Result, settings: PaperSettings, case: str = "recorded") -> tuple[Array, Array]:
    """Speed [m/s] and propeller speed [rev/s] in one of CASES at every ping after the filter has settled."""
    q, noise_variance = settings.filter_q_ft2_s5 * FOOT_M**2, settings.filter_r_ft2 * FOOT_M**2
    period_s, recorded, true = r.plan.scenario.period_s, r.run.columns, r.true

    def filtered(values: Array) -> Array:
        return sonar_filter_compiled(values, period_s, q, noise_variance)

    def speed(range_m: Array) -> Array:
        return -filtered(range_m)[:, 1]

    match case:
        case "exact":
            u, n = true["surge_m_s"], true["n_rev_s"]
        case "filter u":
            u, n = speed(true["range_m"]), true["n_rev_s"]
        case "filter u,n":
            u, n = speed(true["range_m"]), filtered(true["n_rev_s"])[:, 0]
        case "noise":
            u, n = true["surge_m_s"] + speed(recorded["range_m"]) - speed(true["range_m"]), true["n_rev_s"]
        case "recorded":
            u, n = speed(recorded["range_m"]), recorded["n_rev_s"]
            n = filtered(n)[:, 0] if settings.filter_propeller else n
        case _:
            raise ValueError(f"{case}: expected one of {', '.join(CASES)}")
    skip = round(settings.settle_s / period_s)
    return u[skip:], n[skip:]
