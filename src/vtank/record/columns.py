"""The columns of a recording of a whole vehicle: what each is called, its unit, and what its values may be.

Body axes x forward, y starboard, z down; earth axes north, east, down; heading grows to starboard. What thrusters and
control surfaces were asked for is called after them: NAME_rev_s, NAME_command, NAME_N, NAME_rad; NAME_A is a thruster's
current. Of two sensors that measure the same, each has its name before it: dvl.surge_m_s, gps.surge_m_s.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

Role = Literal["input", "output", "state"]
ALIKE = 0.9  # of 1: a column that nearly has the name of another is taken for a slip; a choice


@dataclass(frozen=True)
class Column:
    """Unit and role of a column, and the largest value that is believed in it, either way."""

    unit: str
    role: Role
    most: float


# Largest values are guesses, far beyond any vehicle; an angle that turns on may count many turns.
WRENCH = {f"{axis}_N": Column("N", "input", 1e8) for axis in ("surge", "sway", "heave")} | {
    f"{axis}_Nm": Column("N m", "input", 1e10) for axis in ("roll", "pitch", "yaw")
}
MOTION = {
    "range_m": Column("m", "output", 1e8),
    "position_m": Column("m", "output", 1e8),
    "north_m": Column("m", "output", 1e8),
    "east_m": Column("m", "output", 1e8),
    "depth_m": Column("m", "output", 2e4),
    "roll_rad": Column("rad", "output", 1e4),
    "pitch_rad": Column("rad", "output", 7.0),
    "heading_rad": Column("rad", "output", 1e4),
    "surge_m_s": Column("m/s", "output", 200.0),
    "sway_m_s": Column("m/s", "output", 200.0),
    "heave_m_s": Column("m/s", "output", 200.0),
    "roll_rate_rad_s": Column("rad/s", "output", 100.0),
    "pitch_rate_rad_s": Column("rad/s", "output", 100.0),
    "yaw_rate_rad_s": Column("rad/s", "output", 100.0),
    "accel_x_m_s2": Column("m/s2", "output", 1e4),
    "accel_y_m_s2": Column("m/s2", "output", 1e4),
    "accel_z_m_s2": Column("m/s2", "output", 1e4),
}
ATTITUDE = ("roll_rad", "pitch_rad", "heading_rad")
RATES = ("roll_rate_rad_s", "pitch_rate_rad_s", "yaw_rate_rad_s")
VELOCITY = ("surge_m_s", "sway_m_s", "heave_m_s")
SPEEDS = (*VELOCITY, *RATES)
ACCELERATION = ("accel_x_m_s2", "accel_y_m_s2", "accel_z_m_s2")
FIXED = WRENCH | MOTION | {"battery_V": Column("V", "state", 1e4)}
NAMED = {  # ending of a column that begins with the name of a thruster or a control surface
    "_rev_s": Column("rev/s", "input", 200.0),
    "_command": Column("-", "input", 1.0),
    "_N": Column("N", "input", 1e8),
    "_rad": Column("rad", "input", 7.0),
    "_A": Column("A", "state", 1e4),
}


def channel_of(name: str) -> str:
    """The channel that a column holds, without its sensor."""
    return name.rpartition(".")[2]


def column(name: str) -> Column | None:
    """What a column holds, by its name; None where no such column is known, or a known one seems to be meant."""
    sensor, dot, channel = name.rpartition(".")
    if dot:
        return MOTION.get(channel) if sensor else None
    if name in FIXED:
        return FIXED[name]
    if difflib.get_close_matches(name, FIXED, 1, ALIKE):
        return None
    return next((NAMED[end] for end in NAMED if name.endswith(end) and name != end), None)


def candidates(name: str) -> Iterable[str]:
    """Names of columns that an unknown one may have been meant to be, with its own sensor's or thruster's name."""
    sensor, dot, _ = name.rpartition(".")
    owners = {name.rsplit("_", parts)[0] for parts in (1, 2)}
    names = [sensor + dot + known for known in (MOTION if dot else FIXED)] + [o + end for o in owners for end in NAMED]
    return [known for known in names if column(known)]


def unknown(name: str) -> str:
    """What to say of a column that is not known: the nearest that is, and where the others stand."""
    nearest = difflib.get_close_matches(name, candidates(name), 1, 0.6)
    meant = f"did you mean '{nearest[0]}'? " if nearest else ""
    endings = ", ".join(f"NAME{ending}" for ending in NAMED)
    return f"unknown column '{name}'; {meant}there are: {endings}, SENSOR.CHANNEL, {', '.join(FIXED)}"
