"""Ties: which rivals could have made the same recordings as the winner.

Every rival that is not hopeless is fitted to noise-free recordings made by the winner. What is left, over the noise,
is the separation: the post-refit signal-to-noise ratio of the difference between the two. Below 3 they form a class.
Eriksson, Frisk, Krysander, Automatica 49 (2013): distinguishability as Kullback-Leibler divergence, separation^2 / 2.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..effects.catalogue import BY_NAME
from .evidence import Fitted, Setting, evaluate
from .selection import Selection

SEPARABLE = 3.0  # [-] separation from which two effects are told apart: one deviation in ten thousand by chance
HOPELESS = 6.0  # log evidence behind the winner at which the data themselves have told a rival apart: odds of 1 in 400


def noise_free(setting: Setting, fit: Fitted) -> Setting:
    """The setting with recordings as the fitted model would have made them without any noise."""
    pairs = zip(setting.runs, fit.problem.simulate(fit.optimum.theta), strict=True)
    runs = tuple(replace(run, value=run.value - f.innovation) for run, f in pairs)
    clean = tuple(np.ones(run.time_s.size) for run in runs)
    return replace(setting, runs=runs, weight=clean, flags=tuple(np.zeros(run.time_s.size, bool) for run in runs))


def separation(setting: Setting, winner: Fitted, rival: Fitted) -> float:
    """How far apart, in deviations, the winner's noise-free recordings stay from the rival's best fit to them."""
    fitted = evaluate(noise_free(setting, winner), rival.hypothesis, [rival.start()])
    r = fitted.problem.residuals(fitted.optimum.theta, fitted.filtered)
    return float(np.sqrt(r @ r))


def tied_class(selection: Selection, winner: Fitted) -> tuple[str, ...]:
    """Names of the effects that cannot be told from the winner's, the winner's first."""
    names = [effect.name for effect in winner.hypothesis.effects]
    if winner.hypothesis.outliers:
        return tuple(names)
    for rival in selection.named if len(names) == 1 else ():
        name = rival.hypothesis.name
        close = rival.log_evidence > winner.log_evidence - HOPELESS
        if len(rival.hypothesis.effects) == 1 and name not in names and not rival.hypothesis.outliers and close:
            if separation(selection.setting, winner, rival) < SEPARABLE:
                names.append(name)
    for effect in winner.hypothesis.effects:
        names += [n for n in effect.confused_with if BY_NAME[n].standing == "tied" and n not in names
                  and all(f.hypothesis.name != n for f in selection.named)]  # fmt: skip
    return tuple(names)
