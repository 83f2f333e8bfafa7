"""How far the gap shrinks: nested leave-one-run-out, and what it is worth on new data.

Inside each fold the hypothesis is chosen and fitted without the run left out; then that run is predicted open loop
(`holdout.py`). The floor is what is left to a model that knows everything, on the same runs: the error of the final
model on its own data, as far as noise and turbulence can account for it.

The interval is for new data: new runs of the same experiments are simulated from what the data leave possible (other
hypotheses by their probability, parameters by their covariance, new turbulence and noise) and predicted by the
models found and by the one that made them.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from .discrepancy import Discrepancy
from .evidence import STATES, Fitted, Setting, Start, evaluate
from .holdout import Prediction, fraction_closed, model_of, rms, targets_of
from .new_data import Gaps, NewData
from .selection import Selection
from .verdict import Verdict, probabilities

WITHIN = 8.0  # log evidence behind a fold's leader up to which a hypothesis is refitted there
MOST = 4  # hypotheses refitted in a fold, beside the nominal and the refit
DRAWS = 120  # simulated sets of new runs


def shrink(selection: Selection, verdict: Verdict, seed: int = 0) -> dict[str, Any]:
    """The gap before and after on data that were not used, in the form of schema vtank.diagnosis/1."""
    new = NewData(selection, verdict)
    with ThreadPoolExecutor(2) as pool:
        folds = list(pool.map(partial(leave_out, selection), range(len(selection.setting.runs))))
        assert new.causes and new.models  # made once, before the threads share them
        sets = list(pool.map(new.new_set, [(seed, i) for i in range(DRAWS)]))
    nominal, refit, diagnosed = (rms([fold.errors[i] for fold in folds]) for i in range(3))
    floor = min(new.causes[0][1].gap(), float(np.quantile([own for _, _, own in sets], 0.95)))
    return {
        "unit": "m" if any(run.has_position for run in selection.setting.runs) else "m/s",
        "nominal": nominal,
        "refit": refit,
        "diagnosed": diagnosed,
        "floor": floor,
        "fraction_closed": fraction_closed(refit, diagnosed, floor),
        "interval90": interval90(sets),
        "chosen": [fold.chosen for fold in folds],
    }


# --- leave one run out -------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Fold:
    """Errors of nominal, refit and chosen model on the run left out, and the name of what was chosen."""

    errors: tuple[np.ndarray, ...]
    chosen: str


def leave_out(selection: Selection, k: int) -> Fold:
    """Choose and fit without run k, then predict it."""
    setting = without(selection.setting, k)
    rest = {f.hypothesis.name: f.log_evidence - log_likelihood(f, k) for f in selection.named}
    ranked = sorted(selection.named, key=lambda f: -rest[f.hypothesis.name])
    leaders = [f for f in ranked[:MOST] if rest[f.hypothesis.name] > rest[ranked[0].hypothesis.name] - WITHIN]
    nominal, refit, *found = (again(setting, f, k) for f in (selection.nominal, selection.refit, *leaders))
    hopeless = [replace(f, log_evidence=-np.inf) for f in selection.named if f not in leaders]
    nothing = (Discrepancy("sensor", "", -np.inf),)
    chances = probabilities(Selection(setting, nominal, refit, (*found, *hopeless), nothing))
    best = max((nominal, refit, *found), key=lambda f: chances[f.hypothesis.name])
    target = targets_of(selection.setting)[k]
    errors = tuple(Prediction(model_of(f), target).errors() for f in (nominal, refit, best))
    return Fold(errors, best.hypothesis.name)


def without(setting: Setting, k: int) -> Setting:
    """The setting without run k."""
    keep = [i for i in range(len(setting.runs)) if i != k]
    runs, flags, weight = (tuple(part[i] for i in keep) for part in (setting.runs, setting.flags, setting.weight))
    return replace(setting, runs=runs, flags=flags, weight=weight)


def again(setting: Setting, fit: Fitted, k: int) -> Fitted:
    """A hypothesis fitted without run k, starting from where it was with it."""
    own = {*fit.problem.per_run, STATES}
    start: Start = {n: np.delete(np.asarray(v), k, axis=0) if n in own else v for n, v in fit.start().items()}
    return evaluate(setting, fit.hypothesis, [start])


def log_likelihood(fit: Fitted, k: int) -> float:
    """Log-likelihood of run k's innovations."""
    used, f = fit.problem.used(k), fit.filtered[k]
    return -0.5 * float(np.sum(f.innovation[used] ** 2 / f.variance[used] + np.log(2.0 * np.pi * f.variance[used])))


def interval90(sets: list[Gaps]) -> list[float] | None:
    """90 % interval of the fraction closed over sets of new runs."""
    fractions = [f for f in (fraction_closed(*gaps) for gaps in sets) if f is not None]
    if len(fractions) < len(sets) / 2:
        return None
    low, high = np.quantile(fractions, (0.05, 0.95))
    return [float(low), float(high)]
