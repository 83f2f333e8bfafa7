"""A whole vehicle in water: its thrusters and fins as MuJoCo's actuators, its instruments as MuJoCo's sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from .. import water
from ..errors import InputError
from ..plant.actuators import Fin, Thruster
from ..plant.vehicle import Vehicle
from ..units import G_M_S2
from ..waves import Waves
from .agreeing import check_files, place, seated
from .corrected import corrected
from .described import described
from .flight import Flight
from .instruments import add_sensors
from .layout import FINNING, FINS, SIZE, field
from .mjcf import mujoco_says, named, read, read_hull
from .model import vehicle_body
from .places.acting import acting, thrust
from .places.catalogue import ordered
from .places.effect import Placed
from .prepare import forces
from .world import LAW, add_actuator, free_body, mark_walls, set_afloat

Array = NDArray[np.float64]
QUICKEST = 0.4  # [time steps] of a lag that classical Runge-Kutta follows: it is stable from 1/2.785 on
WATERLINE = "vtank/waterline"


@dataclass(frozen=True, eq=False)
class Motion:
    """What a vehicle did: time_s, shape (T,) [s], and each instrument's channels, without error, (T,) [SI]."""

    time_s: Array
    channels: Mapping[str, Mapping[str, Array]]


@dataclass(frozen=True, eq=False)
class Whole:
    """A vehicle as MuJoCo steps it, inside `tank.forces()`; `vehicle` with what effects make of it.

    Controls, nu in number: force of each thruster [N], angle of each fin twice [rad].
    """

    model: mujoco.MjModel
    vehicle: Vehicle
    effects: tuple[Placed, ...] = ()

    def flight(self, steps: int, velocity: Sequence[float] | Array = (0.0,) * 6) -> Flight:
        """A flight from where the vehicle floats; velocity: at the start, body axes, shape (6,) [m/s, rad/s].

        InputError where a thruster's lag is too short for the time step.
        """
        step_s, vehicle = self.model.opt.timestep, self.vehicle
        for number, thruster in enumerate(vehicle.thrusters):
            if 0.0 < thruster.lag_s < QUICKEST * step_s:
                raise InputError(
                    f"{vehicle.path}: thruster[{number}].lag_s: {thruster.lag_s:g} s is too short for the time step of "
                    f"{step_s:g} s of {vehicle.mjcf}; expected 0 for none, or {QUICKEST * step_s:g} s or more"
                )
        return Flight(self.model, self.vehicle, self.effects, steps, velocity)

    def column(self, name: str) -> str:
        """Column of a thruster or fin."""
        parts: tuple[Any, ...] = (*self.vehicle.thrusters, *self.vehicle.fins)
        return str(next(part.column for part in parts if part.name == name))

    def acting(self, asked: Mapping[str, Array], rows: slice) -> dict[str, Array]:
        """Inputs that act at some steps, (n,) by thruster and fin, of what is asked for at all, (T,) by column."""
        step_s = self.model.opt.timestep
        parts: tuple[Any, ...] = (*self.vehicle.thrusters, *self.vehicle.fins)
        return {part.name: acting(part, self.effects, asked, step_s, rows) for part in parts}

    def control(self, asked: Mapping[str, Array], rows: slice | None = None) -> Array:
        """Controls from what thrusters and fins are asked for, (T,) each by its column; the others rest. (n, nu).

        rows: the steps that are meant (default: all).
        """
        rows = rows or slice(0, len(next(iter(asked.values()))))
        inputs, time_s = self.acting(asked, rows), self.model.opt.timestep * np.arange(rows.start, rows.stop)
        columns = [thrust(t, self.effects, time_s, inputs[t.name]) for t in self.vehicle.thrusters]
        for fin in self.vehicle.fins:
            columns += 2 * [np.clip(inputs[fin.name], -fin.limit_rad, fin.limit_rad)]
        return np.stack(columns + [np.zeros(time_s.size)] * (self.model.nu - len(columns)), axis=1)

    def fly(self, control: Array, velocity: Sequence[float] | Array = (0.0,) * 6) -> Motion:
        """Motion from where the vehicle floats, under a row of controls for each time step, (T, nu).

        velocity: at the start, body axes, shape (6,) [m/s, rad/s]. It ends where the vehicle strikes a wall. InputError
        where the motion diverges. Effects that need the inputs themselves (thrust_loss) see none.
        """
        flight = self.flight(len(control), velocity)
        with forces():
            flight.advance(control)
        return Motion(flight.times(flight.done), flight.true(slice(0, flight.done)))


def load_whole(
    vehicle: Vehicle,
    walls: Path | None = None,
    current_m_s: Sequence[float] | Array = (0.0, 0.0, 0.0),
    waves: Waves | None = None,
    towards_rad: float = 0.0,
    seed: int = 0,
    depth_m: float | None = None,
    effects: Sequence[Placed] = (),
) -> Whole:
    """The vehicle in open water or within walls, with all its thrusters, fins and instruments.

    Water as of `vtank.water.add`. depth_m: of its origin at the start (default: as in the MJCF). effects: of
    `tank.places`, beside those of a corrected vehicle. InputError names the file and key where the vehicle's two files
    do not fit together, and an effect that remembers and is there twice.
    """
    hull, around = read_hull(vehicle), read(walls) if walls else None
    with named(vehicle.mjcf):
        world = set_afloat(hull, around)
        with mujoco_says("cannot compile it"):
            bare = world.copy().compile()
    check_files(vehicle, bare)
    vehicle = seated(vehicle, bare)
    # as for all who estimate: MuJoCo's own, of an MJCF that says nothing, pulls a vehicle of 9 kg down by 0.03 N more
    world.option.gravity = (0.0, 0.0, -G_M_S2)
    body = free_body(world)
    if depth_m is not None:
        body.pos[2] = -depth_m
    if vehicle.corrections:
        vehicle, own = corrected(described(vehicle), QUICKEST * world.option.timestep)
        effects = ordered([*own, *effects])
    vehicle = changed(vehicle, effects)
    for placed in effects:
        if placed.effect.rigid:
            placed.effect.rigid(world, placed.values)
    for number, thruster in enumerate(vehicle.thrusters):
        _add_thruster(world, thruster, place(vehicle, bare, f"thruster[{number}]", thruster.site))
    for number, fin in enumerate(vehicle.fins):
        _add_fin(world, fin, place(vehicle, bare, f"fin[{number}]", fin.site))
    if vehicle.heave_N_per_m:
        _add_waterline(world, body, vehicle.heave_N_per_m)
    for sensor in list(world.sensors):
        world.delete(sensor)  # the files' own, which nothing here reads
    add_sensors(world, body, vehicle.sensors)
    with named(vehicle.mjcf), mujoco_says("cannot compile it"):
        model = water.add(
            world, {body.name: vehicle}, np.asarray(current_m_s) + drift(effects), waves, towards_rad, seed
        )
    fins = slice(len(vehicle.thrusters), len(vehicle.thrusters) + 2 * len(vehicle.fins))
    field(model.actuator_user[fins], "body", FINS)[...] = vehicle_body(model)
    if walls:
        mark_walls(model)
    return Whole(model, vehicle, tuple(effects))


def changed(vehicle: Vehicle, effects: Sequence[Placed]) -> Vehicle:
    """What effects make of a vehicle."""
    for placed in effects:
        if placed.effect.changes:
            vehicle = placed.effect.changes(vehicle, placed.place, placed.values)
    return vehicle


def drift(effects: Sequence[Placed]) -> Array:
    """The current that is an effect, world axes [m/s]."""
    current = np.zeros(3)
    for placed in effects:
        if placed.effect.drifts:
            current += np.array(placed.effect.drifts(placed.values)) * (1.0, -1.0, -1.0)
    return current


def _add_thruster(world: mujoco.MjSpec, thruster: Thruster, at_m: Array) -> None:
    """A force with a first-order lag; "filterexact" would be inexact under RK4."""
    lag = {"dyntype": mujoco.mjtDyn.mjDYN_FILTER, "dynprm": [thruster.lag_s] + 9 * [0.0]} if thruster.lag_s else {}
    gear = (*thruster.direction, *np.cross(at_m, thruster.direction))
    add_actuator(world, f"vtank/{thruster.name}", gear=gear, **lag)


def _add_fin(world: mujoco.MjSpec, fin: Fin, at_m: Array) -> None:
    """Its force along the hull, and across."""
    for along in ((1.0, 0.0, 0.0), np.cross(fin.axis, (1.0, 0.0, 0.0))):
        row = np.zeros(SIZE)
        values = {
            "magic": FINNING,
            "place_m": at_m,
            "axis": fin.axis,
            "along": along,
            "pressure_area": 0.5 * fin.density_kg_per_m3 * fin.area_m2,
            "lift_per_rad": fin.lift_per_rad,
            "stall_rad": fin.stall_rad,
            "drag": fin.drag,
            "suction": fin.suction,
        }
        for name, value in values.items():
            field(row, name, FINS)[...] = value
        side = "along" if along[0] else "across"
        add_actuator(world, f"vtank/{fin.name} {side}", gear=(*along, *np.cross(at_m, along)), userdata=row, **LAW)


def _add_waterline(world: mujoco.MjSpec, body: mujoco.MjsBody, heave_N_per_m: float) -> None:
    """A spring that holds the body's origin at the height of its start."""
    world.worldbody.add_site(name=WATERLINE, pos=(0.0, 0.0, body.pos[2]))
    spring = {"biastype": mujoco.mjtBias.mjBIAS_AFFINE, "biasprm": [0.0, -heave_N_per_m] + 8 * [0.0]}
    add_actuator(
        world, WATERLINE, refsite=WATERLINE, gear=(0.0, 0.0, 1.0, 0.0, 0.0, 0.0), gainprm=LAW["gainprm"], **spring
    )
