"""Probabilities before the data, and how much the evidence counts: the numbers frozen in calibration.toml."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources
from math import comb, log

from ..record.toml import parse
from .evidence import Fitted


@dataclass(frozen=True)
class Calibration:
    """Frozen numbers of calibration.toml.

    Attributes:
        tempering: exponent on the evidence of what has a name.
        prior: probability of each kind before the data.
        doubt: probability that the comparison itself went wrong and says nothing beyond the prior.
        mimicry: odds that a cause without a name passes for own parameters that are off and leaves nothing over.
        widening: stretch of the interval of the fraction closed.
        conformal: probability that a set of causes must reach to hold the true one in 95 % of all cases.
        budget: what widens the 90 % interval of each kind of line, over what no name accounts for.
    """

    tempering: float
    prior: dict[str, float]
    doubt: float
    mimicry: float
    widening: float
    conformal: float
    budget: dict[str, float]


@cache
def calibration() -> Calibration:
    """The calibration shipped with the package."""
    file = resources.files(__package__).joinpath("calibration.toml")
    data = parse(file.read_text(encoding="utf-8"), file)
    prior = {kind: float(value) for kind, value in data["prior"].items()}
    tempering, doubt, mimicry, conformal = (float(data[n]) for n in ("tempering", "doubt", "mimicry", "conformal"))
    budget = {kind: float(value) for kind, value in data["budget"].items()}
    return Calibration(tempering, prior, doubt, mimicry, float(data["shrink"]["widening"]), conformal, budget)


def log_prior(fit: Fitted, singles: int) -> float:
    """Log probability of a hypothesis before the data, where `singles` effects are considered.

    Each kind shares its probability equally; each effect beyond the second is as rare beside the second as the second
    beside the first.
    """
    prior, count = calibration().prior, len(fit.hypothesis.effects)
    if fit.hypothesis.varying:
        return log(prior["varying"])
    if count == 0:
        return log(prior["parameters" if fit.hypothesis.refit else "none"])
    rarer = log(prior["pair"] / prior["effect"])
    return log(prior["effect"]) + (count - 1) * rarer - log(max(comb(singles, count), 1))


def weight(fit: Fitted, singles: int) -> float:
    """Log of prior times tempered evidence, but for a constant."""
    return calibration().tempering * fit.log_evidence + log_prior(fit, singles)
