"""Its clock runs slow."""

from __future__ import annotations

from ..effect import Number, PlacedEffect
from .change import change

EFFECT = PlacedEffect(
    "clock_skew",
    "sensor",
    "z(t) tells of t (1 + s)",
    (Number("s", ("",), "relative drift", low=-0.1, high=0.1, usual=lambda _: 0.005),),
    changes=change(clock_skew=lambda sensor, p: sensor.clock_skew + p["s"]),
    order=6,
)
