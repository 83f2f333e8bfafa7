"""A thruster makes only part of its force, or none."""

from __future__ import annotations

from ..effect import Array, Number, PlacedEffect, Values


def weak(time_s: Array, n: Array, force: Array, p: Values) -> Array:
    """What is left of it."""
    return force * (1.0 - p["share"])


EFFECT = PlacedEffect(
    "thruster_dead",
    "thruster",
    "F -> (1 - share) F",
    (Number("share", ("",), "of its force that is lost", 1.0, 0.0, 1.0, usual=lambda _: 0.5),),
    thrust=weak,
    order=10,
)
