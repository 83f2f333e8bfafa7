"""Sonar scale: the speed of sound set in the sonar is wrong, so ranges are stretched."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def reading(range_m: float, s: float) -> float:
    """Range read [m] for a true range [m]."""
    return range_m * (1.0 + s)


EFFECT = Effect(
    name="sonar_scale",
    channel="sensor",
    place="range_m",
    sentence="A wrong speed of sound stretches every range by the same factor.",
    law="range -> (1 + s) range",
    parameters=(Parameter("s", "-", "relative error of the range", 0.0, (-0.1, 0.1), 0.01),),
    source="range = c t / 2; alpha -> alpha/(1 + s), beta -> beta (1 + s) give the same ranges",
    order=3,
    standing="absorbed",
    needs=("sonar",),
    reads=reading,
)
