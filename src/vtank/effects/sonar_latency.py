"""Sonar latency: the range is stamped later than the echo that made it."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def echo_time(t: float, d: float) -> float:
    """Time at which the range stamped t was true [s]."""
    return t - d


EFFECT = Effect(
    name="sonar_latency",
    channel="sensor",
    place="range_m",
    sentence="Ping travel, processing and the serial line deliver the range late.",
    law="range(t) is the distance at t - d",
    parameters=(Parameter("d", "s", "delay", 0.0, (0.0, 1.0), 0.1),),
    source="pure delay of a sampled sensor",
    order=1,
    confused_with=("command_delay", "thrust_lag"),
    standing="tied",
    needs=("sonar",),
    instant=echo_time,
)
