"""Vehicles without a nominal simulator: recordings made by others, at any rate and in any unit of input.

Their simulator is the recording's own refit of Model I. It lacks so much that more than two effects may be needed, and
that the noise level cannot be judged before the greater part of them is named: hypotheses grow by one effect at a time,
and the noise level is settled again each time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ..estimate.maximum_likelihood import identify
from ..estimate.observed import Observed
from ..plant.parameters import vector
from .evidence import Fitted, Setting, Start
from .holdout import Prediction, model_of, rms, targets_of
from .hypothesis import Hypothesis
from .noise_floor import settle
from .score import linearise, score
from .selection import PAIR_GAIN, Selection, prepare, select, weigh_all, with_nameless
from .thinning import FOREIGN_SAMPLES, straightened, thinned

TRIED = 4  # effects that are tried on top of the best hypothesis
LARGEST = 4  # effects of a hypothesis at most
NEARER = 0.8  # an effect worth naming beside others takes a fifth off the simulation error; a choice
LINEAR_SHARE = {"thrust_N": 1.0, "command": 0.5}  # by input; a command's is not known, and the recordings decide


def explained(
    runs: Sequence[Observed], names: Sequence[str] | None = None, say: Callable[[str], None] = lambda text: None
) -> Selection:
    """All hypotheses about runs without a nominal, weighed; names: the effects to consider (default: the catalogue).

    A command, and a speed that a governor sets, are held. A measured force is held, or the record of a smooth one:
    it is what is explained better. Averages will do: to the micrometres that an encoder tells, laws without a nominal
    are not known (dry friction turns round over a speed that is a guess).
    """
    held = grow(select(_setting(thinned(runs, FOREIGN_SAMPLES, levels=1)), names, say), say)
    if runs[0].input_name != "thrust_N":
        return held
    say("the same, with a force that goes straight from sample to sample")
    smooth = thinned([straightened(run) for run in runs], FOREIGN_SAMPLES, levels=1)
    straight = grow(select(_setting(smooth), names, say), say)
    return straight if straight.best.log_evidence > held.best.log_evidence + PAIR_GAIN else held


def _setting(runs: Sequence[Observed]) -> Setting:
    """The runs with their nominal, in which a linear share that is not known stands between 0 and 1."""
    refit = identify(runs, "I", process_noise=False).vector()
    return prepare(runs, vector({"linear_input": LINEAR_SHARE.get(runs[0].input_name, 0.0)}, refit), foreign=True)


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
    return with_nameless(selection)


def gap(setting: Setting, fit: Fitted) -> float:
    """Simulation error of a hypothesis after the start windows, no disturbance carried over from there [m or m/s]."""
    quiet = setting.with_noise(setting.noise.calm())
    return rms([Prediction(model_of(fit), target).errors() for target in targets_of(quiet)])


def _settled(selection: Selection) -> Selection:
    """Everything weighed again at the noise level of the best hypothesis."""
    setting, _ = settle(selection.setting, [selection.best])
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
            gain, start = score(selection.setting, near, single, selection.refit.log_evidence)
            found.append((gain, hypothesis, {**single.start(), **start, **best.start()}))
    promising = sorted((f for f in found if f[0] > PAIR_GAIN), key=lambda f: -f[0])
    return [(hypothesis, start) for _, hypothesis, start in promising[:TRIED]]
