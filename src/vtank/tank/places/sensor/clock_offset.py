"""Its clock is ahead of the others', which looks late, or behind."""

from __future__ import annotations

from ..effect import Number, PlacedEffect
from .change import change

EFFECT = PlacedEffect(
    "clock_offset",
    "sensor",
    "z(t) tells of t - o",
    (Number("o", ("_s",), "by which it is ahead", low=-600.0, high=600.0, usual=lambda _: 0.4),),
    changes=change(clock_offset_s=lambda sensor, p: sensor.clock_offset_s + p["o"]),
    order=7,
)
