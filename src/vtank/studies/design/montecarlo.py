"""The likelihood on many seeds of the same experiments: bias, coverage of its intervals, variance against the bound."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...estimate import MODELS, NORMAL95, Estimate, cramer_rao, identify, observe, rounded_variance
from ...estimate.paper import Array, Model
from ...experiment import load_scenario, plan_run, simulate_surge, simulate_tank
from ...plant import load_truth, slot
from ...present import NAMES, Table, number, plain_names
from .study import PAPER

AT_A_TIME = 25  # seeds simulated together, for memory; the results do not depend on it


@dataclass(frozen=True)
class Trials:
    """Estimates on many seeds beside the truth.

    Attributes:
        title: what was fitted to what, made where.
        names: of the parameters.
        true: their values, shape (P,).
        found, claimed, bound: estimates, their claimed deviations and the Cramer-Rao deviations, shape (N, P).
        correlation: mean of the claimed correlations, shape (P, P).
        disturbed: seeds on which process noise was found.
        warnings: how often each was given.
    """

    title: str
    names: tuple[str, ...]
    true: Array
    found: Array
    claimed: Array
    bound: Array
    correlation: Array
    disturbed: int
    warnings: Counter[str]

    @property
    def bias(self) -> Array:
        """Mean error, shape (P,)."""
        return np.asarray((self.found - self.true).mean(axis=0))

    @property
    def coverage(self) -> Array:
        """Share of the 95 % intervals that hold the truth, shape (P,)."""
        return np.asarray(np.mean(np.abs(self.found - self.true) < NORMAL95 * self.claimed, axis=0))

    @property
    def variance_over_claim(self) -> Array:
        """Variance of the estimates over the mean variance they claim, shape (P,)."""
        return np.asarray(self.found.var(axis=0, ddof=1) / np.mean(self.claimed**2, axis=0))

    @property
    def variance_over_bound(self) -> Array:
        """Variance of the estimates over the mean Cramer-Rao bound, shape (P,)."""
        return np.asarray(self.found.var(axis=0, ddof=1) / np.mean(self.bound**2, axis=0))


def monte_carlo(
    truth: str = "paper-ii",
    model: Model = "II",
    seeds: int = 400,
    simulator: str = "surge",
    settings: Sequence[str] = (),
    seed: int = 1,
    threads: int = 1,
    advance: Callable[[str], None] = lambda note: None,
) -> Trials:
    """Simulate the paper's four experiments `seeds` times, fit each four together; `advance` is called for each fit.

    settings: `key=value` laid over the scenarios, such as "hold=rigid" or "tachometer.noise_rev_s=0".
    """
    scenarios = [load_scenario(name, settings) for name in PAPER]
    preset = load_truth(truth)
    p, names = preset.vector(), MODELS[model]
    simulate = simulate_tank if simulator == "tank" else simulate_surge
    variance = rounded_variance(scenarios[0].sonar.noise_m, scenarios[0].sonar.resolution_m)
    estimates: list[Estimate] = []
    bounds: list[Array] = []
    for first in range(0, seeds, AT_A_TIME):
        some = range(first, min(first + AT_A_TIME, seeds))
        plans = [plan_run(s, len(scenarios) * k + i, seed, preset) for k in some for i, s in enumerate(scenarios)]
        seen = [observe(result.run) for result in simulate(plans, threads)]
        for k in range(0, len(seen), len(scenarios)):
            runs = seen[k : k + len(scenarios)]
            bounds.append(np.sqrt(np.diag(cramer_rao(runs, p, names, variance))))
            estimates.append(identify(runs, model))
            advance(f"seed {len(estimates)}")
    where = "tank" if simulator == "tank" else "surge model"
    return Trials(
        f"Model {model} on {seeds} seeds of the paper's four experiments, truth {truth}, {where}",
        names,
        true=np.array([p[slot(name)] for name in names]),
        found=np.array([list(estimate.values.values()) for estimate in estimates]),
        claimed=np.array([list(estimate.sd.values()) for estimate in estimates]),
        bound=np.array(bounds),
        correlation=np.mean([estimate.correlation for estimate in estimates], axis=0),
        disturbed=sum(not estimate.problem.noise.quiet for estimate in estimates),
        warnings=Counter(_kind(warning) for estimate in estimates for warning in estimate.warnings),
    )


def _kind(warning: str) -> str:
    """A warning without its numbers."""
    return plain_names(warning).partition(":")[0].partition(" (")[0]


def trials_sheet(t: Trials) -> Table:
    """Bias, coverage and variance as a table."""
    count = t.found.shape[0]
    header = ("parameter", "truth", "bias %", "+-", "sd %", "coverage %", "var/claimed", "var/bound")
    percent = 100.0 / np.where(t.true == 0.0, 1.0, np.abs(t.true))
    sd = t.found.std(axis=0, ddof=1) * percent
    shares = 100.0 * t.coverage, t.variance_over_claim, t.variance_over_bound
    forms = ("+.3f", ".3f", ".3f", ".1f", ".2f", ".2f")
    rows = [
        (NAMES[name], number(float(true)), *map(format, values, forms))
        for name, true, *values in zip(t.names, t.true, t.bias * percent, sd / np.sqrt(count), sd, *shares, strict=True)
    ]
    names, pairs = [NAMES[name] for name in t.names], np.argwhere(np.triu(np.ones_like(t.correlation), 1))
    correlation = ", ".join(f"{names[i]}-{names[j]} {t.correlation[i, j]:+.2f}" for i, j in pairs)
    sure, scatter = 100.0 * NORMAL95 * np.sqrt(0.0475 / count), NORMAL95 * np.sqrt(2.0 / count)
    notes = [
        "Bias +- its own deviation, and scatter, in per cent of the truth (times 100 where that is 0). With "
        f"{count} seeds a coverage of 95 % shows as 95 +- {sure:.1f} %, a variance ratio "
        f"of 1 as 1 +- {scatter:.2f}. Bound: Cramer-Rao, for known sonar noise and a propeller speed "
        "recorded without error.",
        f"Mean claimed correlation: {correlation}.",
        f"Process noise found on {t.disturbed} of {count} seeds.",
        *(f"Warning on {number_of} of {count} seeds: {warning}." for warning, number_of in t.warnings.most_common()),
    ]
    return Table(header, tuple(rows), tuple(notes), name="monte_carlo", title=t.title)
