"""The faster the propeller advances through the water, the less it pushes."""

from __future__ import annotations

from ..effect import Array, Moving, Number, PlacedEffect, Values

LOSS = ("_N_s2_per_rev_m", "_N_s_per_m", "_s_per_m")  # force per input and speed


def advance_loss(s: Moving, name: str, p: Values) -> Array:
    """Less thrust the faster the propeller advances: -gamma |n| u_a along its direction."""
    gear = s.gears[name]
    return -p["gamma"] * abs(s.asked.get(name, 0.0)) * float(gear @ s.through) * gear


EFFECT = PlacedEffect(
    "thrust_loss",
    "thruster",
    "F -= gamma |n| u_a",
    (
        Number(
            "gamma",
            LOSS,
            "loss per input and speed of advance",
            low=0.0,
            usual=lambda s: 0.3 * s.force / s.input / s.u,
            slot="loss",
        ),
    ),
    wrench=advance_loss,
    order=6,
)
