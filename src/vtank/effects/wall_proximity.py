"""Wall proximity: added mass and drag grow as the hull comes near the wall ahead.

The growth follows the cube of the inverse distance, as for a sphere that moves towards a plane (Lamb), scaled so
that the parameters are the fractional growth at 3 m, close to the paper's stand-off of 10 ft.
"""

from ..compiled import law
from .effect import Effect, Parameter

STANDOFF_M = 3.0  # [m] distance at which the parameters are stated (definition)
NEAREST_M = 0.05  # [m] the law is cut off here: the hull has then hit the wall


@law
def growth(gap: float) -> float:
    """Growth of the wall's influence, 1 at 3 m [-], for the distance to the wall `gap` [m]."""
    ratio = STANDOFF_M / max(gap, NEAREST_M)
    return ratio * ratio * ratio


@law
def inertia_factor(gap: float, mass: float) -> float:
    """Moving mass near the wall over moving mass in open water [-]."""
    return 1.0 + mass * growth(gap)


@law
def inertia_gradient(gap: float, mass: float) -> float:
    """Half the gradient of the inertia factor ahead, which multiplies u^2 in Lagrange's equation [1/m]."""
    return 1.5 * mass * growth(gap) / max(gap, NEAREST_M)


@law
def drag_factor(gap: float, drag: float) -> float:
    """Quadratic drag near the wall over drag in open water [-]."""
    return 1.0 + drag * growth(gap)


EFFECT = Effect(
    name="wall_proximity",
    channel="hydrodynamics",
    place="surge",
    sentence="Near the wall the water has to squeeze past the bow, so that added mass and drag grow.",
    law="(1 + mass g) du/dt + 1.5 mass g/gap u^2 = (1 + drag g) alpha u_r|u_r| + ..., g = (3 m/gap)^3",
    parameters=(
        Parameter("drag", "-", "fractional growth of quadratic drag at 3 m", 0.0, (0.0, 3.0), 0.3),
        Parameter("mass", "-", "fractional growth of moving mass at 3 m", 0.0, (0.0, 1.0), 0.1),
    ),
    source="Lamb, Hydrodynamics (1932), sphere before a wall: added mass grows with (a/d)^3; drag alike: a guess",
    order=5,
    confused_with=("tether", "drag_asymmetry"),
    needs=("sonar",),
    depends_on=("place",),
    in_equation=True,
)
