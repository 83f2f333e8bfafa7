"""Thrust loss: a propeller that advances through the water pushes less (the paper's gamma)."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def acceleration(u_r: float, n_e: float, gamma: float) -> float:
    """Loss of thrust per unit of moving mass [m/s2], negative against the motion."""
    return gamma * abs(n_e) * u_r


EFFECT = Effect(
    name="thrust_loss",
    channel="actuator",
    place="thruster",
    sentence="The faster the hull already goes, the less the turning propeller pushes.",
    law="du/dt += gamma |n| u_r",
    parameters=(Parameter("gamma", "1/rev", "thrust loss per unit of moving mass, n and u", 0.0, (-2.0, 0.0), 0.02),),
    source="Marco, Martins, Healey, eq. (2), cross term; linear KT(J) curve",
    order=3,
    confused_with=("linear_drag",),
    needs=("propeller",),
    force=acceleration,
)
