"""Tether: a cable pulls the hull back to where it hangs straight, which need not be where a run begins."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def acceleration(x: float, k: float, rest: float) -> float:
    """Pull per unit of moving mass [m/s2] at distance x from the start [m]."""
    return -k * (x - rest)


EFFECT = Effect(
    name="tether",
    channel="hydrodynamics",
    place="surge",
    sentence="A slack cable pulls the hull back towards where it hangs straight like a soft spring.",
    law="du/dt += -k (x - rest)",
    parameters=(
        Parameter("k", "1/s2", "stiffness per unit of moving mass", 0.0, (0.0, 1.0), 0.01),
        Parameter(
            "rest", "m", "where it hangs straight, from the start", 0.0, (-1.0, 1.0), 0.3, per_run=True, shape=True
        ),
    ),
    source="Hooke's law for a slack catenary linearised about its anchor; a guess for any particular cable",
    order=6,
    confused_with=("wall_proximity", "seiche"),
    needs=("position",),
    depends_on=("place",),
    force=acceleration,
)
