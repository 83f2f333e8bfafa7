"""Vehicles without a nominal simulator: recordings made by others, at any rate and in any unit of input.

Their simulator is the recording's own refit of Model I. It lacks so much that more than two effects may be needed, and
that the noise level cannot be judged before the greater part of them is named: hypotheses grow by one effect at a time,
and the noise level is settled again each time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..estimate.maximum_likelihood import identify
from ..estimate.observed import Observed
from ..plant.parameters import vector
from .discrepancy import unnamed
from .evidence import Fitted, Setting, Start
from .holdout import Prediction, predictor, rms, targets_of
from .hypothesis import Hypothesis
from .noise_floor import settle
from .score import linearise, score
from .selection import PAIR_GAIN, Selection, weigh_all

SHORTEST_S = 0.02  # [s] period below which recordings are thinned: vehicles and drives answer more slowly; a choice
MOST_SAMPLES = 3000  # of all runs together, for the time it takes; a choice
TRIED = 4  # effects that are tried on top of the best hypothesis
LARGEST = 4  # effects of a hypothesis at most
NEARER = 0.8  # an effect worth naming beside others takes a fifth off the simulation error; a choice


def nominal_of(runs: Sequence[Observed]) -> np.ndarray:
    """Parameter vector of the recording's own refit of Model I, shape (P,)."""
    refit = identify(runs, "I", process_noise=False).vector()
    return vector({"linear_input": float(runs[0].input_name == "thrust_N")}, refit)


def thinned(runs: Sequence[Observed]) -> tuple[Observed, ...]:
    """The runs at a period of at least SHORTEST_S, and of so many samples as are needed."""
    length = sum(float(run.time_s[-1] - run.time_s[0]) for run in runs)
    period = max(SHORTEST_S, length / MOST_SAMPLES)
    return tuple(thin(run, period) for run in runs)


def thin(run: Observed, period: float) -> Observed:
    """The run on an even grid of stamps where it is faster: inputs averaged from stamp to stamp, measurements picked.

    Between its samples the input is taken to be straight: at a high rate it is the record of a smooth signal.
    """
    if float(np.median(np.diff(run.input_time_s))) > 0.75 * period:
        return run
    edges = np.arange(run.time_s[0], run.time_s[-1] + period, period)
    steps = 0.5 * (run.input[1:] + run.input[:-1]) * np.diff(run.input_time_s)
    total = np.interp(edges, run.input_time_s, np.concatenate([[0.0], np.cumsum(steps)]))
    keep = np.zeros(run.time_s.size, dtype=bool)
    for kind in run.first:
        own = np.flatnonzero(run.kind == kind)
        keep[own[np.unique(np.searchsorted(run.time_s[own], edges[:-1] - 1e-6).clip(max=own.size - 1))]] = True
    seen = replace(run, time_s=run.time_s[keep], value=run.value[keep], kind=run.kind[keep])
    return replace(seen, input_time_s=edges[:-1], input=np.diff(total) / period)


def grow(selection: Selection, say: Callable[[str], None] = lambda text: None) -> Selection:
    """The selection with effects added to the best hypothesis for as long as they gain evidence."""
    while len(selection.best.hypothesis.effects) < LARGEST:
        say(f"on top of {selection.best.hypothesis.name}")
        selection = _settled(selection)
        more = _more(selection)
        found = weigh_all(selection.setting, [h for h, _ in more], [[start] for _, start in more])
        best, before = selection.best, gap(selection.setting, selection.best)
        found = [f for f in found if gap(selection.setting, f) < NEARER * before]
        selection = replace(selection, named=tuple(sorted([*selection.named, *found], key=lambda f: -f.log_evidence)))
        if selection.best.log_evidence < best.log_evidence + PAIR_GAIN:
            break
    return replace(selection, unnamed=tuple(unnamed(selection.setting, selection.best)))


def gap(setting: Setting, fit: Fitted) -> float:
    """Simulation error of a hypothesis after the start windows, at the parameters that predict [m or m/s]."""
    model = predictor(setting, fit)
    return rms([Prediction(model, target).errors() for target in targets_of(setting)])


def _settled(selection: Selection) -> Selection:
    """Everything weighed again at the noise level of the best hypothesis."""
    setting = settle(selection.setting, [selection.best])
    fits = selection.fits
    nominal, refit, *named = weigh_all(setting, [f.hypothesis for f in fits], [[f.start()] for f in fits])
    named.sort(key=lambda f: -f.log_evidence)
    return replace(selection, setting=setting, nominal=nominal, refit=refit, named=tuple(named))


def _more(selection: Selection) -> list[tuple[Hypothesis, Start]]:
    """The best hypothesis with one more effect, of the most promising ones, and first guesses."""
    best, near = selection.best, linearise(selection.best)
    known = {frozenset(e.name for e in f.hypothesis.effects) for f in selection.named}
    found = []
    for single in (f for f in selection.named if len(f.hypothesis.effects) == 1):
        hypothesis = Hypothesis((*best.hypothesis.effects, *single.hypothesis.effects))
        names = frozenset(e.name for e in hypothesis.effects)
        if len(names) == len(hypothesis.effects) and names not in known:
            promise = score(selection.setting, near, single, selection.refit.log_evidence)
            found.append((promise, hypothesis, {**single.start(), **best.start()}))
    promising = sorted((f for f in found if f[0] > PAIR_GAIN), key=lambda f: -f[0])
    return [(hypothesis, start) for _, hypothesis, start in promising[:TRIED]]
