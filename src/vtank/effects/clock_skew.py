"""Clock skew: sonar and tachometer are stamped by clocks that do not run alike."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def echo_time(t: float, s: float) -> float:
    """Time by the tachometer's clock [s] of a range stamped t by the sonar's [s]."""
    return t * (1.0 + s)


EFFECT = Effect(
    name="clock_skew",
    channel="sensor",
    place="range_m",
    sentence="Two computers stamp the sonar and the tachometer, and their clocks drift apart during the run.",
    law="range(t) is the distance at t (1 + s)",
    parameters=(Parameter("s", "-", "relative drift of the sonar's clock", 0.0, (-0.02, 0.02), 0.002),),
    source="linear clock drift",
    order=7,
    confused_with=("sonar_latency", "supply_sag"),
    needs=("sonar",),
    instant=echo_time,
)
