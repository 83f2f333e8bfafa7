"""The two ends do not drag alike."""

from __future__ import annotations

from ....plant.vehicle import AXES
from ..effect import Array, Moving, Number, PlacedEffect, Values, along


def asymmetry(s: Moving, axis: str, p: Values) -> Array:
    """Quadratic drag (1 + e) ahead, (1 - e) astern."""
    i = AXES.index(axis)
    return along(axis, -p["e"] * s.vehicle.quadratic_drag[i] * s.through[i] ** 2)


EFFECT = PlacedEffect(
    "drag_asymmetry",
    "axis",
    "F = -e D u_r^2",
    (
        Number(
            "e",
            ("",),
            "half the relative difference, ahead over astern",
            low=-0.95,
            high=0.95,
            usual=lambda _: 0.3,
            slot="drag_asymmetry",
        ),
    ),
    wrench=asymmetry,
    order=3,
)
