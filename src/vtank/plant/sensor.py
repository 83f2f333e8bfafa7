"""A sensor as a vehicle file has it: what it measures, where it sits, how often and how well."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..record.columns import MOTION
from ..record.table import NAME, NO_NAME, Table
from ..record.toml import meant

EACH = ("noise", "bias", "resolution")  # numbers for each channel, in its own unit
KEYS = (
    "channels",
    "position_m",
    "rotation_deg",
    "rate_hz",
    *EACH,
    "latency_s",
    "clock_skew",
    "clock_offset_s",
    "dropout",
)
CHANNELS = tuple(name for name in MOTION if name != "position_m")


@dataclass(frozen=True)
class Sensor:
    """Channels that one instrument measures, each a column NAME.CHANNEL of a recording.

    Attributes:
        name: of the instrument.
        channels: of CHANNELS.
        position_m: in body axes [m].
        rotation_deg: roll, pitch and yaw that turn the body's axes into the sensor's, yaw first [deg].
        rate_hz: of the readings that are flown [Hz].
        noise: standard deviation of white noise, of each channel in its own unit.
        latency_s: from the measurement to its time in the recording [s].
        dropout: share of the samples that are lost.
        bias: added to each channel, in its own unit.
        resolution: each channel is rounded to a multiple of it, in its own unit; 0 for none.
        clock_skew, clock_offset_s: what is stamped t was measured at t (1 + skew) - offset - latency: a clock that runs
            slow, and one that is ahead [-, s].
        scale: of each channel. earth_axes: whether velocities are along north, east, down. echo: by how much a range
            reads long [m], and in which share of the pings. These three are of effects only, and no file has them.
    """

    name: str
    channels: tuple[str, ...]
    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rate_hz: float = 10.0
    noise: tuple[float, ...] = ()
    latency_s: float = 0.0
    dropout: float = 0.0
    bias: tuple[float, ...] = ()
    resolution: tuple[float, ...] = ()
    clock_skew: float = 0.0
    clock_offset_s: float = 0.0
    scale: tuple[float, ...] = ()
    earth_axes: bool = False
    echo: tuple[float, float] = (0.0, 0.0)

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Takes the sensor's axes to the body's, shape (3, 3)."""
        return matrix_of(np.radians(self.rotation_deg))

    @property
    def late_s(self) -> float:
        """From the measurement to its stamp, by a clock that may be behind [s]."""
        return self.latency_s + self.clock_offset_s

    def each(self, name: str) -> tuple[float, ...]:
        """One of `noise`, `bias`, `resolution`, `scale` with a number for each channel, given or not."""
        return getattr(self, name) or (1.0 if name == "scale" else 0.0,) * len(self.channels)


def matrix_of(roll_pitch_yaw_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation by yaw, then pitch, then roll, that takes turned axes to the ones that they were turned from."""
    (cr, cp, cy), (sr, sp, sy) = (f(roll_pitch_yaw_rad) for f in (np.cos, np.sin))
    yaw = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    pitch = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    roll = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    return yaw @ pitch @ roll


def read_sensors(table: Table) -> tuple[Sensor, ...]:
    """The [sensor.NAME] of a vehicle file; InputError names file and key."""
    for name in table.entries:
        if not NAME.fullmatch(name):
            raise table.error(name, NO_NAME)
    return tuple(_sensor(name, table.table(name)) for name in table.entries)


def changed_sensors(table: Table, sensors: tuple[Sensor, ...]) -> tuple[Sensor, ...]:
    """The sensors with what a scenario's [sensor.NAME] states otherwise; InputError names file and key."""
    names = [sensor.name for sensor in sensors]
    for name in table.entries:
        if name not in names:
            raise table.error(name, "no such sensor" + meant(name, names))
    return tuple(_changed(sensor, table.table(sensor.name)) if table.has(sensor.name) else sensor for sensor in sensors)


def _changed(sensor: Sensor, table: Table) -> Sensor:
    table.check_keys(KEYS[1:])
    as_it_is = {key: getattr(sensor, key) for key in KEYS}
    entries = {key: list(value) if isinstance(value, tuple) else value for key, value in as_it_is.items()}
    return _sensor(sensor.name, replace(table, entries={k: v for k, v in entries.items() if v != []} | table.entries))


def _sensor(name: str, table: Table) -> Sensor:
    table.check_keys(KEYS)
    channels = table.texts("channels")
    for channel in channels:
        if channel not in CHANNELS:
            raise table.error("channels", f"unknown channel '{channel}'" + meant(channel, CHANNELS))
        if channels.count(channel) > 1:
            raise table.error("channels", f"'{channel}' is given twice; expected each channel once")
    zero = (0.0, 0.0, 0.0)
    return Sensor(
        name=name,
        channels=channels,
        position_m=table.vector("position_m") if table.has("position_m") else zero,
        rotation_deg=table.vector("rotation_deg") if table.has("rotation_deg") else zero,
        rate_hz=table.positive("rate_hz", Sensor.rate_hz, 1e4),
        noise=_each(table, "noise", channels, 0.0),
        bias=_each(table, "bias", channels, -1e6),
        resolution=_each(table, "resolution", channels, 0.0),
        latency_s=table.number("latency_s", 0.0, 0.0),
        clock_skew=table.number("clock_skew", 0.0, -0.1, 0.1),
        clock_offset_s=table.number("clock_offset_s", 0.0, -600.0, 600.0),
        dropout=table.number("dropout", 0.0, 0.0, 0.999),
    )


def _each(table: Table, key: str, channels: tuple[str, ...], low: float) -> tuple[float, ...]:
    """A number for each channel, in its own unit; 0 where the file gives none."""
    values = table.numbers(key, low, 1e6) if table.has(key) else (0.0,) * len(channels)
    if len(values) != len(channels):
        raise table.error(key, f"expected {len(channels)} numbers, one for each channel, found {len(values)}")
    return values
