"""Vehicles without a nominal simulator: recordings made by others, at any rate and in any unit of input.

Their simulator is the recording's own refit of Model I. It lacks so much that more than two effects may be needed, and
that the noise level cannot be judged before the greater part of them is named: hypotheses grow by one effect at a time,
and the noise level is settled again each time. What is missing still may pass for a disturbance; runs left out tell.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from ..estimate.maximum_likelihood import identify
from ..estimate.observed import Observed
from ..estimate.problem import FLAGGED
from ..plant.parameters import vector
from .discrepancy import unnamed
from .evidence import Fitted, Setting, Start, evaluate
from .holdout import Prediction, model_of, rms, targets_of
from .hypothesis import Hypothesis
from .noise_floor import noise_at, settle
from .score import linearise, score
from .selection import PAIR_GAIN, Selection, prepare, weigh_all
from .shrink import again, without
from .thinning import FOREIGN_SAMPLES, straightened, thinned

TRIED = 4  # effects that are tried on top of the best hypothesis
LARGEST = 4  # effects of a hypothesis at most
NEARER = 0.8  # an effect worth naming beside others takes a fifth off the simulation error; a choice
FEWEST_RUNS = 4  # from which runs left out tell what repeats; a choice
CLEARLY = 2.0  # [-] mean gain over its standard error from which one way to fit predicts better; a convention
ROUNDS = 2  # alternations of a fit and the size of what it leaves
LINEAR_SHARE = {"thrust_N": 1.0, "command": 0.5}  # by input; a command's is not known, and the recordings decide


def prepared(runs: Sequence[Observed]) -> Setting:
    """Thinned runs and their own refit of Model I; a measured force is held or straight, as it is followed better."""
    held = _setting(thinned(runs, FOREIGN_SAMPLES))
    if runs[0].input_name != "thrust_N":  # commands, and speeds that a governor sets, are held
        return held
    straight = _setting(thinned([straightened(run) for run in runs], FOREIGN_SAMPLES))
    return straight if _followed(straight) > _followed(held) + PAIR_GAIN else held


def _setting(runs: Sequence[Observed]) -> Setting:
    """The runs with their nominal, in which a linear share that is not known stands between 0 and 1."""
    refit = identify(runs, "I", process_noise=False).vector()
    return prepare(runs, vector({"linear_input": LINEAR_SHARE.get(runs[0].input_name, 0.0)}, refit), foreign=True)


def _followed(setting: Setting) -> float:
    """Log-likelihood of the refit at the noise level it prefers."""
    refit = evaluate(setting, Hypothesis())
    level = setting.with_noise(noise_at(refit.problem, refit.optimum.theta))
    return evaluate(level, Hypothesis(), [refit.start()]).log_likelihood


def grow(selection: Selection, say: Callable[[str], None] = lambda text: None) -> Selection:
    """The selection with effects added to the best hypothesis for as long as they gain evidence.

    Where the best explanation predicts runs left out better once nothing is put down to a disturbance, all are weighed
    without one: the fit that is reported is the fit that predicts.
    """
    selection = _grown(selection, say, lambda found: settle(found.setting, [found.best]))
    if len(selection.setting.runs) >= FEWEST_RUNS:
        say("without a disturbance")
        quiet = undisturbed(selection.setting, selection.best)
        if _predicts_better(selection.best, quiet, selection.setting):
            selection = _grown(selection, say, lambda found: quiet)
    return replace(selection, unnamed=tuple(unnamed(selection.setting, selection.best)))


def _grown(selection: Selection, say: Callable[[str], None], level: Callable[[Selection], Setting]) -> Selection:
    """The selection grown at the noise `level` of the best hypothesis."""
    selection = _weighed_again(selection, level(selection))
    while len(selection.best.hypothesis.effects) < LARGEST:
        say(f"on top of {selection.best.hypothesis.name}")
        more = _more(selection)
        found = weigh_all(selection.setting, [h for h, _ in more], [[start] for _, start in more])
        best, before = selection.best, gap(selection.setting, selection.best)
        found = [f for f in found if gap(selection.setting, f) < NEARER * before]
        selection = replace(selection, named=tuple(sorted([*selection.named, *found], key=lambda f: -f.log_evidence)))
        if selection.best.log_evidence < best.log_evidence + PAIR_GAIN:
            break
        selection = _weighed_again(selection, level(selection))
    return selection


def gap(setting: Setting, fit: Fitted) -> float:
    """Simulation error of a hypothesis after the start windows [m or m/s]."""
    return rms([Prediction(model_of(fit), target).errors() for target in targets_of(setting)])


def undisturbed(setting: Setting, fit: Fitted) -> Setting:
    """The setting without a disturbance: all that the simulation misses is error of the measurements.

    Their weights carry it, and the noise stays that of the sensor. What goes together in it counts once, so that
    evidence is not claimed for the same error again and again.
    """
    quiet = setting.with_noise(setting.noise.calm())
    for _ in range(ROUNDS):
        parts = zip(fit.problem.simulate(fit.optimum.theta), setting.runs, setting.flags, strict=True)
        left = [f.innovation[~flag] / np.sqrt(np.array(quiet.noise.variance)[run.kind[~flag]])
                for f, run, flag in parts]  # fmt: skip
        size = max(rms(left) ** 2 * _together(left), 1.0)
        quiet = replace(quiet, weight=tuple(np.where(flag, FLAGGED, size) for flag in setting.flags))
        fit = evaluate(quiet, fit.hypothesis, [fit.start()])
    return quiet


def _together(errors: Sequence[np.ndarray]) -> float:
    """Samples that go together: twice the sum of the autocorrelation up to its first zero, less one."""
    longest = max(e.size for e in errors)
    total = np.zeros(longest)
    for e in errors:
        spectrum = np.fft.rfft(e, 2 * e.size)
        total[: e.size] += np.fft.irfft(np.abs(spectrum) ** 2)[: e.size]
    total /= total[0] or 1.0
    return float(2.0 * np.sum(total[: np.argmax(total <= 0.0) or longest]) - 1.0)


def _predicts_better(fit: Fitted, quiet: Setting, setting: Setting) -> bool:
    """Whether a hypothesis, fitted without a run, predicts it clearly better in the quiet setting than in the other."""
    targets, start = targets_of(setting), evaluate(quiet, fit.hypothesis, [fit.start()])

    def gain(k: int) -> float:
        found = [again(without(s, k), f, k) for s, f in ((quiet, start), (setting, fit))]
        calm, other = (rms([Prediction(model_of(f), targets[k]).errors()]) for f in found)
        return float(np.log(other / calm))

    with ThreadPoolExecutor(2) as pool:
        gains = np.array(list(pool.map(gain, range(len(setting.runs)))))
    return bool(np.mean(gains) > CLEARLY * np.std(gains, ddof=1) / np.sqrt(gains.size))


def _weighed_again(selection: Selection, setting: Setting) -> Selection:
    """Everything weighed again in another setting."""
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
