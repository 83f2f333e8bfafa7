"""The paper's comparisons between models, data sets and stages, repeated on many seeds: free runs on every data set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...estimate.paper import Array, Model, PaperSettings, cross_validation, identify_signals
from ...experiment import Result
from ...resources import TRUTHS
from ...units import FOOT_M
from .published import SETS
from .records import records, signals
from .study import FAST, STEPS_S

COMBINATIONS: tuple[tuple[str, Model], ...] = (
    ("kalman", "I"), ("kalman", "II"), ("two_stage", "II"), ("least_squares", "II"), ("kalman", "III"),
    ("kalman_settling", "I"), ("kalman_settling", "II"), ("two_stage_settling", "II"), ("kalman_settling", "III"),
)  # fmt: skip


@dataclass(frozen=True)
class Practice:
    """Deviation of the residuals [ft/s] of parameters from data set i on data set j, infinite where the run diverges.

    deviation: (truth, method, model) -> shape (steps, seeds, i, j).
    smallest: truth -> share of runs where C4 has the smallest element of P, in literal and in normalised units,
        shape (2, steps).
    """

    deviation: dict[tuple[str, str, Model], Array]
    smallest: dict[str, Array]

    def own(self, method: str, model: Model) -> Array:
        """Deviations on the data set that the parameters come from, of all truths, shape (steps, seeds x sets)."""
        return np.concatenate([np.einsum("tkii->tki", d).reshape(len(d), -1) for d in self._of(method, model)], axis=1)

    def crossed(self, method: str, model: Model) -> Array:
        """Deviations on the other data sets by data set of origin, shape (steps, truths x seeds, origin, 3 others)."""
        other = ~np.eye(SETS, dtype=bool)
        of = self._of(method, model)
        return np.concatenate([d[..., other].reshape(*d.shape[:2], SETS, SETS - 1) for d in of], axis=1)

    def _of(self, method: str, model: Model) -> list[Array]:
        return [deviation for key, deviation in self.deviation.items() if key[1:] == (method, model)]


def practise(
    seed: int, seeds: int, advance: Callable[[str], None] = lambda note: None, truths: Sequence[str] = TRUTHS
) -> Practice:
    """Identify and cross-validate on many seeds; `advance` is called once for each truth."""
    practice = Practice({}, {})
    for truth in truths:
        flown = records(truth, seeds, seed)
        for method, model in COMBINATIONS:
            practice.deviation[truth, method, model] = np.array(
                [[_cross(runs, settings, model) for runs in flown] for settings in at_steps(method)]
            )
        both = [
            [_smallest(flown, settings) for settings in at_steps(method)] for method in ("kalman", "kalman_settling")
        ]
        practice.smallest[truth] = np.array(both)
        advance(truth)
    return practice


def at_steps(method: str) -> list[PaperSettings]:
    """A method at each T of STEPS_S."""
    return [replace(FAST[method], regression_step_s=step_s) for step_s in STEPS_S]


def _cross(runs: Sequence[Result], settings: PaperSettings, model: Model) -> Array:
    """Deviations [ft/s], shape (origin, data set)."""
    seen = [signals(run, settings) for run in runs]
    parameters = [identify_signals(s, model, settings).parameters for s in seen]
    deviation = np.array([[s.deviation / FOOT_M for s in row] for row in cross_validation(parameters, seen)])
    return np.where(np.isfinite(deviation), deviation, np.inf)


def _smallest(flown: Sequence[Sequence[Result]], settings: PaperSettings) -> float:
    """Share of runs in which C4 = T^2 b/tau has the smallest final variance, in the units in which Q counts."""
    hits = []
    for runs in flown:
        for run in runs:
            estimate = identify_signals(signals(run, settings), "II", settings)
            variance = estimate.evolution.variance[-1]
            if settings.scaling == "normalised":
                variance = variance * np.nanmean(estimate.rows.h**2, axis=0)
            hits.append(int(np.argmin(variance)) == 3)
    return float(np.mean(hits))
