"""Command delay: the propeller speed acts later than it is stamped."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def input_time(t: float, d: float) -> float:
    """Stamp of the propeller speed that acts at time t [s]."""
    return t - d


EFFECT = Effect(
    name="command_delay",
    channel="actuator",
    place="thruster",
    sentence="The motor drive obeys late, so the recorded propeller speed acts after its stamp.",
    law="n(t) -> n(t - d)",
    parameters=(Parameter("d", "s", "delay", 0.0, (0.0, 1.0), 0.1, starts=(0.05, 0.3, 0.8)),),
    source="pure delay of a sampled actuator; to one sonar the same thing as sonar_latency",
    order=7,
    confused_with=("sonar_latency", "thrust_lag"),
    standing="tied",
    same_as="sonar_latency",
    acts=input_time,
)
