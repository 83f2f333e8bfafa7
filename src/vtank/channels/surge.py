"""What is measured of a vehicle on its surge axis: range to the wall ahead, distance made good, speed."""

from __future__ import annotations

from ..compiled import law
from ..effects import clock_skew, sonar_latency, sonar_offset, sonar_scale
from ..plant.parameters import slot
from ..plant.surge import STANDOFF
from .channel import Channel

LATENCY, SKEW = slot("sonar_latency.d"), slot("clock_skew.s")
SCALE, OFFSET = slot("sonar_scale.s"), slot("sonar_offset.o")


@law
def range_read(t, s, ds, p):  # type: ignore[no-untyped-def]
    """Distance from the sonar to the wall as it reads it [m]."""
    return sonar_offset.reading(sonar_scale.reading(p[STANDOFF] - s[0], p[SCALE]), p[OFFSET])


@law
def echo_instant(stamp, p):  # type: ignore[no-untyped-def]
    """When the echo was made, by the input's clock [s]."""
    return sonar_latency.echo_time(clock_skew.echo_time(stamp, p[SKEW]), p[LATENCY])


@law
def position(t, s, ds, p):  # type: ignore[no-untyped-def]
    """Distance made good ahead [m]."""
    return s[0]


@law
def speed(t, s, ds, p):  # type: ignore[no-untyped-def]
    """Surge speed [m/s]."""
    return s[1]


CHANNELS = (
    Channel("range_m", "m", range_read, echo_instant, coloured=True),
    Channel("position_m", "m", position),
    Channel("surge_m_s", "m/s", speed),
)
