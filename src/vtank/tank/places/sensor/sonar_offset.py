"""The sonar measures from a point that is not where the file has it."""

from __future__ import annotations

from ..effect import Number, PlacedEffect
from .change import biased

EFFECT = PlacedEffect(
    "sonar_offset",
    "sensor",
    "range + o",
    (Number("o", ("_m",), "error of the range", low=-100.0, high=100.0, usual=lambda _: 0.1),),
    channels=("range_m",),
    changes=biased({"o": "range_m"}),
    order=15,
)
