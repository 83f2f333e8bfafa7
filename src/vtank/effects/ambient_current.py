"""Ambient current: the water of the tank moves past the hull at a steady speed."""

from .effect import Effect, Parameter

EFFECT = Effect(
    name="ambient_current",
    channel="hydrodynamics",
    place="surge",
    sentence="The tank's water drifts steadily, so drag acts on the speed through the water, not over the floor.",
    law="u_r = u - U",
    parameters=(Parameter("U", "m/s", "speed of the water towards the wall ahead", 0.0, (-0.5, 0.5), 0.03),),
    source="Fossen (2011), relative velocity in an irrotational current",
    order=3,
    confused_with=("drag_asymmetry", "tachometer_bias", "tether"),
    in_equation=True,
)
