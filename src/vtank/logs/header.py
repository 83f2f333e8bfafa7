"""What the headers of tables mean: "Heading (deg)", "port rpm", "yaw_rate [°/s]", "Thruster 1 [%]"."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..record.columns import FIXED, MOTION, column
from ..record.run import INPUTS, OUTPUTS, TIME
from ..record.suffix import UNITS as SUFFIXES
from .log import Log
from .mapping import Channel, Mapping, Pulses, column_unit
from .units import UNITS, factor

TIMES = {"time", "t", "timestamp", "time_stamp", "elapsed", "elapsed_time", "seconds", "date_time", "datetime"}
TIME_UNIT = {"ms": "ms", "us": "us", "ns": "ns", "time_ms": "ms", "time_us": "us", "timeus": "us", "sec": "s"}
WORDS = {  # other words for what a column measures
    "yaw": "heading", "psi": "heading", "hdg": "heading", "compass": "heading", "course": "heading",
    "phi": "roll", "theta": "pitch", "northing": "north", "easting": "east", "sonar": "range", "distance": "range",
    "u": "surge", "v": "sway", "w": "heave", "surge_speed": "surge", "surge_velocity": "surge", "sway_speed": "sway",
    "sway_velocity": "sway", "heave_speed": "heave", "heave_velocity": "heave",
    "p": "roll_rate", "q": "pitch_rate", "r": "yaw_rate", "gyro_x": "roll_rate", "gyro_y": "pitch_rate",
    "gyro_z": "yaw_rate", "rate_of_turn": "yaw_rate", "heading_rate": "yaw_rate", "yawrate": "yaw_rate",
    "ax": "accel_x", "ay": "accel_y", "az": "accel_z", "acc_x": "accel_x", "acc_y": "accel_y", "acc_z": "accel_z",
    "voltage": "battery", "battery_voltage": "battery", "vbat": "battery",
}  # fmt: skip
FILLERS = set(
    "to the of from at in a wall ahead below surface water vehicle hull auv rov boat sensor measured "
    "reading value angle actual raw filtered".split()
)  # words of a header that change nothing of it
STEMS = {  # (what, its unit) -> column
    (name.removesuffix("_" + known.unit.replace("/", "_").replace(" ", "")), known.unit): name
    for name, known in (MOTION | FIXED).items()  # without a unit motion is meant, and no force
}
ASKED = {"rev/s": "_rev_s", "-": "_command", "N": "_N", "A": "_A"}  # unit -> ending of a thruster's column
ALONE = {"rev/s": "n_rev_s", "-": "command", "N": "thrust_N"}  # the same without a thruster's name
DRIVES = re.compile(
    "thrust|motor|prop|port|starboard|command|cmd|throttle|esc"
)  # words in what is driven, for a bare share
SURFACE = re.compile("rudder|fin|plane|elevator|flap")
DEGREES = {"rad": "deg", "rad/s": "deg/s"}
TURN = 7.0  # [rad] more than a turn, which no angle of a vehicle in radians exceeds at first sight; a choice
PULSE = Pulses(1500.0, 1900.0, False)  # [us] as ArduSub's
ONLY = {"propeller", "prop", "motor", "thruster", "engine", "shaft", "drive"}  # names of a drive that has no fellow
SAID = re.compile(r"_?(rpm|rev_s|speed|pwm|command|cmd|throttle|thrust|force|current|angle|setpoint|us)$")


def parse(header: str) -> tuple[str, str]:
    """What a header names, in small letters and underscores, and its unit as written; "" where it has none."""
    name, unit = _in_brackets(header.strip())
    if not unit:
        for suffix, written in SUFFIXES.items():
            if re.sub(r"\s", "_", name).lower().endswith(suffix.lower()) and len(name) > len(suffix):
                name, unit = name[: -len(suffix)], written
                break
        else:
            last = name.rsplit(None, 1)
            if len(last) == 2 and any(factor(last[1], known) for known in UNITS):
                name, unit = last[0], last[1]
    return re.sub(r"\W+", "_", name.strip().lower()).strip("_"), unit


def _in_brackets(text: str) -> tuple[str, str]:
    """What stands before the brackets at the end of a text, and within them; "" where it has none."""
    start = max(text.rfind("["), text.rfind("("))
    inside = text[start + 1 : -1]
    if start < 0 or not text.endswith(("]", ")")) or {*inside} & {*"])"}:
        return text, ""
    return text[:start].rstrip(), inside.strip()


def channel(header: str, message: str) -> Channel | None:
    """The column that a header means; None where it means none."""
    if column(header) or header in INPUTS:
        return _channel(message, header, header, "")
    if header == TIME:
        return None
    stem, unit = parse(header)
    what = _meant(stem)
    for (known, si), name in STEMS.items():
        if what == known and (not unit or factor(unit, si) is not None):
            return _channel(message, header, name, unit)
        if known in (f"{what}_rate", f"{stem}_rate") and unit and factor(unit, si) is not None:
            return _channel(message, header, name, unit)
    return _actuator(message, header, stem, unit)


def channels(headers: Sequence[str], message: str, named: bool) -> tuple[Channel, ...]:
    """The columns that a table's headers mean; `named` where a vehicle file names the thrusters.

    Else one drive that is called no more than a propeller, beside what moves along one axis, is that axis' input.
    """
    found = [each for header in headers if (each := channel(header, message))]
    drives = [each for each in found if (known := column(each.columns[0])) and known.role == "input"]
    others = {each.columns[0] for each in found if each not in drives}
    if not named and len(drives) == 1 and others <= {*OUTPUTS, "battery_V"}:
        for ending, alone in ((end, ALONE.get(si)) for si, end in ASKED.items()):
            if alone and drives[0].columns[0].removesuffix(ending) in ONLY:
                found[found.index(drives[0])] = replace(drives[0], columns=(alone,))
    return tuple(found)


def _meant(stem: str) -> str:
    """What a header's words measure, the fillers among them left out; where they say several things, the words."""
    known = {name for name, _ in STEMS} | WORDS.keys()
    if stem in known:
        return WORDS.get(stem, stem)
    words = [word for word in stem.split("_") if word not in FILLERS]
    said = {WORDS.get(word, word) for word in words} if set(words) <= known else {WORDS.get("_".join(words), "")}
    return said.pop() if len(said) == 1 else stem


def settled(mapping: Mapping, log: Log, message: str) -> Mapping:
    """The mapping of a table with the units of angles that its header leaves open: degrees where one exceeds a turn."""
    stream = log.streams[message]
    unsaid = [
        c
        for c in mapping.channels
        if c.optional and not c.unit and c.columns != c.fields and column_unit(c.columns[0]) in DEGREES
    ]
    if not unsaid:
        return mapping
    most = max(float(np.nanmax(np.abs(stream.samples(c.fields[0])), initial=0.0)) for c in unsaid)
    named = ", ".join(c.fields[0] for c in unsaid)
    log.remarks.append(f"{named}: no unit, taken for {'degrees' if most > TURN else 'radians'}")
    if most <= TURN:
        return mapping
    units = {c.fields: DEGREES[column_unit(c.columns[0])] for c in unsaid}
    return replace(mapping, channels=tuple(replace(c, unit=units.get(c.fields, c.unit)) for c in mapping.channels))


def _actuator(message: str, header: str, stem: str, unit: str) -> Channel | None:
    """A thruster or a control surface, by the unit that only these have."""
    owner = SAID.sub("", stem)
    if unit in ("us", "µs") or (not unit and re.search(r"pwm$", stem)):
        return _channel(message, header, f"{owner}_command" if owner else "command", "", PULSE)
    if SURFACE.search(stem) and factor(unit, "rad") is not None:
        return _channel(message, header, f"{owner}_rad", unit)
    for si, ending in ASKED.items():
        if unit and factor(unit, si) is not None and (si != "-" or DRIVES.search(stem)):
            name = f"{owner}{ending}" if owner else ALONE.get(si, "")
            return _channel(message, header, name, unit) if column(name) or name in INPUTS else None
    if unit == "" and stem == "rpm":
        return _channel(message, header, "n_rev_s", "rpm")
    return None


def _channel(message: str, header: str, name: str, unit: str, pulses: Pulses | None = None) -> Channel:
    return Channel(message, "", (header,), (name,), unit, pulses=pulses, optional=True)
