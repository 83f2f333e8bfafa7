"""The heading is off by an angle: declination, or iron nearby."""

from __future__ import annotations

from ..effect import Number, PlacedEffect
from .change import biased

EFFECT = PlacedEffect(
    "magnetometer_bias",
    "sensor",
    "heading + b",
    (Number("b", ("_rad",), "error of the heading", low=-3.2, high=3.2, usual=lambda _: 0.15),),
    channels=("heading_rad",),
    changes=biased({"b": "heading_rad"}),
    order=12,
)
