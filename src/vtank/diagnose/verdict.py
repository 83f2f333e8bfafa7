"""From evidence to probabilities, and from probabilities to a verdict in plain words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import log
from typing import Any

import numpy as np

from .evidence import Fitted
from .freeform.dictionary import SWINGING
from .imitation import IMPERFECT, imitating
from .noise_floor import plausible, rarity
from .prior import calibration, log_prior, weight
from .selection import Selection
from .ties import SEPARABLE, separation, tied_class

BEYOND_CHANCE = 4.6  # log evidence that noise alone feigns in one of a hundred cases at most (Markov's inequality)
SWINGS = 0.1  # prior odds that the noise of a sonar swings in a band; a guess
COMMON = 0.8  # probability of sets that have effects in common from which these are named; a choice
NAMED = 0.5  # probability that the winner's class must have for a verdict; below it the answer is "undecided"


@dataclass(frozen=True)
class Verdict:
    """What the diagnosis says.

    Attributes:
        kind: none, parameters, effect, effects, varying, unknown or undecided.
        effects: the effects named, most probable first.
        rivals: effects this data cannot separate from the winner, the winner included.
        channel: hydrodynamics, actuator, sensor or None.
        probability: of the verdict's class, or of the kind.
        fit: the explanation that goes with it.
        varying: own parameters that differ from run to run.
        doubt: why it is undecided, where the gap budget says so (`judged.py`): worse, repeats, disturbance or unseen;
            or, beside effects that are named: "beside", where what else acts is not decided.
    """

    kind: str
    effects: tuple[str, ...]
    rivals: tuple[str, ...]
    channel: str | None
    probability: float
    fit: Fitted = field(repr=False)
    varying: tuple[str, ...] = ()
    doubt: str = ""

    def document(self) -> dict[str, Any]:
        """As plain data."""
        said = {"kind": self.kind, "effects": list(self.effects), "class": list(self.rivals)}
        said |= {"varying": list(self.varying), "doubt": self.doubt}
        return said | {"channel": self.channel, "probability": self.probability}


def probabilities(selection: Selection) -> dict[str, float]:
    """Posterior probability of every hypothesis; names of sets are joined by `+`.

    What is too small to be told from simpler explanations counts as these: an effect as the refit alone, own parameters
    as none that are off.
    """
    fits, frozen = selection.fits, calibration()
    before = {f.hypothesis.name: float(np.exp(log_prior(f, selection.singles))) for f in fits}
    logits = {f.hypothesis.name: weight(f, selection.singles) for f in fits}
    for kind, gains in nameless_gains(selection).items():
        before[kind] = frozen.prior[kind]
        logits[kind] = float(np.logaddexp.reduce(gains)) + float(np.log(frozen.prior[kind]))
    for name, gain in _by_noise(selection).items():
        logits[name] += gain
    top = max(logits.values())
    weights = {name: float(np.exp(value - top)) for name, value in logits.items()} if np.isfinite(top) else before
    best = max((f.hypothesis.name for f in fits), key=lambda name: logits[name])
    for small, simpler in (*_invisible(selection), *_by_chance(selection, logits)):
        weights[simpler] += weights[small]
        weights[small] = 0.0
        best = simpler if best == small else best
    weights["unknown"] += imitated(selection, best) * weights[best]
    total, doubt, whole = sum(weights.values()), frozen.doubt, sum(before.values())
    return {name: (1.0 - doubt) * w / total + doubt * before[name] / whole for name, w in weights.items()}


def _invisible(selection: Selection) -> Iterator[tuple[str, str]]:
    """Hypotheses too small to be seen beside simpler ones, by their gain of likelihood, and these; effects first."""
    nominal, refit, least = selection.nominal, selection.refit, 0.5 * SEPARABLE**2
    for fit in selection.named:
        alone = len(fit.hypothesis.effects) == 1 and not fit.hypothesis.outliers
        if alone and fit.log_likelihood - refit.log_likelihood < least:
            yield fit.hypothesis.name, "parameters"
    if refit.log_likelihood - nominal.log_likelihood < least:
        yield "parameters", "none"


def _by_chance(selection: Selection, logits: dict[str, float]) -> Iterator[tuple[str, str]]:
    """What has no name, or varies, and gains no more on nominal and refit than noise may, and the likelier of these."""
    plain = {f.hypothesis.name: f.log_evidence for f in (selection.nominal, selection.refit)}
    simpler = max(plain, key=lambda name: plain[name])
    for kind in ("unknown", "varying"):
        if logits[kind] - log(calibration().prior[kind]) - plain[simpler] < BEYOND_CHANCE:
            yield kind, simpler


def cause_set(chances: dict[str, float]) -> tuple[str, ...]:
    """Fewest explanations that hold the true one in at least 95 % of all cases, the most probable first.

    As many as it takes to reach the probability that, on open trials, was enough to hold the true one that often
    (split conformal prediction: Angelopoulos, Bates, Foundations and Trends in Machine Learning 16 (2023)).
    """
    ranked, total, out = sorted(chances, key=lambda name: -chances[name]), 0.0, []
    for name in ranked:
        out.append(name)
        total += chances[name]
        if total >= calibration().conformal:
            break
    return tuple(out)


def nameless_gains(selection: Selection) -> dict[str, list[float]]:
    """Log evidence of own parameters that vary, and of a cause without a name, on top of each base, but for a prior.

    A law of the catalogue is but an approximation, to whose form a hundredth of what it explains may be due.
    """
    frozen, refit, foreign = calibration(), selection.refit, selection.setting.foreign
    out: dict[str, list[float]] = {"varying": [-np.inf], "unknown": [-np.inf]}
    for free in selection.free:
        fit, base = free.fit, weight(free.fit, selection.singles)
        if fit is refit or fit is selection.nominal:
            base -= log_prior(fit, selection.singles)  # own parameters are part of it in any case
        if fit.hypothesis.varying:
            out["varying"].append(base - log(frozen.prior["varying"]))
        if not free.own and (fit is selection.best or not foreign):
            explained = max(fit.log_evidence - refit.log_evidence, 0.0) if fit.hypothesis.effects else 0.0
            form = explained if foreign else IMPERFECT * explained
            out["unknown"].append(
                base
                + max(min(free.gain, free.pitching) - form, -np.inf if fit.hypothesis.effects else _strange(selection))
            )
    return out


def _by_noise(selection: Selection) -> dict[str, float]:
    """Log evidence that noise of another kind adds to explanations, by name, beside which what has no name was sought.

    Uneven water; and a sonar that swings in a band, which is a cause to one and noise to another: no more beside the
    simulator as it is than beside own parameters, as the cause is sought.
    """
    found, exact = dict[str, float](), max(selection.nominal.log_evidence - selection.refit.log_evidence, 0.0)
    for free in selection.free:
        swinging = bool(free.components) and all(c.about == SWINGING for c in free.components)
        swings = min(free.gain, free.pitching) + log(SWINGS) if swinging else 0.0
        name = free.fit.hypothesis.name
        if not free.fit.hypothesis.varying:
            found[name] = max(free.uneven, swings)
        if free.fit is selection.refit:
            found["none"] = max(free.uneven, swings - exact)
    return found


def imitated(selection: Selection, best: str) -> float:
    """Odds that the best explanation imitates a cause without a name, which then leaves nothing beside it.

    What is missing is as likely without a name as with one.
    """
    if best in ("none", "parameters"):
        return calibration().mimicry if best == "parameters" else 0.0
    return imitating(float(np.sqrt(2.0 * max(selection.best.log_evidence - selection.refit.log_evidence, 0.0))))


def _strange(selection: Selection) -> float:
    """Log evidence that a disturbance beyond what water does is a cause, where none is named; there is none within."""
    setting = selection.setting
    if setting.foreign or plausible(setting.noise, setting.usual):
        return -np.inf
    return -rarity(setting.noise, setting.usual) - 1.0


def decide(selection: Selection, chances: dict[str, float]) -> Verdict:
    """The verdict: the most probable hypothesis with all it cannot be told from, or that none is probable enough.

    An effect so small that the refit alone would explain its recordings as well is left undecided.
    """
    leader = max(chances, key=lambda name: chances[name])
    if leader in ("none", "parameters"):
        fit = selection.nominal if leader == "none" else selection.refit
        return Verdict(leader if chances[leader] >= NAMED else "undecided", (), (), None, chances[leader], fit)
    if leader in ("unknown", "varying"):
        free = selection.beyond if leader == "unknown" else selection.free[0]  # the refit's
        kind = leader if chances[leader] >= NAMED else "undecided"
        named = selection.refit if leader == "varying" or free.fit.hypothesis.varying else free.fit
        varying = (f.fit.hypothesis.varying for f in selection.free if leader == "varying")
        own = tuple(name for names in varying for name, _, _ in names)
        channel = None if free.channel == "none" else free.channel
        return Verdict(kind, (), (), channel, chances[leader], named, own)
    fit = next(f for f in selection.named if f.hypothesis.name == leader)
    probability, doubt = chances[leader], ""
    if probability < NAMED and (common := _common(selection, chances)):
        (fit, probability), doubt = common, "beside"
    effects = fit.hypothesis.effects
    rivals = tied_class(selection, fit)
    kind = "effect" if len(effects) == 1 else "effects"
    if kind == "effect":
        probability = max(probability, sum(chances.get(name, 0.0) for name in rivals))
    seen = fit.hypothesis.outliers or separation(selection.setting, fit, selection.refit) >= SEPARABLE
    if probability < NAMED or not seen:
        kind, doubt = "undecided", ""
    return Verdict(kind, tuple(e.name for e in effects), rivals, effects[0].channel, probability, fit, doubt=doubt)


def _common(selection: Selection, chances: dict[str, float]) -> tuple[Fitted, float] | None:
    """The most effects that all but a few of the probable sets have in common, and the probability of these sets.

    None where there are none: sets that differ in what acts beside, each by a little, leave those beyond doubt.
    """

    def names(fit: Fitted) -> frozenset[str]:
        return frozenset(effect.name for effect in fit.hypothesis.effects)

    def held(fit: Fitted) -> float:
        return sum(chances.get(o.hypothesis.name, 0.0) for o in selection.named if names(fit) <= names(o))

    sure = [fit for fit in selection.named if held(fit) >= COMMON]
    most = max(sure, key=lambda fit: (len(names(fit)), held(fit)), default=None)
    return (most, held(most)) if most else None
