"""What instruments write of what is true: rate, latency, clock, noise, bias, resolution and lost samples of each.

What is random is drawn before the flight, so that a pilot on board reads the very numbers that are recorded; but
an acceleration at the moment of a command is that of just before it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..plant.sensor import Sensor

if TYPE_CHECKING:
    from ..tank.flight import Flight  # MuJoCo takes a while to load

Array = NDArray[np.float64]
TICK = 9  # decimals of a time [s], so that two instruments that sample at one moment share a row; a choice
WRAPPED = ("roll_rad", "heading_rad")  # channels within -pi..pi
NOW = 1e-9  # [s] by which a sample may lie ahead, by rounding


class Instrument:
    """A sensor on a flight of some duration: when it samples, and the errors of its samples.

    Attributes:
        stamps: times in the recording, by its own clock, shape (K,) [s].
        taken: when that is by the others' clock; instants: when it was true, latency_s before [s].
        kept: whether a sample is not lost.
    """

    def __init__(self, sensor: Sensor, duration_s: float, seed: int) -> None:
        """duration_s: the longest that the flight may last; seed: of noise and lost samples."""
        rng = np.random.default_rng([seed, *sensor.name.encode()])
        slow = 1.0 + sensor.clock_skew
        last = (duration_s + sensor.clock_offset_s) / slow
        stamps = np.arange(np.floor(last * sensor.rate_hz * (1.0 + 1e-12)) + 1.0) / sensor.rate_hz
        instants = stamps * slow - sensor.clock_offset_s - sensor.latency_s
        there = instants >= -NOW
        self.sensor, self.stamps = sensor, np.round(stamps[there], TICK)
        self.taken = self.stamps * slow - sensor.clock_offset_s
        self.instants = self.taken - sensor.latency_s
        self.kept = rng.random(self.stamps.size) >= sensor.dropout
        noise = sensor.each("noise")
        self._errors = [size * rng.standard_normal(self.stamps.size) for size in noise]
        if sensor.echo[1] > 0.0:
            long = sensor.echo[0] * (rng.random(self.stamps.size) < sensor.echo[1])
            self._errors[sensor.channels.index("range_m")] += long

    def written(self, channel: str, true: Array, rows: slice) -> Array:
        """What it writes of a channel that is truly so at some of its samples, shape (n,); NaN for no echo."""
        number, sensor = self.sensor.channels.index(channel), self.sensor
        scale, bias, resolution = (sensor.each(name)[number] for name in ("scale", "bias", "resolution"))
        values = true + self._errors[number][rows] + bias
        if channel in WRAPPED:
            values = (values + np.pi) % (2.0 * np.pi) - np.pi
        values = values * scale
        if resolution > 0.0:
            values = np.round(values / resolution) * resolution
        return np.where(values < 0.0, np.nan, values) if channel == "range_m" else values

    def record(self, time_s: Array, true: Mapping[str, Array]) -> dict[str, tuple[Array, Array]]:
        """Its columns, of what is true at the times of the steps, (T,): column -> stamps [s] and values.

        Times that are not a step's are interpolated; a sample that was taken after the last step is not there.
        """
        flown, columns = slice(0, int(np.searchsorted(self.taken, time_s[-1] + NOW))), {}
        for channel in self.sensor.channels:
            values = self.written(channel, np.interp(self.instants[flown], time_s, true[channel]), flown)
            there = self.kept[flown] & np.isfinite(values)
            if there.any():
                columns[f"{self.sensor.name}.{channel}"] = self.stamps[flown][there], values[there]
        return columns


class Readings(Mapping[str, float]):
    """What is known on board at one instant: SENSOR.CHANNEL -> its last sample; absent before the first."""

    def __init__(self, flight: Flight, instruments: Mapping[str, Instrument]) -> None:
        """Of a flight that stands before its next step, whose sensors have measured there."""
        self._flight, self._instruments = flight, instruments
        self._true: dict[str, Mapping[str, Array]] = {}

    def __getitem__(self, column: str) -> float:
        """The last sample that was not lost; KeyError where there is none yet, or no such channel."""
        name, _, channel = column.partition(".")
        instrument = self._instruments[name]
        if channel not in instrument.sensor.channels:
            raise KeyError(column)
        now_s = self._flight.done * self._flight.step_s
        arrived = int(np.searchsorted(instrument.taken, now_s + NOW))
        kept = np.flatnonzero(instrument.kept[:arrived])
        if not kept.size:
            raise KeyError(column)
        last = int(kept[-1])
        step = min(int((instrument.instants[last] + NOW) / self._flight.step_s), self._flight.done)
        rows = slice(step, min(step + 2, self._flight.done + 1))
        if name not in self._true:
            self._true[name] = self._flight.true(rows, name)[name]
        at = np.arange(rows.start, rows.stop) * self._flight.step_s
        value = np.interp(instrument.instants[last : last + 1], at, self._true[name][channel])
        return float(instrument.written(channel, value, slice(last, last + 1))[0])

    def __iter__(self) -> Iterator[str]:
        """All columns that have a sample."""
        for name, instrument in self._instruments.items():
            for channel in instrument.sensor.channels:
                try:
                    self[f"{name}.{channel}"]
                except KeyError:
                    continue
                yield f"{name}.{channel}"

    def __len__(self) -> int:
        """Number of columns that have a sample."""
        return sum(1 for _ in self)
