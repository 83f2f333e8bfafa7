"""A channel, or all, has the other sign."""

from __future__ import annotations

from ..effect import PlacedEffect
from .change import scaled

EFFECT = PlacedEffect(
    "wrong_sign",
    "sensor",
    "z -> -z",
    text="channel",
    changes=scaled(lambda p: -1.0),
    order=4,
)
