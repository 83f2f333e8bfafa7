"""Linear drag: skin friction and wave making at low speed, proportional to speed."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def acceleration(u_r: float, c: float) -> float:
    """Drag per unit of moving mass [m/s2] at relative speed u_r [m/s]."""
    return -c * u_r


EFFECT = Effect(
    name="linear_drag",
    channel="hydrodynamics",
    place="surge",
    sentence="Laminar skin friction adds a drag proportional to speed, which quadratic drag alone cannot follow.",
    law="du/dt += -c u_r",
    parameters=(Parameter("c", "1/s", "drag per unit of moving mass and speed", 0.0, (0.0, 5.0), 0.1),),
    source="Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), linear damping",
    order=1,
    confused_with=("coulomb_friction", "thrust_loss", "wake_memory"),
    force=acceleration,
)
