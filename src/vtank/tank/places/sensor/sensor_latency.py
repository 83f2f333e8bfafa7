"""What it measures is recorded late."""

from __future__ import annotations

from ..effect import Number, PlacedEffect
from .change import change

EFFECT = PlacedEffect(
    "sensor_latency",
    "sensor",
    "z(t) tells of t - d",
    (Number("d", ("_s",), "more latency", low=0.0, high=60.0, usual=lambda _: 0.3),),
    changes=change(latency_s=lambda sensor, p: sensor.latency_s + p["d"]),
    order=1,
)
