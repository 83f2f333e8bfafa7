"""The water drifts along the vehicle's own axis, so drag acts on another speed."""

from __future__ import annotations

from ..effect import Array, Moving, Number, PlacedEffect, Values
from .resistance import carried


def drift(s: Moving, axis: str, p: Values) -> Array:
    """Drag acts on the speed less U."""
    return carried(s, axis, p["U"])


EFFECT = PlacedEffect(
    "ambient_current",
    "axis",
    "drag at u_r - U",
    (
        Number(
            "U", ("_m_s", "_rad_s"), "speed of the water", low=-5.0, high=5.0, usual=lambda s: 0.4 * s.u, slot="drift"
        ),
    ),
    wrench=drift,
    order=4,
)
