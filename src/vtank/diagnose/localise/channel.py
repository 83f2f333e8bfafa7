"""The channel: does the gap look like a force that is missing, or like a sensor that errs?

Discrepancies without a name, a force and a sensor error, are laid on top of the refit and compete; the named
hypotheses say more, and share their probability out to the channels they act in.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from scipy.special import expit, softmax

from ..discrepancy import Discrepancy, unnamed
from ..selection import Selection
from ..verdict import unknown_odds

CHANNELS = ("hydrodynamics", "actuator", "sensor", "none")


@dataclass(frozen=True)
class ChannelShares:
    """Force against sensor.

    Attributes:
        probability: of the gap lying in each of CHANNELS; sums to one.
        refit: per family of unnamed discrepancies, log evidence it gains on the refit.
        best: the same on the best explanation: what is left of it.
    """

    probability: dict[str, float]
    refit: dict[str, float]
    best: dict[str, float]

    def document(self) -> dict[str, Any]:
        """As plain data."""
        gains = {"refit": _by_kind(self.refit), "best": _by_kind(self.best)}
        return {"probability": self.probability, "log_evidence_gain": gains}


def channel_shares(selection: Selection, chances: dict[str, float]) -> ChannelShares:
    """Evidence of force against sensor on top of the refit, and the probability of each channel."""
    on_refit = selection.unnamed
    if selection.best is not selection.refit:
        on_refit = tuple(unnamed(selection.setting, selection.refit))
    return ChannelShares(_probability(selection, chances), _gains(on_refit), _gains(selection.unnamed))


def _probability(selection: Selection, chances: dict[str, float]) -> dict[str, float]:
    """Every hypothesis gives its probability to its effects' channels; what has no name to where its traces are.

    A cause that leaves none, but passes for the best explanation, is taken to act where that one does.
    """
    traces, mimic = unknown_odds(selection)
    leaves = float(expit(traces - mimic))
    total = dict.fromkeys(CHANNELS, 0.0)
    weights = softmax([d.gain for d in selection.unnamed])
    for discrepancy, weight in zip(selection.unnamed, weights, strict=True):
        total[discrepancy.channel] += chances["unknown"] * leaves * float(weight)
    own = [(fit, chances[fit.hypothesis.name]) for fit in selection.fits]
    for fit, chance in (*own, (selection.best, chances["unknown"] * (1.0 - leaves))):
        channels: list[str] = [effect.channel for effect in fit.hypothesis.effects] or ["none"]
        for channel in channels:
            total[channel] += chance / len(channels)
    return total


def _gains(nameless: Sequence[Discrepancy]) -> dict[str, float]:
    return {f"{d.channel}: {d.family}": d.gain for d in nameless}


def _by_kind(gains: dict[str, float]) -> dict[str, float]:
    """Best gain of a force and of a sensor error."""
    sensor = max(gain for name, gain in gains.items() if name.startswith("sensor"))
    force = max(gain for name, gain in gains.items() if not name.startswith("sensor"))
    return {"force": force, "sensor": sensor}
