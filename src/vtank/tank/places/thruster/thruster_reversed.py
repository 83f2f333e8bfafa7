"""A thruster pushes the other way: wires or blades are the wrong way round."""

from __future__ import annotations

from ..effect import Array, PlacedEffect, Values


def reversed_(time_s: Array, n: Array, force: Array, p: Values) -> Array:
    """The other way."""
    return -force


EFFECT = PlacedEffect(
    "thruster_reversed",
    "thruster",
    "F -> -F",
    thrust=reversed_,
    order=11,
)
