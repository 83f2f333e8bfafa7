"""The drive obeys late."""

from __future__ import annotations

from ..effect import Number, PlacedEffect, Values


def later(p: Values) -> float:
    """Delay [s]."""
    return p["d"]


EFFECT = PlacedEffect(
    "command_delay",
    "thruster",
    "n(t) -> n(t - d)",
    (Number("d", ("_s",), "delay", low=0.0, high=60.0, usual=lambda _: 0.4, slot="delay"),),
    delay=later,
    order=8,
)
