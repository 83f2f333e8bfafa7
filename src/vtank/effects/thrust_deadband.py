"""Thrust dead-band: no thrust until the propeller turns faster than a threshold."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def effective_speed(n: float, n0: float) -> float:
    """Propeller speed that makes thrust, of the size of n less n0 and never reversed [same unit as n]."""
    return n - min(max(n, -n0), n0)


EFFECT = Effect(
    name="thrust_deadband",
    channel="actuator",
    place="thruster",
    sentence="Below a threshold speed the propeller only churns, or the drive does not turn it at all.",
    law="n_e = sign(n) max(|n| - n0, 0)",
    parameters=(Parameter("n0", "rev/s", "threshold speed, in the unit of the input", 0.0, (0.0, 5.0), 1.0),),
    source="Yoerger, Cooke, Slotine, IEEE J. Oceanic Eng. 15 (1990), thruster non-linearities near zero",
    order=1,
    confused_with=("coulomb_friction", "thrust_asymmetry"),
    needs=("propeller",),
    in_equation=True,
)
