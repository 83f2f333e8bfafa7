"""Below a threshold the propeller only churns, or the drive does not turn it."""

from __future__ import annotations

import numpy as np

from ..effect import INPUT, Array, Number, PlacedEffect, Values


def dead_band(n: Array, p: Values) -> Array:
    """Nothing below n0, n0 less above."""
    return n - np.clip(n, -p["n0"], p["n0"])


EFFECT = PlacedEffect(
    "thrust_deadband",
    "thruster",
    "n_e = sign(n) max(|n| - n0, 0)",
    (
        Number(
            "n0", INPUT, "threshold, in the unit of the input", low=0.0, usual=lambda s: 0.3 * s.input, slot="deadband"
        ),
    ),
    input=dead_band,
    order=2,
)
