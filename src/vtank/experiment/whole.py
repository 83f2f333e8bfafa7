"""A whole vehicle flown open loop under a table of commands, and recorded by its instruments.

ahead = {"time_s": [0, 5], "thruster_1_command": [0.5, 0.0], "thruster_2_command": [0.5, 0.0]}
run = fly_vehicle("bluerov2", ahead, duration_s=20.0, seed=1)
run.samples("dvl.surge_m_s")
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..plant.sensor import Sensor
from ..plant.vehicle import Vehicle, load_vehicle
from ..record import PAUSE_S, TIME, Run, meant
from ..waves import Waves

Array = NDArray[np.float64]
TICK = 9  # decimals of a time [s], so that two instruments that sample at one moment share a row; a choice


def fly_vehicle(
    vehicle: str | Path | Vehicle,
    commands: Mapping[str, ArrayLike],
    duration_s: float,
    seed: int = 0,
    walls: Path | None = None,
    current_m_s: Sequence[float] = (0.0, 0.0, 0.0),
    waves: Waves | None = None,
    name: str = "flight",
) -> Run:
    """Fly from rest where the vehicle floats, heading north, and return what was recorded.

    commands: a table of `time_s` and columns NAME_rev_s, NAME_command, NAME_N of thrusters in the input of the vehicle
        file, NAME_rad of fins; a row holds until the next, what is not named rests. walls: MJCF of a basin.
    current_m_s: of the water, north, east, down [m/s]. seed: of noise, lost samples and waves, which come from astern.

    Columns: the commands, and SENSOR.CHANNEL of each instrument, with its rate, noise, latency and lost samples. The
    same seed gives the same run. InputError for commands that the vehicle has not, and as `tank.load_whole`.
    """
    from ..tank.whole import load_whole  # MuJoCo takes a while to load

    vehicle = vehicle if isinstance(vehicle, Vehicle) else load_vehicle(vehicle)
    if not 0.0 < duration_s <= PAUSE_S:
        raise InputError(f"duration_s: expected a number above 0 and up to {PAUSE_S:g} s, found {duration_s:g}")
    north, east, down = current_m_s
    whole = load_whole(vehicle, walls, (north, -east, -down), waves, seed=seed)
    table = check_commands(vehicle, commands)
    step_s = whole.model.opt.timestep
    time_s = np.arange(round(duration_s / step_s) + 1) * step_s
    asked = {key: held(time_s, table[TIME], values) for key, values in table.items()}
    motion = whole.fly(whole.control(asked))
    flown = table[TIME] <= duration_s
    channels = {key: (table[TIME][flown], values[flown]) for key, values in table.items() if key != TIME}
    for sensor in vehicle.sensors:
        channels |= recorded(sensor, motion.time_s, motion.channels[sensor.name], seed)
    return Run.from_channels(name, channels)


def check_commands(vehicle: Vehicle, commands: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """The table as arrays of one length; InputError for a column that the vehicle has not, for times out of order."""
    table = {key: np.atleast_1d(np.asarray(values, dtype=float)) for key, values in commands.items()}
    known = (*(t.column for t in vehicle.thrusters), *(fin.column for fin in vehicle.fins if fin.limit_rad))
    if TIME not in table:
        raise InputError(f"commands: no column {TIME}; found {', '.join(table) or 'nothing'}")
    table[TIME] = np.round(table[TIME], TICK)
    for key, values in table.items():
        if key != TIME and key not in known:
            raise InputError(f"commands: {vehicle.name} has no input '{key}'{meant(key, known)}")
        if values.shape != table[TIME].shape or values.ndim != 1 or not np.isfinite(values).all():
            raise InputError(f"commands: {key}: expected {table[TIME].size} finite numbers, as {TIME} has")
        if key.endswith("_command") and np.abs(values).max() > 1.0:
            raise InputError(f"commands: {key}: expected -1..1, found {values[np.argmax(np.abs(values))]:g}")
    if (np.diff(table[TIME]) <= 0.0).any() or table[TIME][0] < 0.0:
        raise InputError(f"commands: {TIME}: expected strictly increasing times from 0 on")
    return table


def held(time_s: Array, at_s: Array, values: Array) -> Array:
    """Values that hold from their times on, at other times; 0 before the first. All shapes (T,)."""
    row = np.searchsorted(at_s, time_s + 10.0**-TICK, side="right") - 1
    return np.where(row < 0, 0.0, values[np.maximum(row, 0)])


def recorded(sensor: Sensor, time_s: Array, true: Mapping[str, Array], seed: int) -> dict[str, tuple[Array, Array]]:
    """What an instrument writes of what is true at the times of the steps, (T,): column -> its times [s] and values.

    A sample tells what was so `latency_s` before. Times that are not a step's are interpolated.
    """
    rng = np.random.default_rng([seed, *sensor.name.encode()])
    at = np.arange(np.floor(time_s[-1] * sensor.rate_hz * (1.0 + 1e-12)) + 1.0) / sensor.rate_hz
    at = np.round(at[at >= sensor.latency_s], TICK)
    kept, columns = rng.random(at.size) >= sensor.dropout, {}
    for channel, noise in zip(sensor.channels, sensor.noise or (0.0,) * len(sensor.channels), strict=True):
        values = np.interp(at - sensor.latency_s, time_s, true[channel]) + noise * rng.standard_normal(at.size)
        if channel in ("roll_rad", "heading_rad"):
            values = (values + np.pi) % (2.0 * np.pi) - np.pi
        if channel == "range_m":
            values = np.where(values < 0.0, np.nan, values)
        there = kept & np.isfinite(values)
        if there.any():
            columns[f"{sensor.name}.{channel}"] = at[there], values[there]
    return columns
