"""What a log holds, by a mapping, as columns of a run: SI, vtank's axes, each channel with the times of its own."""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass, field, replace
from os.path import commonprefix

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..plant.vehicle import Vehicle
from ..record.columns import ATTITUDE, VELOCITY, WRENCH, channel_of
from . import frames
from .log import Log, Stream, field_names
from .mapping import WGS84, Armed, Channel, Mapping, Pulses

Array = NDArray[np.float64]
BACK_S = 1.0  # [s] by which samples of a log may be out of order; a choice
MOTORS = 8  # outputs of an autopilot that may drive motors, whose functions have numbers in a row


@dataclass
class Columns:
    """Columns as they are found.

    Attributes:
        samples: column -> times [s] and values [unit in the name], shape (K,) each.
        taken: message and field of all that became columns.
        origin: column -> message and fields that it was made of.
        remarks: what was left out or taken for granted, in words.
        armed: share of the recording in which motors were allowed to turn; None where nothing tells.
    """

    samples: dict[str, tuple[Array, Array]] = field(default_factory=dict)
    origin: dict[str, str] = field(default_factory=dict)
    taken: set[tuple[str, str]] = field(default_factory=set)
    remarks: list[str] = field(default_factory=list)
    armed: float | None = None


def columns(log: Log, mapping: Mapping, vehicle: Vehicle | None = None) -> Columns:
    """The columns that a mapping makes of a log; thrusters are called as in the vehicle file, where one is given.

    InputError where a mapping file of the user's own names a message or a field that the log has not.
    """
    found = Columns()
    if mapping.armed:
        found.armed = _armed(log, mapping.armed)
    earthly: list[tuple[str, tuple[str, ...], Array, Array]] = []
    for channel in mapping.channels:
        streams = {name: each for name, each in log.streams.items() if channel.takes(name, each.kind) and each.time_s}
        if not streams and not channel.optional:
            raise InputError(f"{mapping.path}: {_missing(log, channel)}")
        for name, stream in streams.items():
            # a preset for ROS takes z for up, as it is in most topics
            made = replace(channel, frame=frames.DOWN[channel.frame]) if _down(channel, stream) else channel
            time_s, values = _values(log, made, stream, found)
            if not np.isfinite(values).any():
                if not made.optional:
                    raise InputError(f"{mapping.path}: {_no_numbers(made, name, stream)}")
                continue
            names = _names(log, mapping, made, name, vehicle)
            if not names or (not mapping.several and set(names) & set(found.samples)):
                continue
            if (said := _goes_back(name, time_s)) and said not in found.remarks:
                found.remarks.append(said)
            if made.frame in frames.EARTH and made.columns == VELOCITY:
                earthly.append((name, names, time_s, values))
            for column, row in zip(names, values, strict=True):
                found.samples[column] = time_s, row
                found.origin[column] = f"{name} {_source(made, stream)}"
            found.taken |= {(name, each) for each in made.fields}
    for name, names, time_s, values in earthly:
        _turn(found, name, names, time_s, values)
    found.samples = {column: tidy for column, each in found.samples.items() if (tidy := _tidy(*each))[0].size}
    _sign(found)
    functions = {
        c.parameters["function"].replace("{n}", str(c.output)) for c in mapping.channels if "function" in c.parameters
    }
    if functions and not functions & log.parameters.keys():
        found.remarks.append(
            f"no parameter tells what outputs drive: those from 1 to {MOTORS} are taken for the motors"
        )
    return found


def _down(channel: Channel, stream: Stream) -> bool:
    """Whether a topic has z down by the name of its frame, and the channel is none of the user's own."""
    return stream.down and channel.optional and channel.frame in frames.DOWN


def _names(log: Log, mapping: Mapping, channel: Channel, name: str, vehicle: Vehicle | None) -> tuple[str, ...]:
    """What the columns of a channel are called; none for an output that drives no thruster."""
    names = channel.columns
    if channel.output:
        motor = _motor(log, channel)
        if not motor:
            return ()
        names = tuple(each.replace("{n}", str(motor)) for each in names)
        if vehicle and names[0].startswith(f"thruster_{motor}_"):
            names = (_of_vehicle(vehicle, motor, names[0]),)
    others = [
        other
        for other, stream in log.streams.items()
        for each in mapping.channels
        if other != name and stream.time_s and each.takes(other, stream.kind) and set(each.columns) & set(names)
    ]
    if mapping.several and others and not set(names) & set(WRENCH):
        sensor = re.sub(r"\W+", "_", name).strip("_")
        names = tuple(f"{sensor}.{each}" for each in names)
    return names


def _motor(log: Log, channel: Channel) -> int:
    """The number of the motor that an output drives, 0 for none; outputs are motors where no parameter tells."""
    parameter = channel.parameters.get("function", "")
    function = log.parameters.get(parameter.replace("{n}", str(channel.output)))
    if function is None:
        return channel.output if not parameter or channel.output <= MOTORS else 0
    motor = int(function) - channel.motor_function + 1
    return motor if 1 <= motor <= MOTORS else 0


def _of_vehicle(vehicle: Vehicle, motor: int, name: str) -> str:
    """The column of the vehicle's thruster of that number."""
    if motor > len(vehicle.thrusters):
        raise InputError(f"{vehicle.path}: has {len(vehicle.thrusters)} thrusters, the log has motor {motor}")
    thruster = vehicle.thrusters[motor - 1]
    return thruster.name + name.removeprefix(f"thruster_{motor}")


def _values(log: Log, channel: Channel, stream: Stream, found: Columns) -> tuple[Array, Array]:
    """Times, shape (K,), and values of each column, shape (columns, K), NaN where there is none."""
    kept = np.ones(len(stream.time_s), dtype=bool)
    for name, expected in channel.where.items():
        values = stream.samples(name)
        kept &= np.isnan(values) | (values == expected)
    time_s = np.array(stream.time_s)[kept]
    raw = np.array([stream.samples(name)[kept] for name in channel.fields])
    if channel.frame in frames.ATTITUDE:
        turned = frames.angles(raw, channel.frame)
        lost = int(np.isnan(turned[0]).sum() - np.isnan(raw).any(axis=0).sum())
        if lost:
            found.remarks.append(f"{lost} quaternions of {', '.join(channel.fields)} are not of length 1: left out")
        return time_s, turned
    if channel.pulses:
        return time_s, _commands(log, channel, channel.pulses, raw)
    if channel.frame == WGS84:
        there = np.isfinite(raw).all(axis=0)
        return time_s[there], frames.local(*np.radians(raw[:, there])) if there.any() else raw[:, there]
    values = np.array([channel.factor(k) * row for k, row in enumerate(raw)]) + channel.offset
    return time_s, frames.vector(values, channel.frame) if channel.frame else values


def _commands(log: Log, channel: Channel, pulses: Pulses, raw: Array) -> Array:
    """Commands -1..1 of pulse lengths [us], NaN where there is no pulse."""
    motor = str(_motor(log, channel))
    told = {
        key: log.parameters.get(name.replace("{n}", str(channel.output)).replace("{motor}", motor))
        for key, name in channel.parameters.items()
    }
    stop, full = told.get("stop_us") or pulses.stop_us, told.get("full_us") or pulses.full_us
    if full == stop:  # parameters of an output that nobody set
        stop, full = pulses.stop_us, pulses.full_us
    asked = (raw - stop) / (full - stop) * (told.get("sign") or 1.0) * channel.scale + channel.offset
    least = 0.0 if pulses.one_way else -1.0
    return np.where(raw > 0.0, np.clip(asked, least, 1.0), np.nan)


def _source(channel: Channel, stream: Stream) -> str:
    """The fields of a channel in short, with the frame that they were turned from, or the range of the pulses."""
    within = commonprefix(channel.fields) if len(channel.fields) > 1 else ""
    text = within[:-1] if within.endswith((".", "[")) else ", ".join(channel.fields)
    if channel.pulses:
        lengths = stream.samples(channel.fields[0])
        text += f", {lengths[lengths > 0.0].min():g} to {lengths[lengths > 0.0].max():g} us"
    return f"{text} ({channel.frame})" if channel.frame else text


def _turn(found: Columns, name: str, names: tuple[str, ...], time_s: Array, values: Array) -> None:
    """Turn earth velocities into body axes by the attitude that was found, interpolated; none without an attitude."""
    attitude = [next((c for c in found.samples if channel_of(c) == angle), "") for angle in ATTITUDE]
    if not all(attitude):
        for column in names:
            del found.samples[column], found.origin[column]
        found.remarks.append(f"{name}: velocities in earth axes, and no attitude to turn them into body axes: left out")
        return
    turned = frames.to_body(values, np.array([_at(time_s, *_tidy(*found.samples[c])) for c in attitude]))
    for column, row in zip(names, turned, strict=True):
        found.samples[column] = time_s, row
        found.origin[column] += ", turned by the attitude"


def _sign(found: Columns) -> None:
    """Give revolutions that are counted without a sign that of the thruster's command, held to its next sample."""
    for column, (time_s, values) in found.samples.items():
        command_s, command = found.samples.get(f"{column.removesuffix('_rev_s')}_command", (np.empty(0), np.empty(0)))
        if not column.endswith("_rev_s") or not values.size or values.min() < 0.0 or not (command < 0.0).any():
            continue
        row = np.maximum(np.searchsorted(command_s, time_s, side="right") - 1, 0)
        found.samples[column] = time_s, np.where(command[row] < 0.0, -values, values)
        found.remarks.append(f"{column}: counted without a sign; it has that of the command")


def _at(time_s: Array, known_s: Array, angle: Array) -> Array:
    """An angle at other times; NaN before its first sample and after its last."""
    if not known_s.size:
        return np.full(time_s.size, np.nan)
    return np.interp(time_s, known_s, np.unwrap(angle), left=np.nan, right=np.nan)


def _goes_back(name: str, time_s: Array) -> str:
    """What to say of a message whose clock goes back by more than its samples may be out of order; "" of no such."""
    step = np.diff(time_s[np.isfinite(time_s)])
    if not step.size or -step.min() < BACK_S:
        return ""
    often = int(np.sum(step < -BACK_S))
    return (f"{name}: its clock goes back {often} time{'s' * (often > 1)}, by up to {-step.min():.4g} s: several "
            "recordings in one, or past midnight? Its samples are put in the order of their times, and of several at "
            "one time the last is kept")  # fmt: skip


def _tidy(time_s: Array, values: Array) -> tuple[Array, Array]:
    """The finite samples in the order of their times; of several at one time the last."""
    there = np.isfinite(values) & np.isfinite(time_s)
    time_s, values = time_s[there], values[there] + 0.0  # no -0
    order = np.argsort(time_s, kind="stable")
    time_s, values = time_s[order], values[order]
    last = np.append(np.diff(time_s) > 0.0, True)[: time_s.size]
    return time_s[last], values[last]


def _armed(log: Log, armed: Armed) -> float | None:
    """Share of the messages that say that motors may turn; 1 where one tells that this changed; None: nothing tells."""
    stream = log.streams.get(armed.message)
    if stream is None or not stream.time_s:
        return None
    values = stream.samples(armed.field)
    kept = np.isfinite(values)
    for name, expected in armed.where.items():
        kept &= stream.samples(name) == expected
    values = values[kept]
    if not values.size:
        return None
    if armed.changes:
        return 1.0
    return float(np.mean(values.astype(int) & armed.bit != 0 if armed.bit else values == armed.value))


def _missing(log: Log, channel: Channel) -> str:
    """What to say of a channel without messages: that they could not be decoded, or what there is instead."""
    kinds = dict.fromkeys(log.undecoded, "") | {name: stream.kind for name, stream in log.streams.items()}
    for name, kind in kinds.items():
        if name in log.undecoded and channel.takes(name, kind):
            why = log.why.get(name, "unknown why")
            return f"no message '{name}' could be decoded, {log.undecoded[name]} in all ({why})"
    wanted = f"message '{channel.message}'" if channel.message else "message"
    kind = f" of type '{channel.type}'" if channel.type else ""
    nearest = difflib.get_close_matches(channel.message, log.streams, 1, 0.6)
    meant = f"did you mean '{nearest[0]}'? " if nearest else ""
    there = ", ".join(sorted(log.streams)) or "none"
    return f"the log has no {wanted}{kind}; {meant}there are: {there}{log.lost('; ')}"


def _no_numbers(channel: Channel, name: str, stream: Stream) -> str:
    known = field_names(stream.sample)
    strange = [each for each in channel.fields if each not in known]
    if not strange:
        return f"'{name}' has no number in {', '.join(channel.fields)} in any of its {stream.count} messages"
    nearest = difflib.get_close_matches(strange[0], known, 1, 0.6)
    meant = f"did you mean '{nearest[0]}'? " if nearest else ""
    return f"'{name}' has no number {', '.join(strange)}; {meant}its fields: {', '.join(known)}"
