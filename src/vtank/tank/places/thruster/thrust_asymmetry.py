"""Blades are cambered for going ahead, so the same input pushes less astern."""

from __future__ import annotations

import numpy as np

from ..effect import Array, Number, PlacedEffect, Values


def one_sided(time_s: Array, n: Array, force: Array, p: Values) -> Array:
    """(1 + e) ahead, (1 - e) astern."""
    return force * (1.0 + p["e"] * np.sign(force))


EFFECT = PlacedEffect(
    "thrust_asymmetry",
    "thruster",
    "F -> F (1 + e sign(F))",
    (Number("e", ("",), "half the relative difference", low=-0.95, high=0.95, usual=lambda _: 0.3, slot="asymmetry"),),
    thrust=one_sided,
    order=4,
)
