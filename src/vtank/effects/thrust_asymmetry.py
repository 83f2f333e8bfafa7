"""Thrust asymmetry: the propeller pushes less astern than ahead."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def signed_square(n_e: float, e: float) -> float:
    """n|n| weighted by direction [rev2/s2]: (1 + e) ahead, (1 - e) astern."""
    return n_e * (abs(n_e) + e * n_e)


@law
def signed_thrust(n_e: float, e: float) -> float:
    """The same weighting for an input that is a thrust already [N]."""
    return n_e + e * abs(n_e)


EFFECT = Effect(
    name="thrust_asymmetry",
    channel="actuator",
    place="thruster",
    sentence="Blades are cambered for going ahead, so the same speed pushes less astern.",
    law="beta n|n| -> beta (|n| + e n) n",
    parameters=(Parameter("e", "-", "half the relative difference, ahead over astern", 0.0, (-0.95, 0.95), 0.1),),
    source="four-quadrant diagrams (van Lammeren et al., SNAME Trans. 77, 1969); T200 bench data: e = 0.11",
    order=2,
    confused_with=("drag_asymmetry", "tachometer_bias"),
    needs=("propeller",),
    in_equation=True,
)
