"""Blades are cambered for going ahead, so the same input pushes less astern."""

from __future__ import annotations

import numpy as np

from ..effect import Array, Number, PlacedEffect, Values


def one_sided(time_s: Array, n: Array, force: Array, p: Values) -> Array:
    """As it is ahead, (1 - e) of it astern."""
    return force - p["e"] * np.minimum(force, 0.0)


EFFECT = PlacedEffect(
    "thrust_asymmetry",
    "thruster",
    "F -> F (1 - e) where F < 0",
    (Number("e", ("",), "share of its force astern that it lacks",
            low=-0.95, high=0.95, usual=lambda _: 0.3, slot="asymmetry"),),
    thrust=one_sided,
    order=4,
)  # fmt: skip
