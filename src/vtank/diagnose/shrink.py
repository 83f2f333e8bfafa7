"""How far the gap shrinks: nested leave-one-run-out, and what it is worth on new data.

Inside each fold the hypothesis is chosen and fitted without the run left out (of a single run: a block of time); then
that run is predicted open loop (`holdout.py`). The floor is what is left on the same runs to a model that knows
everything: the error of the most probable cause on its own data, as far as noise and turbulence can account for it.
The interval is for the fraction closed when all runs are made once more (`new_data.py`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from ..estimate.observed import Observed
from ..estimate.problem import FLAGGED
from .evidence import STATES, Fitted, Setting, evaluate
from .holdout import Prediction, fraction_closed, held, model_of, rms, targets_of
from .new_data import Gaps, NewData
from .prior import calibration
from .selection import Selection
from .verdict import Verdict, probabilities

WITHIN = 8.0  # log evidence behind a fold's leader up to which a hypothesis is refitted there
MOST = 4  # hypotheses refitted in a fold, beside the nominal and the refit
DRAWS, TOGETHER = 120, 30  # simulated sets of new runs, and how many at a time
FEWEST_PARTS = 4  # runs, or blocks of time where there are fewer runs, that are left out in turn; a choice
FEWEST = 40  # sets with a gap to close that an interval needs


def shrink(selection: Selection, verdict: Verdict, seed: int = 0, found: LeftOut | None = None) -> dict[str, Any]:
    """The gap before and after on data that were not used; found: parts left out, where they are known already."""
    new, found = NewData(selection, verdict), found or left_out(selection, verdict)
    folds, parts = found.folds, found.parts
    nominal, refit, diagnosed = (rms([fold.errors[i] for fold in folds]) for i in range(3))
    with ThreadPoolExecutor(2) as pool:
        floor = new.floor()
        closed = fraction_closed(refit, diagnosed, floor) if verdict.kind not in ("none", "parameters") else None
        sets: list[Gaps] = []
        if closed is not None and selection.setting.foreign:
            sets = resampled(folds, floor, seed)
        elif closed is not None:
            seeds = [(seed, i) for i in range(DRAWS)]
            sets = [*chain(*pool.map(new.new_sets, [seeds[i : i + TOGETHER] for i in range(0, DRAWS, TOGETHER)]))]
    return {
        "unit": "m" if any(run.has_position for run in parts.setting.runs) else "m/s",
        "nominal": nominal,
        "refit": refit,
        "diagnosed": diagnosed,
        "floor": floor,
        "fraction_closed": closed,
        "interval90": interval90(sets, closed),
        "left_out": [run.name for run in parts.setting.runs],
        "chosen": [fold.chosen for fold in folds],
    }


# --- leave one run out -------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Parts:
    """What is left out in turn: runs, or blocks of time of few runs, with starts of their own.

    Attributes:
        setting: the parts in the place of runs.
        parent: index of the run that each part is of.
        rows: measurements of each part among those of all runs, shapes (sum M,) of bool.
        source: the runs themselves.
    """

    setting: Setting
    parent: tuple[int, ...]
    rows: tuple[np.ndarray, ...]
    source: Setting

    @property
    def whole(self) -> bool:
        """Whether the parts are the runs."""
        return len(set(self.parent)) == len(self.parent)

    def inside(self, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Which inputs and which measurements of its run a part is, shapes (I,) and (M,) of bool."""
        parent, runs = self.parent[k], self.source.runs
        first = sum(run.time_s.size for run in runs[:parent])
        fed = np.isin(runs[parent].input_time_s, self.setting.runs[k].input_time_s)
        return fed, self.rows[k][first : first + runs[parent].time_s.size]

    def without(self, k: int) -> Setting:
        """What is left to fit: all other runs, or all measurements but those of a block, whose run goes on without."""
        parent, source = self.parent[k], self.source
        if self.whole:
            return without(source, parent)
        weight = list(source.weight)
        weight[parent] = np.where(self.inside(k)[1], FLAGGED, weight[parent])
        return replace(source, weight=tuple(weight))


def parts_of(setting: Setting, blocks: bool = False) -> Parts:
    """The runs where there are enough of them, else even blocks of time; blocks: of time in any case."""
    count = max(-(-FEWEST_PARTS // len(setting.runs)), 1 + blocks)
    cuts = [piece for k, run in enumerate(setting.runs) for piece in _cut(run, k, count)]
    size = np.cumsum([0] + [run.time_s.size for run in setting.runs])
    rows = []
    for k, inside, _ in cuts:
        rows.append(np.zeros(size[-1], bool))
        rows[-1][size[k] : size[k + 1]] = inside
    flags, weight = (tuple(part[k][inside] for k, inside, _ in cuts) for part in (setting.flags, setting.weight))
    runs = tuple(run for _, _, run in cuts)
    parts = replace(setting, runs=runs, flags=flags, weight=weight)
    return Parts(parts, tuple(k for k, _, _ in cuts), tuple(rows), setting)


def _cut(run: Observed, k: int, count: int) -> Iterator[tuple[int, np.ndarray, Observed]]:
    """Even blocks of a run: its index, its measurements in the block, and the block."""
    if count == 1:
        yield k, np.ones(run.time_s.size, bool), run
        return
    edges = np.linspace(run.time_s[0], run.time_s[-1], count + 1)
    for i in range(count):
        inside = (run.time_s >= edges[i]) & ((run.time_s < edges[i + 1]) | (i == count - 1))
        if not inside.any():
            continue  # nothing was measured for so long
        first = max(int(np.searchsorted(run.input_time_s, edges[i], "right")) - 1, 0)
        fed = slice(first, int(np.searchsorted(run.input_time_s, edges[i + 1], "right")))
        name = f"{run.name}, {edges[i]:.4g} to {edges[i + 1]:.4g} s"
        yield k, inside, replace(run, name=name, input_time_s=run.input_time_s[fed], input=run.input[fed],
                                 time_s=run.time_s[inside], value=run.value[inside], kind=run.kind[inside],
                                 lone=run.lone[fed])  # fmt: skip


@dataclass(frozen=True)
class Fold:
    """A part that was left out, and predicted by models fitted without it.

    Attributes:
        errors: of nominal, refit and chosen model, shapes (K,) [m or m/s].
        chosen: name of what was chosen without the part.
        chain: the models that lead from the nominal to the verdict's, entering the part.
    """

    errors: tuple[np.ndarray, ...]
    chosen: str
    chain: tuple[Prediction, ...] = ()


@dataclass(frozen=True)
class LeftOut:
    """All parts, left out in turn; chain: the models that lead from the nominal to the verdict's."""

    parts: Parts
    chain: tuple[Fitted, ...]
    folds: tuple[Fold, ...]


def left_out(selection: Selection, verdict: Verdict) -> LeftOut:
    """Leave out every part in turn; what a run has for itself is only told by its other blocks."""
    chain = chain_of(selection, verdict)
    parts = parts_of(selection.setting, blocks=bool(chain[-1].hypothesis.varying))
    with ThreadPoolExecutor(2) as pool:
        folds = pool.map(partial(leave_out, selection, parts, chain=chain), range(len(parts.parent)))
        return LeftOut(parts, chain, tuple(folds))


def chain_of(selection: Selection, verdict: Verdict) -> tuple[Fitted, ...]:
    """Nominal, refit, the named effects one after the other as far as they were fitted alone, and the verdict's fit.

    Where own parameters vary, the model that has them for every run comes last.
    """
    known = {frozenset(e.name for e in f.hypothesis.effects): f for f in selection.named}
    sets = [frozenset(verdict.effects[: i + 1]) for i in range(len(verdict.effects) - 1)]
    between = [known[names] for names in sets if names in known]
    before = selection.refit if selection.setting.foreign else selection.nominal  # its own refit is all there is
    last = [verdict.fit] if verdict.fit.hypothesis.effects else []
    if verdict.kind == "varying":
        last = [free.fit for free in selection.free if free.fit.hypothesis.varying]
    return (before, selection.refit, *between, *last)


def leave_out(selection: Selection, parts: Parts, k: int, chain: Sequence[Fitted] = ()) -> Fold:
    """Choose and fit without part k, then predict it; chain: models that predict it besides."""
    setting = parts.without(k)
    rest = {f.hypothesis.name: f.log_evidence - log_likelihood(f, parts, k) for f in selection.named}
    ranked = sorted(selection.named, key=lambda f: -rest[f.hypothesis.name])
    leaders = [f for f in ranked[:MOST] if rest[f.hypothesis.name] > rest[ranked[0].hypothesis.name] - WITHIN]
    tried = (selection.nominal, selection.refit, *leaders)
    nominal, refit, *found = fits = [again(setting, f, parts, k) for f in tried]
    hopeless = [replace(f, log_evidence=-np.inf) for f in selection.named if f not in leaders]
    chances = probabilities(Selection(setting, nominal, refit, (*found, *hopeless)))
    best = max((nominal, refit, *found), key=lambda f: chances[f.hypothesis.name])
    target = targets_of(parts.setting)[k]
    fitted = {f.hypothesis.name: f for f in fits}
    fitted |= {f.hypothesis.name: again(setting, f, parts, k) for f in chain if f.hypothesis.name not in fitted}
    wanted = {f.hypothesis.name: fitted[f.hypothesis.name] for f in (nominal, refit, best, *chain)}
    run = 0 if parts.whole else parts.parent[k]
    entered = {name: Prediction(model_of(f, run), target) for name, f in wanted.items()}
    three = tuple(entered[f.hypothesis.name].errors() for f in (nominal, refit, best))
    return Fold(three, best.hypothesis.name, tuple(entered[f.hypothesis.name] for f in chain))


def without(setting: Setting, k: int) -> Setting:
    """The setting without run k."""
    keep = [i for i in range(len(setting.runs)) if i != k]
    return replace(
        setting,
        runs=tuple(setting.runs[i] for i in keep),
        flags=tuple(setting.flags[i] for i in keep),
        weight=tuple(setting.weight[i] for i in keep),
    )


def again(setting: Setting, fit: Fitted, parts: Parts, k: int) -> Fitted:
    """A hypothesis fitted without part k, starting from where it was with it."""
    start, own = fit.start(), {*fit.problem.per_run, STATES}
    if parts.whole:
        start = {n: np.delete(v, parts.parent[k], axis=0) if n in own else v for n, v in start.items()}
    return evaluate(setting, fit.hypothesis, [start])


def log_likelihood(fit: Fitted, parts: Parts, k: int) -> float:
    """Log-likelihood of the innovations of a part."""
    run = parts.parent[k]
    f, first = fit.filtered[run], sum(f.innovation.size for f in fit.filtered[:run])
    used = fit.problem.used(run) & parts.rows[k][first : first + f.innovation.size]
    e, S = held(f.innovation[used]), f.variance[used]  # a simulation may have run away
    return -0.5 * float(np.sum(e**2 / S + np.log(2.0 * np.pi * S)))


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
