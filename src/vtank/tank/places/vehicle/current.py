"""The water drifts steadily, as a vector over ground."""

from __future__ import annotations

from ..effect import VEHICLE, Number, PlacedEffect
from .offset import EARTH

FASTEST_M_S = 5.0  # [m/s] of any current, north, east or down; a choice

EFFECT = PlacedEffect(
    "current",
    VEHICLE,
    "nu_r = nu - R' U",
    tuple(
        Number(
            axis,
            ("_m_s",),
            f"speed {axis}",
            0.0,
            -FASTEST_M_S,
            FASTEST_M_S,
            usual=lambda _: 0.1,
            slot=f"current_{axis}",
        )
        for axis in EARTH
    ),
    drifts=lambda p: (p["north"], p["east"], p["down"]),
    order=7,
)
