"""Thrust saturation: above some speed the propeller pushes no harder."""

from math import inf

from ..compiled import law
from .effect import Effect, Parameter


@law
def effective_speed(n: float, n_max: float) -> float:
    """Propeller speed limited to n_max, both ways [same unit as n]."""
    return min(max(n, -n_max), n_max)


EFFECT = Effect(
    name="thrust_saturation",
    channel="actuator",
    place="thruster",
    sentence="Ventilation, current limit or supply voltage keep the thrust from growing beyond some speed.",
    law="n_e = min(max(n, -n_max), n_max)",
    parameters=(
        Parameter(
            "n_max",
            "rev/s",
            "speed at which thrust flattens, in the unit of the input",
            inf,
            (0.0, inf),
            8.0,
            starts=(0.9, 0.7, 0.5),
        ),
    ),
    source="bollard test of an electric catamaran, flat above 0.7 of full command (pub_usv_modeling, 2017)",
    order=5,
    confused_with=("thrust_loss", "thrust_lag"),
    needs=("propeller",),
    in_equation=True,
)
