"""How far the gap shrinks: nested leave-one-run-out, and what it is worth on new data.

Inside each fold the hypothesis is chosen and fitted without the run left out (of a single run: a block of time); then
that run is predicted open loop (`holdout.py`). The floor is what is left on the same runs to a model that knows
everything: the error of the most probable cause on its own data, as far as noise and turbulence can account for it.
The interval is for the fraction closed when all runs are made once more (`new_data.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from ..estimate.observed import Observed
from .discrepancy import Discrepancy
from .evidence import STATES, Fitted, Setting, evaluate
from .holdout import Prediction, fraction_closed, model_of, rms, targets_of
from .new_data import Gaps, NewData
from .prior import calibration
from .selection import Selection
from .verdict import Verdict, probabilities

WITHIN = 8.0  # log evidence behind a fold's leader up to which a hypothesis is refitted there
MOST = 4  # hypotheses refitted in a fold, beside the nominal and the refit
DRAWS, TOGETHER = 120, 30  # simulated sets of new runs, and how many at a time
BLOCKS = 4  # blocks of time that a single run is cut into
FEWEST = 40  # sets with a gap to close that an interval needs


def shrink(selection: Selection, verdict: Verdict, seed: int = 0) -> dict[str, Any]:
    """The gap before and after on data that were not used, in the form of schema vtank.diagnosis/1."""
    new, parts = NewData(selection, verdict), blocks(selection.setting)
    with ThreadPoolExecutor(2) as pool:
        folds = list(pool.map(partial(leave_out, selection, parts), range(len(parts.runs))))
        nominal, refit, diagnosed = (rms([fold.errors[i] for fold in folds]) for i in range(3))
        floor = new.floor()
        closed = fraction_closed(refit, diagnosed, floor) if verdict.kind not in ("none", "parameters") else None
        sets: list[Gaps] = []
        if closed is not None and selection.setting.foreign:
            sets = resampled(folds, floor, seed)
        elif closed is not None:
            seeds = [(seed, i) for i in range(DRAWS)]
            sets = [*chain(*pool.map(new.new_sets, [seeds[i : i + TOGETHER] for i in range(0, DRAWS, TOGETHER)]))]
    return {
        "unit": "m" if any(run.has_position for run in parts.runs) else "m/s",
        "nominal": nominal,
        "refit": refit,
        "diagnosed": diagnosed,
        "floor": floor,
        "fraction_closed": closed,
        "interval90": interval90(sets, closed),
        "left_out": [run.name for run in parts.runs],
        "chosen": [fold.chosen for fold in folds],
    }


# --- leave one run out -------------------------------------------------------------------------------------------
def blocks(setting: Setting) -> Setting:
    """The setting itself, or of a single run its blocks of time, which then take the place of runs."""
    if len(setting.runs) > 1:
        return setting
    run, count = setting.runs[0], BLOCKS
    edges = np.linspace(run.time_s[0], run.time_s[-1], count + 1)
    pieces, rows = [], []
    for k in range(count):
        inside = (run.time_s >= edges[k]) & ((run.time_s < edges[k + 1]) | (k == count - 1))
        if not inside.any():
            continue  # nothing was measured for so long
        first = max(int(np.searchsorted(run.input_time_s, edges[k], "right")) - 1, 0)
        fed = slice(first, int(np.searchsorted(run.input_time_s, edges[k + 1], "right")))
        rows.append(inside)
        pieces.append(Observed(f"{run.name}, {edges[k]:.4g} to {edges[k + 1]:.4g} s", run.input_name,
                               run.input_time_s[fed], run.input[fed], run.time_s[inside], run.value[inside],
                               run.kind[inside], run.lone[fed]))  # fmt: skip
    flags, weight = (tuple(part[0][inside] for inside in rows) for part in (setting.flags, setting.weight))
    return replace(setting, runs=tuple(pieces), flags=flags, weight=weight)


@dataclass(frozen=True)
class Fold:
    """Errors of nominal, refit and chosen model on the run left out, and the name of what was chosen."""

    errors: tuple[np.ndarray, ...]
    chosen: str


def leave_out(selection: Selection, parts: Setting, k: int) -> Fold:
    """Choose and fit without part k, then predict it."""
    setting = without(parts, k)
    rest = {f.hypothesis.name: f.log_evidence - log_likelihood(f, parts.runs[k]) for f in selection.named}
    ranked = sorted(selection.named, key=lambda f: -rest[f.hypothesis.name])
    leaders = [f for f in ranked[:MOST] if rest[f.hypothesis.name] > rest[ranked[0].hypothesis.name] - WITHIN]
    nominal, refit, *found = (again(setting, f, k) for f in (selection.nominal, selection.refit, *leaders))
    hopeless = [replace(f, log_evidence=-np.inf) for f in selection.named if f not in leaders]
    nothing = (Discrepancy("sensor", "", -np.inf),)
    chances = probabilities(Selection(setting, nominal, refit, (*found, *hopeless), nothing))
    best = max((nominal, refit, *found), key=lambda f: chances[f.hypothesis.name])
    target = targets_of(parts)[k]
    errors = tuple(Prediction(model_of(f), target).errors() for f in (nominal, refit, best))
    return Fold(errors, best.hypothesis.name)


def without(setting: Setting, k: int) -> Setting:
    """The setting without run k."""
    keep = [i for i in range(len(setting.runs)) if i != k]
    return replace(
        setting,
        runs=tuple(setting.runs[i] for i in keep),
        flags=tuple(setting.flags[i] for i in keep),
        weight=tuple(setting.weight[i] for i in keep),
    )


def again(setting: Setting, fit: Fitted, k: int) -> Fitted:
    """A hypothesis fitted without part k, starting from where it was with it."""
    start = fit.start()
    if len(fit.problem.runs) == 1:  # blocks: initial states of their own, a phase as in the whole run
        return evaluate(setting, fit.hypothesis, [{n: np.squeeze(v) for n, v in start.items() if n != STATES}])
    own = {*fit.problem.per_run, STATES}
    return evaluate(
        setting, fit.hypothesis, [{n: np.delete(v, k, axis=0) if n in own else v for n, v in start.items()}]
    )


def log_likelihood(fit: Fitted, part: Observed) -> float:
    """Log-likelihood of the innovations of a run, or of a block of the only one."""
    k = max((i for i, run in enumerate(fit.problem.runs) if run is part), default=0)
    time, f = fit.problem.runs[k].time_s, fit.filtered[k]
    used = fit.problem.used(k) & (time >= part.time_s[0]) & (time <= part.time_s[-1])
    return -0.5 * float(np.sum(f.innovation[used] ** 2 / f.variance[used] + np.log(2.0 * np.pi * f.variance[used])))


# --- new data ----------------------------------------------------------------------------------------------------
def resampled(folds: Sequence[Fold], floor: float, seed: int) -> list[Gaps]:
    """Gaps over runs drawn with replacement from those left out; what a foreign vehicle does besides is not known."""
    rng = np.random.default_rng(seed)
    sizes = np.array([fold.errors[0].size for fold in folds])
    squares = np.array([[np.sum(e**2) for e in fold.errors[1:]] for fold in folds])
    drawn = rng.integers(len(folds), size=(10 * DRAWS, len(folds)))
    gaps = np.sqrt(squares[drawn].sum(axis=1) / sizes[drawn].sum(axis=1)[:, None])
    return [(float(refit), float(diagnosed), floor) for refit, diagnosed in gaps]


def interval90(sets: Sequence[Gaps], closed: float | None = None) -> list[float] | None:
    """90 % interval of the fraction closed over new sets of runs, widened; None where too few have a reducible gap.

    closed: the fraction found on the runs left out, another estimate, which the interval takes in.
    """
    fractions = [f for f in (fraction_closed(*gaps) for gaps in sets) if f is not None]
    if len(fractions) < FEWEST:
        return None
    low, middle, high = np.quantile(fractions, (0.05, 0.5, 0.95))
    wide = calibration().widening
    ends = [float(middle + wide * (end - middle)) for end in (low, high)]
    return ends if closed is None else [min(ends[0], closed), max(ends[1], closed)]
