"""A guide or tether that rubs resists with a constant force."""

from __future__ import annotations

import math

from ....plant.vehicle import AXES
from ..effect import Array, Moving, Number, PlacedEffect, Values, along

REVERSAL = 0.005  # [m/s or rad/s] speed over which friction turns round; a guess, as of the single-axis effect


def friction(s: Moving, axis: str, p: Values) -> Array:
    """Against the motion over ground, whatever the speed."""
    return along(axis, -p["f"] * math.tanh(s.nu[AXES.index(axis)] / REVERSAL))


EFFECT = PlacedEffect(
    "coulomb_friction",
    "axis",
    "F = -f tanh(u / 5 mm/s or mrad/s)",
    (Number("f", ("_N", "_N_m"), "friction", low=0.0, usual=lambda s: 0.3 * s.force, slot="coulomb_friction"),),
    wrench=friction,
    order=2,
)
