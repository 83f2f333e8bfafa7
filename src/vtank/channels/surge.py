"""What is measured of a vehicle on its surge axis: range to the wall ahead, distance made good, speed."""

from __future__ import annotations

from ..compiled import term
from ..plant.hooks import acting_on, chained
from ..plant.surge import STANDOFF
from .channel import Channel

as_read = chained(acting_on("range_m"), "reads")


@term
def distance(t, s, ds, p):  # type: ignore[no-untyped-def]
    """Distance from the sonar to the wall as it reads it [m]."""
    return as_read(p[STANDOFF] - s[0], p)


@term
def position(t, s, ds, p):  # type: ignore[no-untyped-def]
    """Distance made good ahead [m]."""
    return s[0]


@term
def speed(t, s, ds, p):  # type: ignore[no-untyped-def]
    """Surge speed [m/s]."""
    return s[1]


CHANNELS = (
    Channel("range_m", "m", distance, chained(acting_on("range_m")[::-1], "instant"), coloured=True),
    Channel("position_m", "m", position),
    Channel("surge_m_s", "m/s", speed),
)
