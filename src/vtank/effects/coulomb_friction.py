"""Dry friction: a guide, a fender or a tether that rubs, constant against the motion."""

import math

from ..compiled import law
from .effect import Effect, Parameter

REVERSAL_M_S = 0.005  # [m/s] speed over which the force turns round, below the sonar's resolution per ping; a guess


@law
def acceleration(u: float, f: float) -> float:
    """Friction per unit of moving mass [m/s2] at speed u over the tank floor [m/s]."""
    return -f * math.tanh(u / REVERSAL_M_S)


EFFECT = Effect(
    name="coulomb_friction",
    channel="hydrodynamics",
    place="surge",
    sentence="A guide or tether that rubs resists with a constant force, whatever the speed.",
    law="du/dt += -f sign(u), turned round smoothly within 5 mm/s",
    parameters=(Parameter("f", "m/s2", "friction force per unit of moving mass", 0.0, (0.0, 2.0), 0.01),),
    source="Coulomb's law; smooth reversal after Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994)",
    order=2,
    confused_with=("linear_drag", "thrust_deadband"),
    force=acceleration,
)
