"""Mapping files: which field of which message becomes which column, in what unit, sign and frame.

    preset = "ros"                   # what else vtank finds by itself in such logs

    [[channel]]
    message = "/thrusters/port"      # message or topic; * stands for anything
    field = "data"                   # rpm[2], twist.twist.linear.x
    column = "port_rev_s"
    unit = "rpm"                     # of the log; default: the column's own
    sign = -1                        # or scale; and offset, in the column's unit

    [[channel]]
    type = "nav_msgs/msg/Odometry"   # all topics of a type
    fields = ["pose.pose.position.x", "pose.pose.position.y", "pose.pose.position.z"]
    columns = ["north_m", "east_m", "depth_m"]
    frame = "ENU"

Three fields with a frame are a vector; four are a quaternion w, x, y, z that becomes three angles; two in the frame
"WGS84" are latitude and longitude in degrees. Earth velocities in body columns are turned by the log's own attitude.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ..record.columns import column, unknown
from ..record.run import INPUTS
from ..record.table import Table, open_table
from .frames import ATTITUDE, BODY, EARTH
from .mapping import HEADER, PRESETS, WGS84, Armed, Channel, Mapping, Pulses, column_unit
from .units import UNITS, factor

KEYS = ("message", "type", "field", "fields", "column", "columns", "unit", "sign", "scale", "offset", "frame", "where",
        "outputs", "first", "instance", "stop_us", "full_us", "one_way", "parameters", "motor_function")  # fmt: skip
OUTPUTS = 64  # of an autopilot, at most; a choice
PARAMETERS = ("stop_us", "full_us", "function", "sign")


def read_mapping(path: Path | str) -> Mapping:
    """The mapping in a TOML file; InputError names file and key."""
    path = Path(path)
    file = open_table(path).check_keys(("channel", "several", "armed", "time", "preset"))
    brought = path.parent == PRESETS
    channels = [replace(each, optional=brought) for table in file.tables("channel") for each in _channels(table)]
    if not channels:
        raise file.error("channel", "expected at least one [[channel]]")
    several = _flag(file, "several")
    columns = [name for each in channels for name in each.columns if not each.output]
    twice = next((name for name in columns if columns.count(name) > 1), "")
    if twice and not several and not brought:
        raise file.error("channel", f"column '{twice}' is given twice; write several = true if they are two sensors")
    armed = _armed(file.table("armed")) if file.has("armed") else None
    time = _time(file.table("time")) if file.has("time") else None
    own = Mapping(path, tuple(channels), several, armed, time, brought)
    return _laid_over(own, file) if file.has("preset") else own


def _laid_over(own: Mapping, file: Table) -> Mapping:
    """A mapping with what a preset finds beside it."""
    name = file.choice("preset", (*sorted(each.stem for each in PRESETS.glob("*.toml")), HEADER))
    if name == HEADER:
        return replace(own, header=True)
    base = read_mapping(PRESETS / f"{name}.toml")
    several, armed = own.several or base.several, own.armed or base.armed
    return replace(own, channels=own.channels + base.channels, several=several, armed=armed)


def _time(table: Table) -> tuple[str, str]:
    table.check_keys(("field", "unit"))
    unit = table.text("unit", "s")
    if factor(unit, "s") is None:
        raise table.error("unit", f"'{unit}' is no unit of time; there are: {', '.join(UNITS['s'])}")
    return table.text("field"), unit


def _armed(table: Table) -> Armed:
    table.check_keys(("message", "field", "where", "bit", "value", "changes"))
    return Armed(
        table.text("message"), table.text("field"), _numbers(table, "where"), table.integer("bit", 0),
        table.number("value", 1.0), _flag(table, "changes"),
    )  # fmt: skip


def _channels(table: Table) -> list[Channel]:
    table.check_keys(KEYS)
    fields = table.texts("fields") if table.either("field", "fields") == "fields" else (table.text("field"),)
    columns = table.texts("columns") if table.either("column", "columns") == "columns" else (table.text("column"),)
    frame = table.choice("frame", (*EARTH, *BODY, *ATTITUDE, WGS84, ""), "")
    _check_shape(table, fields, columns, frame)
    pulses = _pulses(table) if table.text("unit", "") == "us" else None
    outputs = table.integer("outputs", 0, 0, OUTPUTS)
    for name in columns:
        _check_column(table, name.replace("{n}", "1"), pulses is not None)
    channel = Channel(
        message=table.text("message", ""),
        type=table.text("type", ""),
        fields=fields,
        columns=columns,
        unit="" if pulses else table.text("unit", ""),
        scale=table.number("scale", 1.0) * _sign(table),
        offset=table.number("offset", 0.0),
        frame=frame,
        where=_numbers(table, "where"),
        pulses=pulses,
        parameters=_parameters(table),
        motor_function=table.integer("motor_function", 0),
    )
    if not (channel.message or channel.type):
        raise table.error("message", "missing; expected the name of a message or topic, or a 'type'")
    first, instance = table.integer("first", 1, 1, 1000), table.text("instance", "")
    return [_numbered(channel, first, n, instance) for n in range(first, first + outputs)] if outputs else [channel]


def _numbered(channel: Channel, first: int, n: int, instance: str) -> Channel:
    """Output n of an actuator message whose first one is `first`: {n} is n, {n0} counts from 0, as `instance` does."""
    fields = tuple(name.replace("{n}", str(n)).replace("{n0}", str(n - first)) for name in channel.fields)
    where = dict(channel.where) | ({instance: float(n - first)} if instance else {})
    return replace(channel, fields=fields, output=n, where=where)


def _check_shape(table: Table, fields: tuple[str, ...], columns: tuple[str, ...], frame: str) -> None:
    """Refuse numbers of fields and columns that do not go together in a frame."""
    expected = (4, 3) if frame in ATTITUDE else (2, 2) if frame == WGS84 else (3, 3) if frame else (1, 1)
    if (len(fields), len(columns)) != expected:
        what = f"frame '{frame}'" if frame else "no frame"
        found = f"{len(fields)} and {len(columns)}"
        raise table.error(
            "fields", f"expected {expected[0]} fields and {expected[1]} columns with {what}, found {found}"
        )


def _check_column(table: Table, name: str, pulses: bool) -> None:
    if name not in INPUTS and column(name) is None:
        raise table.error("column", unknown(name))
    unit, written = column_unit(name), table.text("unit", "")
    if pulses and unit != "-":
        raise table.error("column", f"pulse lengths [us] become NAME_command, found '{name}'")
    if written and not pulses and factor(written, unit) is None:
        raise table.error("unit", f"'{written}' is no unit of '{name}'; there are: {', '.join(UNITS[unit])}")


def _pulses(table: Table) -> Pulses:
    pulses = Pulses(table.number("stop_us", 1500.0), table.number("full_us", 1900.0), _flag(table, "one_way"))
    if pulses.stop_us == pulses.full_us:
        raise table.error("full_us", f"expected another length than stop_us, {pulses.stop_us:g}")
    return pulses


def _parameters(table: Table) -> dict[str, str]:
    names = table.table("parameters").check_keys(PARAMETERS)
    return {key: names.text(key) for key in names.entries}


def _sign(table: Table) -> float:
    sign = table.number("sign", 1.0)
    if abs(sign) != 1.0:
        raise table.error("sign", f"expected 1 or -1, found {sign:g}; 'scale' takes any number")
    return sign


def _flag(table: Table, key: str) -> bool:
    value = table.entries[key] if table.has(key) else False
    if not isinstance(value, bool):
        raise table.error(key, f"expected true or false, found {value!r}")
    return value


def _numbers(table: Table, key: str) -> dict[str, float]:
    inner = table.table(key)
    return {name: inner.number(name) for name in inner.entries}
