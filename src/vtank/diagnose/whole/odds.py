"""Odds of explanations of a whole vehicle's gap: what is held beforehand, and what is left beside them says of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...rigid.places import Placed
from ..imitation import IMPERFECT, imitating
from .model import Model
from .unnamed import Block

PRIOR = {"none": 0.15, "parameters": 0.15, "unknown": 0.1}  # the rest is shared by effects; guesses
NAMED = 1.0 - sum(PRIOR.values())
FORM = 0.2  # prior odds that an effect has another form than its law here, or its simulator another; a guess
OWN_IMPERFECT = 0.0001  # share of the evidence for own parameters that may be due to the form of their laws; a guess
WATER = 2.0  # deviations above the usual up to which water's disturbance is plausible; a choice
ROUGHER = 3.0  # times by which waters differ: a still tank's disturbance is 0.1 to 5 mm/s2; a guess
MISSED = 0.2  # share of causes without a name that no free-form part finds, for all that they push; a guess
ANOTHER = 0.2  # prior odds of one more effect beside one; a guess


def log_prior(model: Model, candidates: tuple[Placed, ...]) -> float:
    """Prior of a set of effects: each name alike, each of its places alike."""
    if not model.effects:
        return float(np.log(PRIOR["parameters"] if model.unknowns else PRIOR["none"]))
    total = float(np.log(NAMED))
    kinds = {placed.effect for placed in candidates}
    for n, placed in enumerate(model.effects):
        places = sum(other.effect == placed.effect for other in candidates)
        total -= placed.mimicry
        total -= float(np.log(len(kinds) * places)) - (float(np.log(ANOTHER)) if n else 0.0)
    return total


def worth(wider: Model, model: Model, own: Model, candidates: tuple[Placed, ...], form: float = np.inf) -> float:
    """Log odds of a model with one more effect, at one noise; form: as of `formed`."""
    gained = wider.log_evidence - model.log_evidence - formed(model, own, form)
    return gained + log_prior(wider, candidates) - log_prior(model, candidates)


def explained(model: Model, own: Model) -> float:
    """Log evidence that the effects of a model gain on own parameters alone."""
    return max(model.log_evidence - own.log_evidence, 0.0)


def formed(model: Model, own: Model, form: float = np.inf) -> float:
    """What one more effect may gain by the form of those before, hardly the very one that their laws have here.

    IMPERFECT of what they explain, but no more than another form of theirs, at their places, would gain: form.
    """
    return min(IMPERFECT * explained(model, own), max(form, 0.0))


def prior_odds(
    sets: Mapping[str, Model], own: Model, nominal: Model, candidates: tuple[Placed, ...], forms: Mapping[str, float]
) -> dict[str, float]:
    """Log evidence and prior of every set, less what its effects may gain by the form of what others explain.

    Others are the laws of own parameters, and of the likeliest with an effect less. forms: by name of a set, as of
    `formed`.
    """
    weights = {name: model.log_evidence + log_prior(model, candidates) for name, model in sets.items()}
    for name, model in sets.items():
        lesser = [(other.log_evidence, formed(other, own, forms.get(part, np.inf))) for part, other in sets.items()
                  if other.effects and set(other.names) < set(model.names)]  # fmt: skip
        bare, formed_too = (max((e + k * form for e, form in lesser), default=0.0) for k in (0.0, 1.0))
        mended = explained(model, own) - max(own.pulled - model.pulled, 0.0)  # not what own parameters are off less
        weights[name] -= of_own(own, nominal, mended) + formed_too - bare
    return weights


def of_own(own: Model, nominal: Model, gained: float) -> float:
    """What of the log evidence gained on own parameters may be due to the form of their laws.

    All of it, where it is small beside what they explain: then the odds are those held beforehand.
    """
    return min(OWN_IMPERFECT * explained(own, nominal), max(gained, 0.0))


def imperfect(left: float, model: Model, own: Model) -> float:
    """What a named cause gains by log evidence `left` beside it, of its own form's or of its simulator's making.

    What is left is, as a share of what the cause and it explain together, exponentially distributed about IMPERFECT
    where the cause is the named one; of a cause that the named one but imitates, any share is as likely (`imitated`).
    """
    share = max(left, 0.0) / max(left + explained(model, own), 1.0)
    return float(np.logaddexp(0.0, np.log(FORM) - share / IMPERFECT + left))


def imitated(left: float, model: Model, own: Model) -> float:
    """What a cause without a name, which the named one but imitates, gains on that by log evidence `left` beside it."""
    seen = float(np.sqrt(2.0 * explained(model, own)))
    return float(np.log(PRIOR["unknown"] / NAMED) + np.logaddexp(left + np.log(IMPERFECT), np.log(imitating(seen))))


def strange(times: float) -> float:
    """Log odds, over water, of a cause without a name behind a disturbance that is not plausible.

    It is one that goes with nothing that free-form parts look at. times: what is plausible, WATER deviations of ROUGHER
    each above what is usual.
    """
    off = WATER + np.log(times) / np.log(ROUGHER)
    return float(np.log(MISSED * PRIOR["unknown"] / PRIOR["none"]) + 0.5 * off**2 - 1.0)


def nameless(blocks: Sequence[Block], ground: Model, nominal: Model, mimicry: float) -> dict[str, float]:
    """Log odds of a cause without a name at each place.

    blocks: beside own parameters alone, whose fit is ground. mimicry: log odds of one that a named cause imitates,
    which is where the blocks say.
    """
    spread = np.log(PRIOR["unknown"] / max(len(blocks), 1))
    seen = [block for block in blocks if block.visible]
    total, found = np.logaddexp.reduce([block.gain for block in seen or blocks]), dict[str, float]()
    for block in seen or blocks:
        laws = 0.0 if block.channel == "sensor" else of_own(ground, nominal, block.gain)  # no law tells how one errs
        gain = block.gain - laws
        by_itself = ground.log_evidence + gain + spread if seen else -np.inf
        there = np.logaddexp(by_itself, mimicry + block.gain - total)
        name = f"unknown@{block.place}"
        found[name] = float(np.logaddexp(found.get(name, -np.inf), there))
    return found
