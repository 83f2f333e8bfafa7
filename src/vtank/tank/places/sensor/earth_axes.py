"""Velocity is recorded along north, east and down instead of the body's axes."""

from __future__ import annotations

from ....record.columns import VELOCITY
from ..effect import PlacedEffect
from .change import change

EFFECT = PlacedEffect(
    "earth_axes",
    "sensor",
    "(u, v, w) -> R (u, v, w)",
    channels=VELOCITY,
    changes=change(earth_axes=lambda sensor, p: True),
    order=5,
)
