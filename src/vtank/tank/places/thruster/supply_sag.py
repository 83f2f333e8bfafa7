"""The battery runs down, and the same input pushes less and less."""

from __future__ import annotations

import numpy as np

from ..effect import Array, Number, PlacedEffect, Values


def fading(time_s: Array, n: Array, force: Array, p: Values) -> Array:
    """Less and less as the battery runs down."""
    return force * np.exp(-p["r"] * time_s)


EFFECT = PlacedEffect(
    "supply_sag",
    "thruster",
    "F -> F exp(-r t)",
    (Number("r", ("_per_s",), "relative fading", low=0.0, high=1.0, usual=lambda _: 0.003, slot="sag"),),
    thrust=fading,
    order=7,
)
