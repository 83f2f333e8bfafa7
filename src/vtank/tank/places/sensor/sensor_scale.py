"""All that it reads, or one channel, is too large by a factor."""

from __future__ import annotations

from ..effect import Number, PlacedEffect
from .change import scaled

EFFECT = PlacedEffect(
    "sensor_scale",
    "sensor",
    "z -> (1 + s) z",
    (Number("s", ("",), "relative error", low=-10.0, high=10.0, usual=lambda _: 0.1),),
    text="channel",
    changes=scaled(lambda p: 1.0 + p["s"]),
    order=2,
)
