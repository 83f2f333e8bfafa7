"""Drag asymmetry: the hull drags more astern than ahead, or the other way round."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def signed_square(u_r: float, e: float) -> float:
    """u|u| weighted by direction [m2/s2]: (1 + e) ahead, (1 - e) astern."""
    return u_r * (abs(u_r) + e * u_r)


EFFECT = Effect(
    name="drag_asymmetry",
    channel="hydrodynamics",
    place="surge",
    sentence="A bluff stern and a faired bow do not drag alike, so ahead and astern differ.",
    law="alpha u_r|u_r| -> alpha (|u_r| + e u_r) u_r",
    parameters=(Parameter("e", "-", "half the relative difference, ahead over astern", 0.0, (-0.95, 0.95), 0.2),),
    source="Hoerner, Fluid-Dynamic Drag (1965), bodies with blunt and faired ends",
    order=7,
    confused_with=("ambient_current", "thrust_asymmetry"),
    in_equation=True,
)
