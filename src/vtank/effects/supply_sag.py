"""Supply sag: thrust fades with time as the battery runs down."""

import math

from ..compiled import law
from .effect import Effect, Parameter


@law
def factor(t: float, r: float) -> float:
    """Thrust at time t [s] over thrust at the start of the run [-]."""
    return math.exp(-r * t) if r != 0.0 else 1.0


EFFECT = Effect(
    name="supply_sag",
    channel="actuator",
    place="thruster",
    sentence="The battery runs down during the run, and the same propeller command pushes less and less.",
    law="beta -> beta exp(-r t)",
    parameters=(Parameter("r", "1/s", "relative fading per second", 0.0, (0.0, 0.05), 0.002),),
    source="first-order discharge; a guess in form",
    order=6,
    confused_with=("clock_skew",),
    needs=("propeller",),
    depends_on=("time",),
    in_equation=True,
)
