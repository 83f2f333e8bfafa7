"""The water drifts steadily, as a vector over ground."""

from __future__ import annotations

from ..effect import VEHICLE, Number, PlacedEffect
from .offset import EARTH

EFFECT = PlacedEffect(
    "current",
    VEHICLE,
    "nu_r = nu - R' U",
    tuple(Number(axis, ("_m_s",), f"speed {axis}", 0.0, -5.0, 5.0, usual=lambda _: 0.1) for axis in EARTH),
    drifts=lambda p: (p["north"], p["east"], p["down"]),
    order=7,
)
