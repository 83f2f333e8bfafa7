"""A fin stands at an angle when it is told to stand straight."""

from __future__ import annotations

from ..effect import Array, Number, PlacedEffect, Values


def offset(angle: Array, p: Values) -> Array:
    """Neutral is not where the file has it."""
    return angle + p["angle"]


EFFECT = PlacedEffect(
    "fin_offset",
    "fin",
    "angle -> angle + angle_0",
    (Number("angle", ("_rad",), "at which it stands", low=-1.6, high=1.6, usual=lambda _: 0.05, slot="offset"),),
    input=offset,
    order=1,
)
