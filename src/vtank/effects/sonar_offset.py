"""Sonar offset: every range is wrong by the same length."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def reading(range_m: float, o: float) -> float:
    """Range read [m] for a true range [m]."""
    return range_m + o


EFFECT = Effect(
    name="sonar_offset",
    channel="sensor",
    place="range_m",
    sentence="The sonar measures from a point that is not where the drawing says.",
    law="range -> range + o",
    parameters=(Parameter("o", "m", "offset of the range", 0.0, (-1.0, 1.0), 0.05),),
    source="mounting offset; the unknown initial position of a run gives the same ranges",
    order=4,
    standing="absorbed",
    needs=("sonar",),
    reads=reading,
)
