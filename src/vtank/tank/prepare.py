"""Makes a model ready to be stepped: the vehicle's water, thrusters and surge equation, written into a copy of it."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from .. import water
from ..errors import InputError
from ..plant import parameters
from ..plant.surge import TAU
from ..plant.vehicle import AXES, Vehicle
from ..record.toml import meant
from ..water.installation import installed
from .callbacks import callbacks
from .layout import FIELDS, SURGE, SURGING, TRIM, TRIMMING, field
from .model import check_model, mass_kg, propeller_height, site, sonar_and_wall, vehicle_body

FORWARD = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # gear of a force along the hull
HELD = np.inf  # [kg, kg m2] armature of what is held: no force moves it, by no rounding error


def prepare(model: mujoco.MjModel, vehicle: Vehicle, p: np.ndarray, held: Sequence[str] = ()) -> mujoco.MjModel:
    """A copy of a model with the vehicle's hydrodynamics, to be stepped by mujoco.mj_step inside `tank.forces()`.

    Args:
        model: one that load_world or submerge made for a vehicle with as many thrusters; its mass and inertia count,
            edits included. Controls: propeller speed [rev/s], then the thrusters' forces [N].
        vehicle: hydrodynamics. Entry 0 of both drags is not used: surge drag is the surge equation's.
        p: parameter vector of the surge equation, shape (parameters.SIZE,).
        held: names of the AXES along which the body keeps its speed whatever the forces; the level vehicle's in surge,
            sway and heave.

    Raises InputError when model, vehicle, p and held do not fit together.
    """
    check_model(model, vehicle)
    check_parameters(model, p)
    if unknown := [axis for axis in held if axis not in AXES]:
        raise InputError(f"no axis '{unknown[0]}' to hold{meant(unknown[0], AXES)}")
    model = copy.copy(model)
    body, first = vehicle_body(model), model.actuator(SURGE).id
    try:
        water.add(model, {model.body(body).name: without_surge(vehicle)})
    except InputError as reason:
        raise InputError(f"vehicle '{vehicle.name}': {reason}") from None
    sonar, wall = sonar_and_wall(model, body)
    values = {
        "magic": SURGING,
        "body": body,
        "moving_mass_kg": mass_kg(model) + vehicle.added_mass[0, 0],
        "sonar_m": sonar,
        "wall_m": wall,
        "parameters": p,
    }
    for name, value in values.items():
        field(model.actuator_user[first], name)[...] = value
    model.actuator_gear[first] = FORWARD
    if height := propeller_height(model, vehicle):
        trim = model.actuator(TRIM).id
        model.actuator_user[trim, :2], model.actuator_gear[trim] = (TRIMMING, first), (0.0, 0.0, 0.0, 0.0, height, 0.0)
    for gear, thruster in zip(model.actuator_gear[first + 1 :], vehicle.steering, strict=False):
        gear[:] = *thruster.direction, *np.cross(site(model, thruster.site), thruster.direction)
    model.dof_armature[model.body_dofadr[body] + np.array([AXES.index(axis) for axis in held], dtype=int)] = HELD
    return model


def without_surge(vehicle: Vehicle) -> Vehicle:
    """The vehicle less the drag along its hull."""
    others = np.array([0.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    return replace(vehicle, linear_drag=others * vehicle.linear_drag, quadratic_drag=others * vehicle.quadratic_drag)


def check_parameters(model: mujoco.MjModel, p: np.ndarray) -> None:
    """Raise InputError unless p, shape (parameters.SIZE,), is a parameter vector that the time step can follow."""
    if p.shape != FIELDS["parameters"]:
        raise InputError(f"expected {parameters.SIZE} surge parameters, found an array of shape {p.shape}")
    if np.isnan(p).any():
        raise InputError(f"the surge parameter '{parameters.NAMES[int(np.isnan(p).argmax())]}' is NaN")
    tau, step = p[TAU], model.opt.timestep
    if 0.0 < tau < step:
        raise InputError(f"thrust lag tau = {tau:g} s is shorter than the time step of {step:g} s; 0 means no lag")


def forces() -> Any:
    """A context in which every model that was prepared feels the water; nests, and leaves others alone."""
    return installed(callbacks)
