"""What simpler methods would answer from the same fits: the yardsticks beside the diagnosis.

Bayesian information criterion: Schwarz, Annals of Statistics 6 (1978). Largest correlation: after the refit, the effect
whose change of the output agrees best with what is left (Rao's score), or none of them where chance would do as well.
"""

from __future__ import annotations

import numpy as np
from scipy.special import softmax

from .evidence import Fitted
from .score import linearise, score
from .selection import Selection
from .ties import SEPARABLE


def baselines(selection: Selection) -> dict[str, dict[str, float]]:
    """Probabilities that each method would state, by method and hypothesis."""
    return {"BIC": _bic(selection), "largest correlation": {_most_correlated(selection): 1.0}}


def _bic(selection: Selection) -> dict[str, float]:
    """Every hypothesis, alike before the data, by its likelihood and number of parameters."""
    weights = softmax([-_half_bic(fit) for fit in selection.fits])
    return {fit.hypothesis.name: float(w) for fit, w in zip(selection.fits, weights, strict=True)}


def _half_bic(fit: Fitted) -> float:
    count = sum(int(np.sum(fit.problem.used(k))) for k in range(len(fit.problem.runs)))
    return 0.5 * (fit.problem.size + len(fit.extra)) * float(np.log(count)) - fit.log_likelihood


def _most_correlated(selection: Selection) -> str:
    near, setting, refit = linearise(selection.refit), selection.setting, selection.refit
    singles = (fit for fit in selection.named if len(fit.hypothesis.effects) == 1)
    gains = {fit.hypothesis.name: score(setting, near, fit, refit.log_evidence)[0] for fit in singles}
    best = max(gains, key=lambda name: gains[name], default="parameters")
    if gains.get(best, 0.0) > 0.5 * SEPARABLE**2:
        return best
    return "none" if _half_bic(selection.nominal) < _half_bic(refit) else "parameters"
