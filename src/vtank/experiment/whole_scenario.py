"""Scenarios of whole vehicles: which axes or inputs are excited, what is held meanwhile, in a TOML file.

vehicle = "bluerov2"
duration_s = 60.0
[[excite]]
kind = "multisine"                       # or step_coast, chirp, square, zigzag, spiral
axis = "heave"                           # or input = "rudder_rad"
amplitudes_N = [10.0, 10.0]              # N_m about roll, pitch, yaw; orders.py has the other loops
frequencies_rad_s = [0.5, 1.3]
[[hold]]
axis = "yaw"
bandwidth_rad_s = 0.5
[effects]
"linear_drag@heave" = { c_N_s_per_m = 20.0 }
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..plant.sensor import changed_sensors
from ..plant.vehicle import AXES, Vehicle, load_vehicle
from ..record import Manifest, Run, open_table, read_text, run_name, write_dataset
from ..record.columns import channel_of
from ..record.table import Table, table_of
from ..resources import models_dir
from ..waves import Waves
from .clearance import missing_walls, walls_at
from .excitation import Excitation, check_frequencies
from .orders import Order, check_orders, read_excite, read_hold
from .pilot import Pilot
from .scenario import scenario_file
from .sea import read_waves
from .sensing import PLACE, SPEED
from .whole import Flown, fly

if TYPE_CHECKING:
    from ..tank.places.effect import Placed

Array = NDArray[np.float64]
DEEP_M = 50.0  # [m] at which what dives starts in trials, so that it does not come to the surface; a choice
NOTED = 0.01  # share of the time from which a limit of the thrusters is told; a choice


@dataclass(frozen=True)
class WholeScenario:
    """A flight to be: of which vehicle, for how long [s], under which orders, each period_s a new command [s]."""

    name: str
    path: Path
    vehicle: Vehicle
    duration_s: float
    period_s: float
    seed: int
    walls: Path | None
    current_m_s: tuple[float, float, float]
    depth_m: float | None
    waves: Waves
    orders: tuple[Order, ...]
    effects: tuple[Placed, ...]

    def pilot(self) -> Pilot:
        """Who flies it; InputError where the vehicle cannot do what is asked."""
        return Pilot(self.vehicle, self.orders, self.duration_s, self.period_s, self.depth_m)

    def commands(self) -> dict[str, Array]:
        """The table of commands of a scenario in open loop; InputError where the thrusters cannot do what is asked."""
        return self.pilot().table()


def is_whole(name_or_path: str | Path) -> bool:
    """Whether a scenario is one of whole vehicles: it has [[excite]] or [[hold]]."""
    entries = open_table(scenario_file(name_or_path)).entries
    return "excite" in entries or isinstance(entries.get("hold"), list)  # of one axis it is a word


def load_whole_scenario(
    name_or_path: str | Path, settings: Sequence[str] = (), seed: int | None = None
) -> WholeScenario:
    """The scenario of that name in scenarios/, or of that TOML file; InputError names file, line and key.

    settings: KEY=VALUE laid over it. seed: instead of the file's.
    """
    path = scenario_file(name_or_path)
    return _read(open_table(path, tuple(settings)), seed)


def scenario_of(text: str, name: str, seed: int | None = None) -> WholeScenario:
    """The scenario of a TOML text, under a name; as `load_whole_scenario`."""
    return _read(table_of(text, Path(f"{name}.toml")), seed)


def _read(table: Table, seed: int | None) -> WholeScenario:
    from ..tank.places.read import read_placed  # MuJoCo takes a while to load
    from ..tank.places.vehicle.current import FASTEST_M_S

    table.text("description", "")
    vehicle = load_vehicle(table.file("vehicle", presets=(models_dir(), "vehicle")))
    vehicle = replace(vehicle, sensors=changed_sensors(table.table("sensor"), vehicle.sensors))
    orders = (*(read_excite(part, vehicle) for part in table.tables("excite")), *map(read_hold, table.tables("hold")))
    if not orders:
        raise table.error("excite", "expected one excitation or more, [[excite]]")
    check_orders(orders)
    own_seed = table.integer("seed", 0)
    walls = table.file("walls", "", ".xml")
    if walls and (missing := missing_walls(walls)):
        raise table.error("walls", missing)
    depth_m = table.number("depth_m", None, 0.0, 1e4) if table.has("depth_m") else None
    scenario = WholeScenario(
        name=run_name(table.path),
        path=table.path,
        vehicle=vehicle,
        duration_s=table.positive("duration_s", 120.0, 86400.0),
        period_s=table.positive("period_s", 0.1, 10.0),
        seed=own_seed if seed is None else seed,
        walls=walls_at(walls) if walls else None,
        current_m_s=table.vector("current_m_s", FASTEST_M_S) if table.has("current_m_s") else (0.0, 0.0, 0.0),
        depth_m=depth_m,
        waves=_waves(table, vehicle, depth_m),
        orders=orders,
        effects=read_placed(table.table("effects"), vehicle),
    )
    table.close()
    _check(table, scenario)
    return scenario


def _check(table: Table, scenario: WholeScenario) -> None:
    """InputError where an instrument or an order has nothing to go by in this flight."""
    for sensor in scenario.vehicle.sensors:
        if sensor.latency_s >= scenario.duration_s:
            own = table.table("sensor").table(sensor.name)
            told = f"expected less than the run's {scenario.duration_s:g} s, found {sensor.latency_s:g}"
            told += f": nothing that {sensor.name} measures would be recorded; is it in milliseconds?"
            if own.has("latency_s"):
                raise own.error("latency_s", told)
            raise InputError(f"{scenario.vehicle.path}: sensor.{sensor.name}.latency_s: {told}")
    for order in scenario.orders:
        if isinstance(order.signal, Excitation):
            check_frequencies(order.table, order.signal, scenario.period_s)
        if order.turns_at_rad and order.target in AXES and order.target != "yaw":
            told = f"a zig-zag goes over at a heading, and {order.target} has none"
            raise order.table.error("axis", f"{told}; expected yaw, or an input that turns the bow")


def _waves(table: Table, vehicle: Vehicle, depth_m: float | None) -> Waves:
    """The sea; InputError where the vehicle floats on it: vtank's water has no surface that moves."""
    if not table.has("waves"):
        return Waves()
    if vehicle.heave_N_per_m:
        raise table.error(
            "waves", f"{vehicle.name} floats, and is held at a waterline that stands still; expected none"
        )
    if depth_m is None:
        raise table.error("depth_m", "missing; expected with [waves]: their motion fades with depth")
    return read_waves(table.table("waves"), depth_m)


def fly_whole(scenario: WholeScenario, vehicle: Vehicle | None = None) -> Flown:
    """Fly a scenario; errors as of `fly_vehicle`. vehicle: that is flown; the pilot goes by the scenario's file."""
    pilot = scenario.pilot()
    flown = fly(
        vehicle or scenario.vehicle,
        pilot if pilot.closed else pilot.table(),
        scenario.duration_s,
        seed=scenario.seed,
        name=scenario.name,
        period_s=scenario.period_s,
        current_m_s=scenario.current_m_s,
        walls=scenario.walls,
        waves=scenario.waves,
        depth_m=scenario.depth_m,
        effects=scenario.effects,
    )
    return replace(flown, left=pilot.left, cut={axis: ticks / pilot.ticks for axis, ticks in pilot.cut.items()})


def fly_scenarios(
    names: Sequence[str | Path],
    settings: Sequence[str] = (),
    seed: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[list[WholeScenario], list[Flown]]:
    """Load and fly scenarios of whole vehicles, each with noise of its own; InputError where one is of one axis.

    seed: of all, in place of the files'. progress: told the share done.
    """
    if single := [name for name in names if not is_whole(name)]:
        raise InputError(f"{single[0]}: an experiment of one axis; expected it apart from those of whole vehicles")
    loaded = [load_whole_scenario(name, settings, seed) for name in names]
    scenarios = [replace(scenario, seed=_seed_of(scenario.seed, run)) for run, scenario in enumerate(loaded)]
    flights = []
    for number, scenario in enumerate(scenarios, 1):
        flights.append(fly_whole(scenario))
        if progress:
            progress(number / len(scenarios))
    return scenarios, flights


def _seed_of(seed: int, run: int) -> int:
    """The seed of a run of a data set: the first has the data set's own, as if it were flown alone."""
    return seed if run == 0 else int(np.random.SeedSequence(seed, spawn_key=(run,)).generate_state(1)[0])


def summary(scenario: WholeScenario, flown: Flown) -> str:
    """One line about a flight: what each excited and held axis did, as recorded; all of them, under an input."""
    run, orders, told = flown.run, {o.target: o for o in scenario.orders if o.target not in flown.left}, []
    for axis in AXES:
        if axis in orders or not set(orders) <= set(AXES):
            places = [({"surge": "north_m", "sway": "east_m"} | PLACE)[axis]]
            by_place = axis in orders and orders[axis].loop == "place"
            zigzag = axis in orders and orders[axis].turns_at_rad > 0.0
            channels = (places if by_place else [SPEED[axis]]) + (places if zigzag else [])
            told += [_range(run, channel) or f"{channel} is not measured" * (axis in orders) for channel in channels]
    if flown.left:
        told.append(f"{', '.join(flown.left)} not held: {scenario.vehicle.name} cannot")
    if cut := [f"{axis} {100.0 * share:.0f} %" for axis, share in flown.cut.items() if share > NOTED]:
        told.append(f"more asked than thrusters and fins make: {', '.join(cut)} of the time")
    ends = [flown.above, flown.depth if "heave" not in orders else "", flown.ended]
    said = "; ".join(filter(None, (", ".join(filter(None, told)), *ends)))
    return f"{run.name}: {scenario.vehicle.name}, {run.duration_s:g} s, {said}"


def _range(run: Run, channel: str) -> str:
    """Least and greatest value of the first column that has a channel, "" for none; angles go on beyond half a turn."""
    column = next((name for name in run.columns if channel_of(name) == channel), "")
    if not column:
        return ""
    values = run.samples(column)[1]
    values = np.unwrap(values) if channel.endswith("_rad") else values
    return f"{column} {values.min():+.3g} to {values.max():+.3g}" if values.size else ""


def write_flights(
    out: Path, scenarios: Sequence[WholeScenario], flights: Sequence[Flown], settings: Sequence[str]
) -> None:
    """Write the recordings as a data set, with scenarios and seeds in its truth; InputError for an unfit folder."""
    told: list[Mapping[str, Any]] = [
        {"name": s.name, "text": read_text(s.path), "seed": s.seed}
        | ({"effects": [{"effect": p.name, **p.values} for p in s.effects]} if s.effects else {})
        | ({"ended": flown.ended} if flown.ended else {})
        for s, flown in zip(scenarios, flights, strict=True)
    ]
    truth = {"model": "whole", "settings": list(settings), "scenarios": told}
    write_dataset(out, [flown.run for flown in flights], Manifest(), truth)
