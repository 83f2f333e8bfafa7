"""It is recorded in a unit of its own."""

from __future__ import annotations

from ..effect import Number, PlacedEffect
from .change import scaled

EFFECT = PlacedEffect(
    "wrong_unit",
    "sensor",
    "z -> factor z",
    (Number("factor", ("",), "its unit in SI, inverted", usual=lambda _: 1.0 / 0.3048, shape=True),),
    text="channel",
    changes=scaled(lambda p: p["factor"]),
    order=3,
)
