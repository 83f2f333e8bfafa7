"""Single recorded inputs are far off, though the thruster turned evenly."""

from __future__ import annotations

import numpy as np

from ..effect import INPUT, Array, Number, PlacedEffect, Values


def spiked(n: Array, p: Values, random: np.random.Generator) -> Array:
    """Single readings are far off, either way."""
    return n + p["size"] * random.choice([-1.0, 1.0], n.size) * (random.random(n.size) < p["p"])


EFFECT = PlacedEffect(
    "tachometer_spikes",
    "thruster",
    "n_read = n +- size with probability p",
    (
        Number("p", ("",), "probability per reading", low=0.0, high=1.0, usual=lambda _: 0.05, shape=True),
        Number("size", INPUT, "size of a spike", low=0.0, usual=lambda s: 0.5 * s.input),
    ),
    recorded=spiked,
    order=9,
)
