"""Tachometer bias: the tachometer reads a constant too much."""

from ..compiled import law
from .effect import Effect, Parameter


@law
def reading(n: float, b: float) -> float:
    """Tachometer reading [rev/s] at propeller speed n [rev/s]."""
    return n + b


@law
def true_input(n_read: float, lone: float, b: float) -> float:
    """Propeller speed [rev/s] behind a reading [rev/s], whether that stands alone or not."""
    return n_read - b


EFFECT = Effect(
    name="tachometer_bias",
    channel="sensor",
    place="n_rev_s",
    sentence="An offset of the tachometer's amplifier reads as propeller speed that is not there.",
    law="n_read = n + b",
    parameters=(Parameter("b", "rev/s", "offset of the reading, in the unit of the input", 0.0, (-3.0, 3.0), 0.3),),
    source="offset error of a tachogenerator",
    order=5,
    confused_with=("ambient_current", "thrust_asymmetry"),
    needs=("propeller",),
    reads=reading,
    true_input=true_input,
)
