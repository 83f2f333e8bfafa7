"""Sonar multipath: some pings return by way of the surface or the floor and read long."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def reading(range_m: float, p: float, extra: float, uniform: float) -> float:
    """Range read [m]: long by `extra` [m] with probability p, decided by `uniform` in [0, 1)."""
    return range_m + extra if uniform < p else range_m


EFFECT = Effect(
    name="sonar_multipath",
    channel="sensor",
    place="range_m",
    sentence="Now and then an echo by way of surface or floor is taken for the wall, and reads long.",
    law="range += extra with probability p, independently from ping to ping",
    parameters=(
        Parameter("p", "-", "probability per ping", 0.0, (0.0, 0.3), 0.03, counted=True),
        Parameter("extra", "m", "excess path", 0.3, (0.02, 3.0), 0.3, shape=True, counted=True),
    ),
    source="Urick, Principles of Underwater Sound (1983), multipath in a bounded basin",
    order=2,
    confused_with=("tachometer_spikes",),
    needs=("sonar",),
)
