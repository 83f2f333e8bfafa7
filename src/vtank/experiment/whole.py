"""A whole vehicle flown under a table of commands, or by a pilot on what its instruments read, and recorded by them.

ahead = {"time_s": [0, 5], "thruster_1_command": [0.5, 0.0], "thruster_2_command": [0.5, 0.0]}
run = fly_vehicle("bluerov2", ahead, duration_s=20.0, seed=1)
run.samples("dvl.surge_m_s")

def deeper(time_s, readings):
    down = 2.0 * (3.0 - readings.get("depth.depth_m", 3.0))
    return {f"thruster_{k}_command": max(-1.0, min(down, 1.0)) for k in (5, 6, 7, 8)}

run = fly_vehicle("bluerov2", deeper, duration_s=20.0, seed=1)
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..plant.vehicle import Vehicle, load_vehicle
from ..record import PAUSE_S, TIME, Run, meant
from ..record.table import Table
from ..waves import Waves
from .readings import TICK, Instrument, Readings

if TYPE_CHECKING:
    from ..tank.flight import Flight
    from ..tank.places.effect import Placed
    from ..tank.whole import Whole

Array = NDArray[np.float64]
SUNK_M = 5.0  # [m] of change of depth from which it is told where nobody asked for it; a choice
MOST_STEPS = 10_000_000  # of a flight, whose sensors take some GB by then; a choice


Pilot = Callable[[float, Mapping[str, float]], Mapping[str, float]]


@dataclass(frozen=True)
class Flown:
    """A recording and what is to be told of the flight, "" for nothing.

    Attributes:
        run: the recording.
        ended: why it ended before its time.
        left: axes that were not held. cut: those that asked more than thrusters and fins make, and how often, 0 to 1.
        above: when and how far it was above the surface; it floats where that is its place.
        depth: how its depth changed by more than SUNK_M.
    """

    run: Run
    ended: str = ""
    left: tuple[str, ...] = ()
    cut: Mapping[str, float] = field(default_factory=dict)
    above: str = ""
    depth: str = ""


def fly_vehicle(
    vehicle: str | Path | Vehicle,
    commands: Mapping[str, ArrayLike] | Pilot,
    duration_s: float,
    seed: int = 0,
    walls: Path | None = None,
    current_m_s: Sequence[float] = (0.0, 0.0, 0.0),
    waves: Waves | None = None,
    name: str = "flight",
    period_s: float = 0.1,
    depth_m: float | None = None,
    effects: Mapping[str, Mapping[str, Any]] | Sequence[Placed] = (),
) -> Run:
    """Fly from rest where the vehicle floats, heading north, and return what was recorded.

    commands: a table of `time_s` and columns NAME_rev_s, NAME_command, NAME_N of thrusters in the input of the vehicle
        file, NAME_rad of fins; a row holds until the next, what is not named rests. Or a pilot: called every period_s
        with the time and the last readings, by SENSOR.CHANNEL, it returns columns' values, which hold until it changes
        them.
    walls: MJCF of a basin, which sonars hear; a flight ends, with a warning, where the box around the hull reaches one.
    current_m_s: of the water, north, east, down [m/s]. seed: of noise, lost samples and waves, which come from astern.
    depth_m: at the start (default: as the vehicle's MJCF has it). effects: at places, as in a scenario, such as
        {"linear_drag@yaw": {"c_N_m_s_per_rad": 2.0}}, or as `tank.places` reads them.

    Columns: the commands, and SENSOR.CHANNEL of each instrument, with its rate, noise, latency and lost samples. The
    same seed gives the same run. InputError for commands that the vehicle has not, where the motion diverges, and as
    `tank.load_whole`.
    """
    settings: dict[str, Any] = {
        "seed": seed,
        "walls": walls,
        "current_m_s": current_m_s,
        "waves": waves,
        "depth_m": depth_m,
    }
    flown = fly(vehicle, commands, duration_s, name=name, period_s=period_s, effects=effects, **settings)
    for said in filter(None, (flown.ended, flown.above)):
        warnings.warn(f"{name}: {said}", stacklevel=2)
    return flown.run


def fly(
    vehicle: str | Path | Vehicle,
    commands: Mapping[str, ArrayLike] | Pilot,
    duration_s: float,
    *,
    seed: int = 0,
    name: str = "flight",
    period_s: float = 0.1,
    current_m_s: Sequence[float] = (0.0, 0.0, 0.0),
    effects: Mapping[str, Mapping[str, Any]] | Sequence[Placed] = (),
    **water: Any,
) -> Flown:
    """As `fly_vehicle`, told how it ended instead of warned; water: other arguments of `tank.load_whole`."""
    from ..tank.model import vehicle_body  # MuJoCo takes a while to load
    from ..tank.places.read import read_placed
    from ..tank.places.vehicle.current import FASTEST_M_S
    from ..tank.prepare import forces
    from ..tank.whole import load_whole

    vehicle = vehicle if isinstance(vehicle, Vehicle) else load_vehicle(vehicle)
    if not 0.0 < duration_s <= PAUSE_S:
        raise InputError(f"duration_s: expected a number above 0 and up to {PAUSE_S:g} s, found {duration_s:g}")
    if isinstance(effects, Mapping):
        effects = read_placed(Table(Path("effects"), "", dict(effects)), vehicle)
    if np.shape(current_m_s) != (3,) or not (np.abs(current_m_s) <= FASTEST_M_S).all():
        expected = f"three numbers, north, east, down, from -{FASTEST_M_S:g} to {FASTEST_M_S:g} m/s"
        raise InputError(f"current_m_s: expected {expected}, found {list(current_m_s)}")
    north, east, down = current_m_s
    whole = load_whole(vehicle, current_m_s=(north, -east, -down), seed=seed, effects=effects, **water)
    height_m = float(whole.model.body_pos[vehicle_body(whole.model), 2])
    if height_m > 0.0 and not vehicle.heave_N_per_m:
        where = f"{vehicle.mjcf}: <body pos>" if water.get("depth_m") is None else "depth_m"
        remedy = "expected z = 0 or less there, or a depth_m of the scenario"
        raise InputError(f"{where}: {vehicle.name} would start {height_m:g} m above the surface, z = 0; {remedy}")
    option = whole.model.opt
    if callable(commands):
        if not 0.0 < period_s < math.inf:
            raise InputError(f"period_s: expected a number above 0 s, found {period_s:g}")
        if abs(round(period_s / option.timestep) * option.timestep - period_s) > 1e-6 * period_s:
            option.timestep = period_s / math.ceil(period_s / option.timestep)
    steps = round(duration_s / option.timestep) + 1
    if steps > MOST_STEPS:
        raise InputError(
            f"{duration_s:g} s at the time step of {option.timestep:g} s ({vehicle.mjcf}, of which a period_s of "
            f"{period_s:g} s must be a multiple) are {steps:.2g} steps; expected at most {MOST_STEPS:.0e}"
        )
    flight = whole.flight(steps)
    instruments = {sensor.name: Instrument(sensor, duration_s, seed) for sensor in whole.vehicle.sensors}
    with forces():
        table = _flown(whole, flight, commands, period_s, instruments)
    if flight.ended and flight.done < 2:
        raise InputError(f"{name}: {flight.ended} where it starts")
    time_s = flight.times(flight.done)
    for placed in whole.effects:
        if placed.effect.recorded and (column := whole.column(placed.place)) in table:
            rng = np.random.default_rng([seed, *column.encode()])
            most = 1.0 if column.endswith("_command") else np.inf
            table[column] = np.clip(placed.effect.recorded(table[column], placed.values, rng), -most, most)
    flown = table[TIME] <= time_s[-1] + 0.5 * flight.step_s
    channels = {key: (table[TIME][flown], values[flown]) for key, values in table.items() if key != TIME}
    motion = flight.true(slice(0, flight.done))
    for sensor_name, instrument in instruments.items():
        channels |= instrument.record(time_s, motion[sensor_name])
    ended = f"{flight.ended} after {time_s[-1]:.4g} s, the last good time" if flight.ended else ""
    least, most = flight.depths_m
    above = depth = ""
    if flight.above_s is not None and not vehicle.heave_N_per_m:
        above = f"above the surface from {flight.above_s:.4g} s, by up to {-least:.3g} m: there is water here, too"
    if most - least > SUNK_M:
        depth = f"depth {least:.3g} to {most:.3g} m" + ", and no floor" * (water.get("walls") is None)
    return Flown(Run.from_channels(name, channels), ended, above=above, depth=depth)


def _flown(
    whole: Whole,
    flight: Flight,
    commands: Mapping[str, ArrayLike] | Pilot,
    period_s: float,
    instruments: Mapping[str, Instrument],
) -> dict[str, Array]:
    """Advance a flight to its end; the table of commands that it had."""
    steps, step_s = len(flight.sensordata), flight.step_s
    if not callable(commands):
        table = check_commands(whole.vehicle, commands)
        asked = {key: held(flight.times(steps), table[TIME], values) for key, values in table.items()}
        _advance(whole, flight, asked, slice(0, steps))
        return table
    every = round(period_s / step_s)
    table = {TIME: np.round(period_s * np.arange(-(-steps // every)), TICK)}
    asked = {TIME: flight.times(steps)}
    for tick, time_s in enumerate(table[TIME]):
        flight.now()
        rows = slice(tick * every, min((tick + 1) * every, steps))
        for key, value in check_row(whole.vehicle, commands(float(time_s), Readings(flight, instruments))).items():
            table.setdefault(key, np.zeros(table[TIME].size))[tick:] = value
            asked.setdefault(key, np.zeros(steps))[rows.start :] = value
        _advance(whole, flight, asked, rows)
        if flight.ended:
            break
    return table


def _advance(whole: Whole, flight: Flight, asked: Mapping[str, Array], rows: slice) -> None:
    """Fly some steps."""
    flight.advance(whole.control(asked, rows), whole.acting(asked, rows) if whole.effects else None)


def check_row(vehicle: Vehicle, row: Mapping[str, float]) -> Mapping[str, float]:
    """What a pilot asks for at one time; InputError as `check_commands`."""
    check_commands(vehicle, {TIME: [0.0]} | {key: [value] for key, value in row.items()})
    return row


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
