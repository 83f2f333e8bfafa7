"""Something pushes all the time, in the vehicle's own axes."""

from __future__ import annotations

from ..effect import Array, Moving, Number, PlacedEffect, Values, along


def push(s: Moving, axis: str, p: Values) -> Array:
    """A constant force or moment in body axes."""
    return along(axis, p["F"])


EFFECT = PlacedEffect(
    "constant_force",
    "axis",
    "F += F",
    (Number("F", ("_N", "_N_m"), "force or moment", usual=lambda s: 0.3 * s.force, slot="force"),),
    wrench=push,
    order=10,
)
