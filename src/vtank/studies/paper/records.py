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

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from ...effects import tachometer_spikes
from ...estimate.paper import Array, PaperSettings, Signals, sonar_filter_compiled, speed_signals
from ...experiment import Result, Scenario, load_scenario, plan_run, simulate_surge
from ...plant import Truth
from ...units import FOOT_M
from .campaign import SCENARIOS

CASES = ("exact", "filter u", "filter u,n", "noise", "recorded")
Change = Callable[[Scenario], Scenario]


@dataclass(frozen=True)
class Record:
    """One run as recorded and as it was, all shape (T,) at one period."""

    period_s: float
    range_m: Array
    n_rev_s: Array
    true_range_m: Array
    true_u_m_s: Array
    true_n_rev_s: Array


def record(result: Result) -> Record:
    """The record of a simulated run."""
    columns, true = result.run.columns, result.true
    period = result.plan.scenario.period_s
    return Record(period, columns["range_m"], columns["n_rev_s"], true["range_m"], true["surge_m_s"], true["n_rev_s"])


def records(
    truth: Truth | str,
    seeds: int,
    seed: int,
    change: Change = lambda scenario: scenario,
    scenarios: Sequence[str] = SCENARIOS,
) -> list[list[Record]]:
    """Records by seed and data set. The noise of a seed is the same for every truth and change."""
    plans = [
        plan_run(change(load_scenario(name)), run=k * len(SCENARIOS) + i, seed=seed, truth=truth)
        for k in range(seeds)
        for i, name in enumerate(scenarios)
    ]
    flat = [record(result) for result in simulate_surge(plans)]
    return [flat[k * len(scenarios) : (k + 1) * len(scenarios)] for k in range(seeds)]


def signals(r: Record, settings: PaperSettings, case: str = "recorded") -> Signals:
    """What the estimator sees of a record in one of CASES; the same instants in all of them."""
    q, noise_variance = settings.filter_q_ft2_s5 * FOOT_M**2, settings.filter_r_ft2 * FOOT_M**2

    def filtered(values: Array) -> Array:
        return sonar_filter_compiled(values, r.period_s, q, noise_variance)

    def speed(range_m: Array) -> Array:
        return -filtered(range_m)[:, 1]

    match case:
        case "exact":
            u, n = r.true_u_m_s, r.true_n_rev_s
        case "filter u":
            u, n = speed(r.true_range_m), r.true_n_rev_s
        case "filter u,n":
            u, n = speed(r.true_range_m), filtered(r.true_n_rev_s)[:, 0]
        case "noise":
            u, n = r.true_u_m_s + speed(r.range_m) - speed(r.true_range_m), r.true_n_rev_s
        case "recorded":
            u = speed(r.range_m)
            n = filtered(r.n_rev_s)[:, 0] if settings.filter_propeller else r.n_rev_s
        case _:
            raise ValueError(f"{case}: expected one of {', '.join(CASES)}")
    skip = round(settings.settle_s / r.period_s)
    return speed_signals(u[skip:], n[skip:], r.period_s, settings)


# --- changes of the experiment -----------------------------------------------------------------------------------


def with_noise(deviation_m: float) -> Change:
    """Another sonar noise [m]; zero also takes away resolution and the tachometer's noise."""

    def change(s: Scenario) -> Scenario:
        resolution = s.sonar.resolution_m if deviation_m > 0.0 else 0.0
        tachometer = s.tachometer if deviation_m > 0.0 else replace(s.tachometer, noise_rev_s=0.0)
        return replace(s, sonar=replace(s.sonar, noise_m=deviation_m, resolution_m=resolution), tachometer=tachometer)

    return change


def with_amplitude(factor: float) -> Change:
    """A smaller or larger command."""
    return lambda s: replace(
        s, excitation=replace(s.excitation, amplitudes=tuple(factor * a for a in s.excitation.amplitudes))
    )


def with_duration(duration_s: float) -> Change:
    """A shorter or longer record [s]."""
    return lambda s: replace(s, duration_s=duration_s)


def with_spikes(probability: float, size_rev_s: float) -> Change:
    """Spikes in the tachometer's readings, as data set 4 of the paper had them."""
    effects = dict(zip(tachometer_spikes.EFFECT.slots(), (probability, size_rev_s), strict=True))
    return lambda s: replace(s, effects={**s.effects, **effects})
