"""The channel: does the gap look like a force that is missing, or like a sensor that errs?

What has no name says where it acts; the named hypotheses share their probability out to the channels they act in.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..freeform import Freeform
from ..selection import Selection

CHANNELS = ("hydrodynamics", "actuator", "sensor", "none")


@dataclass(frozen=True)
class ChannelShares:
    """Force against sensor.

    Attributes:
        probability: of the gap lying in each of CHANNELS; sums to one.
        refit: log evidence that each thing without a name gains on the refit.
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
    free = {id(f.fit): f for f in selection.free}
    on_refit, on_best = free[id(selection.refit)], free.get(id(selection.best), selection.beyond)
    return ChannelShares(_probability(selection, chances), _gains(on_refit), _gains(on_best))


def _probability(selection: Selection, chances: dict[str, float]) -> dict[str, float]:
    """Every hypothesis gives its probability to its effects' channels; what has no name to where its traces are."""
    total = dict.fromkeys(CHANNELS, 0.0)
    for fit in selection.fits:
        channels: list[str] = [effect.channel for effect in fit.hypothesis.effects] or ["none"]
        for channel in channels:
            total[channel] += chances[fit.hypothesis.name] / len(channels)
    for name, free in (("unknown", selection.beyond), ("varying", selection.free[0])):  # the refit's
        for channel, share in free.channels.items():
            total[channel] += chances[name] * share
    return total


def _gains(free: Freeform) -> dict[str, float]:
    return {f"{c.channel}: {c.about}": c.gain for c in free.components}


def _by_kind(gains: dict[str, float]) -> dict[str, float]:
    """Gain of forces and of sensor errors."""
    sensor = sum((gain for name, gain in gains.items() if name.startswith("sensor")), 0.0)
    return {"force": sum(gains.values()) - sensor, "sensor": sensor}
