"""What is measured of a vehicle on its surge axis: range to the wall ahead, distance made good, speed."""

from __future__ import annotations

from ..compiled import term
from ..plant.hooks import acting_on, chained
from ..plant.parameters import slot
from ..plant.surge import STANDOFF, law_product
from .channel import Channel, reads_state

as_read = chained(acting_on("range_m"), "reads")
PLACE, SPEED = 0, 1  # among the states
RANGE_LAW = slot("law.range")


@term
def distance(t, s, ds, p):
    """Distance from the sonar to the wall as it reads it [m]."""
    gap = p[STANDOFF] - s[PLACE]
    if p[RANGE_LAW] != 0.0:
        gap = gap + p[RANGE_LAW] * law_product(t, s[PLACE], s[SPEED], 0.0, 0.0, 0.0, gap, 0.0, p)
    return as_read(gap, p)


CHANNELS = (
    Channel(
        "range_m", "m", distance, chained(acting_on("range_m")[::-1], "instant"), coloured=True,
        state=PLACE, begins=lambda value, p: p[STANDOFF] - value, words="range",
    ),
    Channel("position_m", "m", reads_state(PLACE), state=PLACE, words="position"),
    Channel("surge_m_s", "m/s", reads_state(SPEED), coloured=True, state=SPEED, words="speed"),
)  # fmt: skip
