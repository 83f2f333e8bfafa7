"""From evidence to probabilities, and from probabilities to a verdict in plain words."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .evidence import Fitted
from .prior import calibration, log_prior, weight
from .selection import Selection
from .ties import SEPARABLE, separation, tied_class

NAMED = 0.5  # probability that the winner's class must have for a verdict; below it the answer is "undecided"


@dataclass(frozen=True)
class Verdict:
    """What the diagnosis says.

    Attributes:
        kind: none, parameters, effect, effects, unknown or undecided.
        effects: the effects named, most probable first.
        rivals: effects this data cannot separate from the winner, the winner included.
        channel: hydrodynamics, actuator, sensor or None.
        probability: of the verdict's class, or of the kind.
        fit: the explanation that goes with it.
    """

    kind: str
    effects: tuple[str, ...]
    rivals: tuple[str, ...]
    channel: str | None
    probability: float
    fit: Fitted = field(repr=False)

    def document(self) -> dict[str, Any]:
        """As plain data."""
        said = {"kind": self.kind, "effects": list(self.effects), "class": list(self.rivals)}
        return said | {"channel": self.channel, "probability": self.probability}


def probabilities(selection: Selection, tempering: float | None = None) -> dict[str, float]:
    """Posterior probability of every hypothesis; names of pairs are joined by `+`."""
    fits = selection.fits
    before = {f.hypothesis.name: float(np.exp(log_prior(f, selection.singles))) for f in fits}
    before["unknown"] = calibration().prior["unknown"]
    logits = {f.hypothesis.name: weight(f, selection.singles, tempering) for f in fits}
    logits["unknown"] = logits[selection.best.hypothesis.name] + np.logaddexp(*unknown_odds(selection))
    top = max(logits.values())
    weights = {name: float(np.exp(value - top)) for name, value in logits.items()} if np.isfinite(top) else before
    total, doubt, whole = sum(weights.values()), calibration().doubt, sum(before.values())
    return {name: (1.0 - doubt) * w / total + doubt * before[name] / whole for name, w in weights.items()}


def unknown_odds(selection: Selection) -> tuple[float, float]:
    """Log odds, over the best explanation, of a cause without a name that leaves traces, and of one that mimics it."""
    frozen = calibration()
    gain = float(np.logaddexp.reduce([d.gain for d in selection.unnamed]) - np.log(len(selection.unnamed)))
    if selection.setting.foreign:  # no model is complete: what has no name counts as far as it exceeds what has one
        gain -= selection.best.log_evidence - selection.refit.log_evidence
    mimic = float(np.log(frozen.mimicry)) if selection.best is not selection.nominal else -np.inf
    return gain + float(np.log(frozen.prior["unknown"])), mimic


def decide(selection: Selection, chances: dict[str, float]) -> Verdict:
    """The verdict: the most probable hypothesis with all it cannot be told from, or that none is probable enough.

    An effect so small that the refit alone would explain its recordings as well is left undecided.
    """
    leader = max(chances, key=lambda name: chances[name])
    if leader in ("none", "parameters"):
        fit = selection.nominal if leader == "none" else selection.refit
        return Verdict(leader if chances[leader] >= NAMED else "undecided", (), (), None, chances[leader], fit)
    if leader == "unknown":
        family = max(selection.unnamed, key=lambda d: d.gain)
        kind = "unknown" if chances["unknown"] >= NAMED else "undecided"
        return Verdict(kind, (), (), family.channel, chances["unknown"], selection.best)
    fit = next(f for f in selection.named if f.hypothesis.name == leader)
    effects = fit.hypothesis.effects
    rivals = tied_class(selection, fit)
    kind, probability = "effects", chances[leader]
    if len(effects) == 1:
        kind, probability = "effect", sum(chances.get(name, 0.0) for name in rivals)
    seen = fit.hypothesis.outliers or separation(selection.setting, fit, selection.refit) >= SEPARABLE
    if probability < NAMED or not seen:
        kind = "undecided"
    return Verdict(kind, tuple(e.name for e in effects), rivals, effects[0].channel, probability, fit)
