"""Thrust lag: thrust follows the propeller speed through a first-order lag (the paper's tau)."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def rate(z: float, target: float, tau: float) -> float:
    """Rate of the lagged thrust per unit of moving mass [m/s3]; 0 without lag, where the state is not used."""
    return (target - z) / tau if tau > 0.0 else 0.0


@law
def present(z: float, target: float, tau: float) -> float:
    """Thrust per unit of moving mass that acts now [m/s2]: the lagged state, or the target where there is no lag."""
    return z if tau > 0.0 else target


EFFECT = Effect(
    name="thrust_lag",
    channel="actuator",
    place="thruster",
    sentence="The slipstream has to be set in motion first, so thrust lags the propeller speed.",
    law="tau dz/dt = beta n|n| - z",
    parameters=(Parameter("tau", "s", "time constant", 0.0, (0.0, 20.0), 0.3),),
    source="Marco, Martins, Healey, eq. (5) and (15)",
    order=4,
    confused_with=("sonar_latency", "command_delay", "wake_memory"),
    in_equation=True,
)
