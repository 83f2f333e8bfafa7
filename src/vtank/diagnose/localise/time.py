"""The time: in which windows the diagnosed simulator predicts better than the one before it.

The likelihood ratio of a window exceeds 1 / a by chance with a probability of at most a, whatever the window
(Markov's inequality on a mean of one: Wald, Sequential Analysis, 1947, ch. 3). With all windows looked at together,
a gain of log(windows / level) is significant. Evidence in windows locates a misfit in time: Hsueh et al. 2021 (tBME).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...estimate.problem import Filtered, Problem
from ...plant.parameters import indices
from ..evidence import Fitted
from ..freeform import Freeform
from ..selection import Selection
from ..verdict import Verdict

WINDOW_S = 10.0  # [s] a few periods of the drive; a choice
FEWEST_WINDOWS = 8  # shorter runs get shorter windows, so that there is a place to tell; a choice
LEVEL = 0.01  # probability of one false window, or of one false line, in all runs together; a choice


@dataclass(frozen=True)
class Windows:
    """Evidence in windows of one run.

    Attributes:
        run: the run's name.
        edges_s: where windows begin and end, shape (W + 1,) [s].
        gain: log-likelihood of the simulator after over that before, shape (W,).
        needed: gain from which a window is significant at LEVEL, all windows of all runs together.
        before, after: what is compared.
    """

    run: str
    edges_s: np.ndarray
    gain: np.ndarray
    needed: float
    before: str
    after: str

    @property
    def significant(self) -> np.ndarray:
        """Which windows are, shape (W,) of bool."""
        return self.gain > self.needed

    def document(self) -> list[dict[str, Any]]:
        """Significant stretches, neighbours joined, as plain data."""
        spans: list[dict[str, Any]] = []
        for w in np.flatnonzero(self.significant):
            start, stop, gain = float(self.edges_s[w]), float(self.edges_s[w + 1]), float(self.gain[w])
            if spans and spans[-1]["to"] == start:
                spans[-1] |= {"to": stop, "log_likelihood_gain": spans[-1]["log_likelihood_gain"] + gain}
            else:
                spans.append({"run": self.run, "from": start, "to": stop, "log_likelihood_gain": gain})
        return spans


def windowed_evidence(selection: Selection, verdict: Verdict) -> tuple[Windows, ...]:
    """Evidence in windows, per run, of the explanation that the verdict is about over the one it replaces."""
    before, after, names = _compared(selection, verdict)
    edges = [_edges(run.time_s) for run in selection.setting.runs]
    needed = float(np.log(sum(e.size - 1 for e in edges) / LEVEL))
    out = []
    for run, e, a, b in zip(selection.setting.runs, edges, before, after, strict=True):
        window = np.clip(np.searchsorted(e, run.time_s, side="right") - 1, 0, e.size - 2)
        gain = np.bincount(window, b - a, minlength=e.size - 1)
        out.append(Windows(run.name, e, gain, needed, *names))
    return tuple(out)


def shares(windows: tuple[Windows, ...]) -> list[float]:
    """Share of each run in the gain of all; none has any where the whole gain is not significant."""
    gains = [max(float(np.sum(w.gain)), 0.0) for w in windows]
    total = sum(gains)
    return [gain / total if total > windows[0].needed else 0.0 for gain in gains]


def _edges(time_s: np.ndarray) -> np.ndarray:
    length = float(time_s[-1] - time_s[0])
    count = max(FEWEST_WINDOWS, round(length / WINDOW_S))
    return np.linspace(time_s[0], time_s[-1], count + 1)


def _compared(selection: Selection, verdict: Verdict) -> tuple[list[np.ndarray], list[np.ndarray], tuple[str, str]]:
    """Log-likelihood of every measurement before and after, per run, and what the two are called."""
    nominal, refit = selection.nominal, selection.refit
    if verdict.kind in ("none", "parameters"):
        return pointwise(selection, nominal), pointwise(selection, refit), ("nominal", "parameters")
    by_run = [free.fit for free in selection.free if free.fit.hypothesis.varying]
    if verdict.kind == "varying" and by_run:
        return pointwise(selection, refit), pointwise(selection, by_run[0]), ("parameters", "varying")
    if verdict.kind == "unknown":
        free = selection.beyond
        if free.components:
            after = _gaussian(free.fit.problem, with_discrepancy(free))
            return pointwise(selection, free.fit), after, (free.fit.hypothesis.name, "unknown")
    return pointwise(selection, refit), pointwise(selection, verdict.fit), ("parameters", verdict.fit.hypothesis.name)


def pointwise(selection: Selection, fit: Fitted) -> list[np.ndarray]:
    """Log-likelihood of every measurement, outliers included, per run, shape (M,); sums to the fit's own."""
    parts = _gaussian(fit.problem, fit.filtered)
    rest = fit.log_likelihood - sum(float(np.sum(part)) for part in parts)
    places = _outliers(selection, fit)
    count = sum(int(place.sum()) for place in places)
    return [part + place * (rest / count) if count else part for part, place in zip(parts, places, strict=True)]


def _gaussian(problem: Problem, filtered: list[Filtered]) -> list[np.ndarray]:
    parts = []
    for k, f in enumerate(filtered):
        density = -0.5 * (f.innovation**2 / f.variance + np.log(2.0 * np.pi * f.variance))
        parts.append(np.where(problem.used(k), density, 0.0))
    return parts


def _outliers(selection: Selection, fit: Fitted) -> list[np.ndarray]:
    """Measurements at which an outlier effect of the fit earns its evidence, per run, shape (M,) of bool."""
    places = [np.zeros(run.time_s.size, bool) for run in selection.setting.runs]
    for k, run in enumerate(selection.setting.runs):
        if "range_m" in fit.hypothesis.outliers:
            places[k] |= selection.setting.flags[k]
        for effect in fit.hypothesis.effects:
            if effect.outliers and (law := effect.true_input) is not None:
                own = fit.problem.model(fit.optimum.theta, k)[0][list(indices(effect))]
                pairs = zip(run.input, run.lone, strict=True)
                spiked = np.array([law(n, lone, *own) != law(n, 0.0, *own) for n, lone in pairs])
                places[k][np.searchsorted(run.time_s, run.input_time_s[spiked]).clip(max=run.time_s.size - 1)] = True
    return places


def with_discrepancy(free: Freeform) -> list[Filtered]:
    """Innovations of a fit with what it lacks added and the parameters moved along, to first order, per run."""
    fit = free.fit
    after = free.problem().residuals(fit.optimum.theta, fit.filtered)
    after = after + fit.problem.jacobian(fit.optimum.theta, fit.filtered) @ free.shift
    ends = np.cumsum([f.innovation.size for f in fit.filtered])[:-1]
    parts = zip(fit.filtered, np.split(after, ends), strict=True)
    return [replace(f, innovation=part * np.sqrt(f.variance)) for f, part in parts]
