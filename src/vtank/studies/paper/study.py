"""How the paper's estimate of Model II depends on everything the paper leaves unsaid, and on the truth.

One level is one way to do it. What is not under study stays at the base: sonar filter q = 1 ft2/s5, filter also on n,
120 s, 6 mm of noise. T, on which everything hangs, is unknown: each level is estimated at every T of STEPS_S, whose
equal weights make it log-uniform, on the same seeds, for each truth and data set.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from ...estimate.paper import Array, Model, PaperSettings, decimated, identify_signals
from ...experiment import Result
from ...plant import load_truth, to_feet
from ...present.document import csv_text
from ...resources import TRUTHS
from .campaign import METHODS
from .published import SETS
from .records import CASES, filtered_speed, records

QUANTITIES = ("a", "b", "gamma", "tau", "s_e")  # [1/ft, ft/rev2, 1/rev, s, ft/s]
STEPS_S = (0.1, 0.2, 0.3, 0.5, 0.9, 1.5)  # T: even in its logarithm, rounded to whole pings
BAND = (0.1, 0.5, 0.9)  # quantiles that are reported
FAST = {name: replace(settings, compiled=True) for name, settings in METHODS.items()}


@dataclass(frozen=True)
class Level:
    """One way to estimate: label and value of a factor, method, settings, what the estimator sees, the experiment."""

    factor: str
    label: str
    method: str
    settings: PaperSettings
    case: str = "recorded"
    experiment: str = "as planned"
    model: Model = "II"

    @property
    def key(self) -> tuple[PaperSettings, str, str, Model]:
        """Two levels of one key are the same computation."""
        return self.settings, self.case, self.experiment, self.model


EXPERIMENTS: dict[str, tuple[str, ...]] = {  # settings of the scenarios
    "as planned": (),
    "half amplitude": (),
    "no noise": ("sonar.noise_m=0", "sonar.resolution_m=0", "tachometer.noise_rev_s=0"),
    "3 mm": ("sonar.noise_m=0.003",),
    "12 mm": ("sonar.noise_m=0.012",),
    "30 mm": ("sonar.noise_m=0.030",),
    "60 s": ("duration_s=60",),
    "240 s": ("duration_s=240",),
    "spikes": ("effects.tachometer_spikes.p=0.05", "effects.tachometer_spikes.size_rev_s=8"),  # as data set 4 had them
}
AMPLITUDES = {"half amplitude": 0.5}  # of the command, over the scenario's
COMPARED = ("kalman", "least_squares")  # methods for which every factor is varied


def levels() -> list[Level]:
    """All levels, by factor."""
    found = [Level("method", name, name, settings) for name, settings in FAST.items()]
    found += [Level("Model III", "q_ii = 3", "kalman", FAST["kalman"], model="III")]
    for q in (1e-4, 1e-2, 1.0, 3.0):
        found.append(Level("Q", f"{q:g}", "literal", replace(FAST["kalman"], q_model_ii=q)))
    for q in (1e-6, 1e-4, 1e-2, 1.0):
        found.append(Level("Q", f"{q:g}", "normalised", replace(FAST["kalman_settling"], q_model_ii=q)))
    for method in COMPARED:
        s = FAST[method]
        found += [Level("filter q", f"{q:g}", method, replace(s, filter_q_ft2_s5=q)) for q in (0.1, 1.0, 10.0, 100.0)]
        found += [Level("filter on n", "yes", method, s)]
        found += [Level("filter on n", "no", method, replace(s, filter_propeller=False))]
        found += [Level("part", case, method, s, case) for case in CASES]
        for factor, labels in EXPERIMENTAL.items():
            found += [Level(factor, label, method, s, experiment=name) for label, name in labels.items()]
    return found


EXPERIMENTAL = {  # factor -> label -> experiment
    "noise": {"none": "no noise", "3 mm": "3 mm", "6 mm": "as planned", "12 mm": "12 mm", "30 mm": "30 mm"},
    "amplitude": {"x 0.5": "half amplitude", "x 1": "as planned"},
    "record": {"60 s": "60 s", "120 s": "as planned", "240 s": "240 s"},
    "spikes": {"none": "as planned", "5 %": "spikes"},
}


@dataclass(frozen=True)
class Study:
    """Estimates of every level: (truth, key) -> shape (steps, seeds, data sets, QUANTITIES), in feet."""

    seed: int
    seeds: int
    levels: tuple[Level, ...]
    truths: dict[str, tuple[float, float, float, float]]
    estimates: dict[tuple[str, object], Array]

    def level(self, factor: str, label: str, method: str) -> Level:
        """The level of that name. KeyError where there is none."""
        for level in self.levels:
            if (level.factor, level.label, level.method) == (factor, label, method):
                return level
        raise KeyError((factor, label, method))

    def of(self, truth: str, factor: str, label: str, method: str) -> Array:
        """Estimates of one level, shape (steps, seeds, data sets, QUANTITIES)."""
        return self.estimates[truth, self.level(factor, label, method).key]

    def band(
        self, truth: str, level: Level, quantity: str, data_set: int | None = None, step: int | None = None
    ) -> Array:
        """10 %, 50 % and 90 % quantiles over seeds, and over data sets and T where none is given, shape (3,)."""
        values = self.estimates[truth, level.key][..., QUANTITIES.index(quantity)]
        values = values if step is None else values[step : step + 1]
        return quantiles(values if data_set is None else values[..., data_set])

    def medians(self, truth: str, factor: str, label: str, method: str, quantity: str) -> Array:
        """Median over seeds and data sets at each T, shape (steps,)."""
        level = self.level(factor, label, method)
        return np.array([self.band(truth, level, quantity, step=k)[1] for k in range(len(STEPS_S))])

    @cached_property
    def factors(self) -> tuple[str, ...]:
        """Factors in order."""
        return tuple(dict.fromkeys(level.factor for level in self.levels))


def quantiles(values: Array) -> Array:
    """BAND quantiles of all values, a diverged one (NaN) counting as beyond any other, shape (3,)."""
    ranked = np.sort(np.where(np.isfinite(values), values, np.inf), axis=None)
    place = np.rint(np.array(BAND) * (ranked.size - 1)).astype(int)
    return np.where(np.isinf(ranked[place]), np.nan, ranked[place])


def study(
    seed: int,
    seeds: int,
    advance: Callable[[str], None] = lambda note: None,
    truths: Sequence[str] = TRUTHS,
    chosen: Sequence[Level] | None = None,
) -> Study:
    """Estimate every level on the same seeds; `advance` is called once for each truth and experiment."""
    chosen = levels() if chosen is None else list(chosen)
    estimates: dict[tuple[str, object], Array] = {}
    for truth in truths:
        for name in experiments(chosen):
            flown = records(truth, seeds, seed, EXPERIMENTS[name], AMPLITUDES.get(name, 1.0))
            for level in chosen:
                if level.experiment == name and (truth, level.key) not in estimates:
                    estimates[truth, level.key] = estimate_all(flown, level.settings, level.case, level.model)
            advance(f"{truth}, {name}")
    feet = {truth: to_feet(load_truth(truth).lumped) for truth in truths}
    return Study(seed, seeds, tuple(chosen), feet, estimates)


def experiments(chosen: Sequence[Level]) -> tuple[str, ...]:
    """Experiments that the levels need."""
    return tuple(dict.fromkeys(level.experiment for level in chosen))


def estimate_all(
    flown: Sequence[Sequence[Result]],
    settings: PaperSettings,
    case: str = "recorded",
    model: Model = "II",
    steps_s: Sequence[float] = STEPS_S,
) -> Array:
    """Estimates at every T from records by seed and data set, shape (steps, seeds, data sets, QUANTITIES)."""
    found = np.empty((len(steps_s), len(flown), SETS, len(QUANTITIES)))
    for k, runs in enumerate(flown):
        for d, run in enumerate(runs):
            u, n = filtered_speed(run, settings, case)
            for i, step_s in enumerate(steps_s):
                seen = decimated(u, n, run.plan.scenario.period_s, step_s)
                estimate = identify_signals(seen, model, settings)
                found[i, k, d] = *estimate.feet, estimate.statistics_ft_s.deviation
    return found


def study_csv(s: Study) -> str:
    """Quantiles of every level, truth and data set over all T, and of all data sets at each T, one a line."""
    header = ("factor", "level", "method", "model", "truth", "T_s", "data_set", "quantity", "true", "p10", "median",
              "p90")  # fmt: skip
    places = [(None, None), *((None, d) for d in range(SETS)), *((k, None) for k in range(len(STEPS_S)))]
    rows = []
    for level, truth, (step, data_set), quantity in product(s.levels, s.truths, places, QUANTITIES):
        if quantity == "gamma" and level.model != "III":
            continue
        true = (*s.truths[truth], np.nan)[QUANTITIES.index(quantity)]
        band = s.band(truth, level, quantity, data_set, step)
        where = ("all" if step is None else f"{STEPS_S[step]:g}", "all" if data_set is None else str(data_set + 1))
        numbers = (f"{x:.5g}" if np.isfinite(x) else "" for x in (true, *band))
        rows.append((level.factor, level.label, level.method, level.model, truth, *where, quantity, *numbers))
    return csv_text(header, rows)
