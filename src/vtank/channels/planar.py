"""What is measured of a vehicle in the horizontal plane: place, heading, velocity, turn rate, accelerations."""

from __future__ import annotations

from ..compiled import term
from .channel import Channel, reads_state


@term
def ahead(t, s, ds, p):
    """Specific force along body x at the origin [m/s2]: du/dt - v r."""
    return ds[3] - s[4] * s[5]


@term
def starboard(t, s, ds, p):
    """Specific force along body y at the origin [m/s2]: dv/dt + u r."""
    return ds[4] + s[3] * s[5]


CHANNELS = (
    *(Channel(name, unit, reads_state(i), state=i) for i, (name, unit) in enumerate((
        ("north_m", "m"), ("east_m", "m"), ("heading_rad", "rad"),
        ("surge_m_s", "m/s"), ("sway_m_s", "m/s"), ("yaw_rate_rad_s", "rad/s"),
    ))),
    Channel("accel_x_m_s2", "m/s2", ahead, of_rates=True),
    Channel("accel_y_m_s2", "m/s2", starboard, of_rates=True),
)  # fmt: skip
