"""A sensor as a vehicle file has it: what it measures, where it sits, how often and how well."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..record.columns import MOTION
from ..record.table import Table
from ..record.toml import meant

KEYS = ("channels", "position_m", "rotation_deg", "rate_hz", "noise", "latency_s", "dropout")
CHANNELS = tuple(name for name in MOTION if name != "position_m")


@dataclass(frozen=True)
class Sensor:
    """Channels that one instrument measures, each a column NAME.CHANNEL of a recording.

    Attributes:
        name: of the instrument.
        channels: of CHANNELS.
        position_m: in body axes [m].
        rotation_deg: roll, pitch and yaw that turn the body's axes into the sensor's, yaw first [deg].
        rate_hz: [Hz].
        noise: standard deviation of white noise, of each channel in its own unit.
        latency_s: from the measurement to its time in the recording [s].
        dropout: share of the samples that are lost.
    """

    name: str
    channels: tuple[str, ...]
    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rate_hz: float = 10.0
    noise: tuple[float, ...] = ()
    latency_s: float = 0.0
    dropout: float = 0.0

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Takes the sensor's axes to the body's, shape (3, 3)."""
        (cr, cp, cy), (sr, sp, sy) = (f(np.radians(self.rotation_deg)) for f in (np.cos, np.sin))
        yaw = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
        pitch = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
        roll = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
        return yaw @ pitch @ roll


def read_sensors(table: Table) -> tuple[Sensor, ...]:
    """The [sensor.NAME] of a vehicle file; InputError names file and key."""
    return tuple(_sensor(name, table.table(name)) for name in table.entries)


def _sensor(name: str, table: Table) -> Sensor:
    table.check_keys(KEYS)
    channels = table.texts("channels")
    for channel in channels:
        if channel not in CHANNELS:
            raise table.error("channels", f"unknown channel '{channel}'" + meant(channel, CHANNELS))
    noise = table.numbers("noise", 0.0, 1e6) if table.has("noise") else (0.0,) * len(channels)
    if len(noise) != len(channels):
        raise table.error("noise", f"expected {len(channels)} numbers, one for each channel, found {len(noise)}")
    zero = (0.0, 0.0, 0.0)
    return Sensor(
        name=name,
        channels=channels,
        position_m=table.vector("position_m") if table.has("position_m") else zero,
        rotation_deg=table.vector("rotation_deg") if table.has("rotation_deg") else zero,
        rate_hz=table.positive("rate_hz", None, 1e4),
        noise=noise,
        latency_s=table.number("latency_s", 0.0, 0.0),
        dropout=table.number("dropout", 0.0, 0.0, 0.999),
    )
