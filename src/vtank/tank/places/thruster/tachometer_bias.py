"""The recorded input is off by an amount."""

from __future__ import annotations

from ..effect import INPUT, Array, Number, PlacedEffect, Values


def misread(n: Array, p: Values) -> Array:
    """The recording has b more than what acts."""
    return n - p["b"]


EFFECT = PlacedEffect(
    "tachometer_bias",
    "thruster",
    "n_read = n + b",
    (Number("b", INPUT, "offset of what is recorded", usual=lambda s: 0.2 * s.input, slot="misread"),),
    input=misread,
    order=1,
)
