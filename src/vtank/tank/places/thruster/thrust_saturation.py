"""Beyond some input the thruster pushes no harder."""

from __future__ import annotations

import numpy as np

from ..effect import INPUT, Array, Number, PlacedEffect, Values


def saturated(n: Array, p: Values) -> Array:
    """Flat beyond n_max."""
    return np.clip(n, -p["n_max"], p["n_max"])


EFFECT = PlacedEffect(
    "thrust_saturation",
    "thruster",
    "n_e = min(max(n, -n_max), n_max)",
    (
        Number(
            "n_max", INPUT, "where it flattens", low=0.0, usual=lambda s: 0.6 * s.input, shape=True, slot="saturation"
        ),
    ),
    input=saturated,
    order=3,
)
