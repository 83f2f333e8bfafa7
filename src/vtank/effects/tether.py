"""Tether: a cable pulls the hull back to where it hangs straight."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def acceleration(x: float, k: float) -> float:
    """Pull per unit of moving mass [m/s2] at distance x from the start [m]."""
    return -k * x


EFFECT = Effect(
    name="tether",
    channel="hydrodynamics",
    place="surge",
    sentence="A slack cable pulls the hull back towards its starting point like a soft spring.",
    law="du/dt += -k x",
    parameters=(Parameter("k", "1/s2", "stiffness per unit of moving mass", 0.0, (0.0, 1.0), 0.01),),
    source="Hooke's law for a slack catenary linearised about its anchor; a guess for any particular cable",
    order=6,
    confused_with=("wall_proximity", "seiche"),
    needs=("position",),
    depends_on=("place",),
    force=acceleration,
)
