"""How the paper's estimate of Model II depends on everything the paper leaves unsaid, and on the truth.

One level is one way to do it. What is not under study stays at the base: T = 0.5 s, sonar filter q = 1 ft2/s5, filter
also on n, 120 s, 6 mm of noise. Each level is estimated on the same seeds, for each truth and data set.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from ...estimate.paper import Array, Model, PaperSettings, identify_signals
from ...experiment import Result
from ...plant import load_truth, to_feet
from ...present.document import csv_text
from .campaign import METHODS, TRUTHS
from .published import SETS
from .records import CASES, records, signals

QUANTITIES = ("a", "b", "gamma", "tau", "s_e")  # [1/ft, ft/rev2, 1/rev, s, ft/s]
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
        found += [Level("T", f"{t:g} s", method, replace(s, regression_step_s=t)) for t in (0.1, 0.2, 0.5, 1.0)]
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
    """Estimates of every level: (truth, key) -> shape (seeds, data sets, QUANTITIES), in feet."""

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
        """Estimates of one level, shape (seeds, data sets, QUANTITIES)."""
        return self.estimates[truth, self.level(factor, label, method).key]

    def band(self, truth: str, level: Level, quantity: str, data_set: int | None = None) -> Array:
        """10 %, 50 % and 90 % quantiles over seeds, and over data sets where none is given, shape (3,)."""
        values = self.estimates[truth, level.key][..., QUANTITIES.index(quantity)]
        return quantiles(values if data_set is None else values[:, data_set])

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
                    estimates[truth, level.key] = estimate_all(flown, level)
            advance(f"{truth}, {name}")
    feet = {truth: to_feet(load_truth(truth).lumped) for truth in truths}
    return Study(seed, seeds, tuple(chosen), feet, estimates)


def experiments(chosen: Sequence[Level]) -> tuple[str, ...]:
    """Experiments that the levels need."""
    return tuple(dict.fromkeys(level.experiment for level in chosen))


def estimate_all(flown: Sequence[Sequence[Result]], level: Level) -> Array:
    """Estimates of one level on records by seed and data set, shape (seeds, data sets, QUANTITIES)."""
    rows = []
    for runs in flown:
        found = [identify_signals(signals(r, level.settings, level.case), level.model, level.settings) for r in runs]
        rows.append([(*estimate.feet, estimate.statistics_ft_s.deviation) for estimate in found])
    return np.array(rows)


def study_csv(s: Study) -> str:
    """Quantiles of every level, truth and data set, one a line."""
    header = ("factor", "level", "method", "model", "truth", "data_set", "quantity", "true", "p10", "median", "p90")
    places = ("all", *map(str, range(1, SETS + 1)))
    rows = []
    for level, truth, place, quantity in product(s.levels, s.truths, places, QUANTITIES):
        if quantity == "gamma" and level.model != "III":
            continue
        true = (*s.truths[truth], np.nan)[QUANTITIES.index(quantity)]
        band = s.band(truth, level, quantity, None if place == "all" else int(place) - 1)
        numbers = (f"{x:.5g}" if np.isfinite(x) else "" for x in (true, *band))
        rows.append((level.factor, level.label, level.method, level.model, truth, place, quantity, *numbers))
    return csv_text(header, rows)
