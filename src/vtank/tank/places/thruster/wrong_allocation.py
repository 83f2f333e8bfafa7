"""The inputs of two thrusters are exchanged."""

from __future__ import annotations

from ..effect import PlacedEffect

EFFECT = PlacedEffect(
    "wrong_allocation",
    "thruster",
    "n_this <-> n_other",
    text="other",
    order=12,
)
