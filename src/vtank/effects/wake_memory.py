"""Wake memory: the oscillating hull meets the water it has set in motion itself.

The wake is carried as one state, a water velocity that follows the hull's with a time constant.
"""

from ..compiled import law
from .effect import Effect, Parameter


@law
def rate(u: float, wake: float, k: float, T: float) -> float:
    """Rate of the wake's velocity [m/s2] from hull speed u and wake velocity, both [m/s]."""
    return (k * u - wake) / T if k != 0.0 else 0.0


EFFECT = Effect(
    name="wake_memory",
    channel="hydrodynamics",
    place="surge",
    sentence="The hull drags water along and meets it again on the way back.",
    law="u_r = u - w, T dw/dt = k u - w",
    parameters=(
        Parameter("k", "-", "share of the hull's speed that the wake takes up", 0.0, (0.0, 0.9), 0.3),
        Parameter(
            "T",
            "s",
            "time the wake takes to follow and to die away",
            5.0,
            (0.5, 60.0),
            5.0,
            shape=True,
            starts=(2.0, 12.0),
        ),
    ),
    source="one-state form of the history force (Sarpkaya, Wave Forces on Offshore Structures, 2010); a guess",
    order=8,
    confused_with=("linear_drag", "thrust_lag"),
    in_equation=True,
)
