"""The depth sensor was set to zero elsewhere."""

from __future__ import annotations

from ..effect import Number, PlacedEffect
from .change import biased

EFFECT = PlacedEffect(
    "depth_offset",
    "sensor",
    "depth + o",
    (Number("o", ("_m",), "error of the depth", low=-100.0, high=100.0, usual=lambda _: 0.3),),
    channels=("depth_m",),
    changes=biased({"o": "depth_m"}),
    order=13,
)
