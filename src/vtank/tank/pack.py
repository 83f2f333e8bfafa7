"""Fills in the userdata of a simulation from the model, the vehicle and the surge parameters."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from ..errors import InputError
from ..plant import parameters, sixdof
from ..plant.surge import TAU
from ..plant.vehicle import AXES, Vehicle
from ..units import G_M_S2
from .layout import FIELDS, MAGIC, MAX_THRUSTERS, field
from .model import STATES, centre_of_gravity, check_model, rigid_mass, site, sonar_and_wall, vehicle_body


def pack(model: mujoco.MjModel, vehicle: Vehicle, p: np.ndarray, held: Sequence[str] = ()) -> np.ndarray:
    """Userdata, shape (nuserdata,), of a simulation of `model` in still water with all inputs zero.

    Args:
        model: a compiled model with the vehicle's free body; its mass and inertia count, edits included.
        vehicle: hydrodynamics. Entry 0 of both drags is not used: surge drag is the surge equation's.
        p: parameter vector of the surge equation, shape (parameters.SIZE,).
        held: names of the AXES along which the body keeps its speed whatever the forces.

    Raises InputError when model, vehicle, p and held do not fit together.
    """
    check_model(model)
    check_parameters(model, p)
    body = vehicle_body(model)
    rigid = rigid_mass(model, body)
    sonar, wall = sonar_and_wall(model, body)
    values = {
        "magic": MAGIC,
        "dof": model.body_dofadr[body],
        "body": body,
        "lag": model.actuator(STATES[0]).actadr[0],
        "lag_input": model.actuator(STATES[0]).id,
        "rigid_mass": rigid,
        "added_mass": vehicle.added_mass,
        "share": rigid @ _mobility(vehicle, rigid, held),
        "drag_linear": [0.0, *vehicle.linear_drag[1:]],
        "drag_quadratic": [0.0, *vehicle.quadratic_drag[1:]],
        "buoyancy_N": vehicle.buoyancy_N,
        "displaced_kg": vehicle.buoyancy_N / G_M_S2,
        "centre_of_buoyancy_m": vehicle.centre_of_buoyancy_m,
        "centre_of_gravity_m": centre_of_gravity(model, body),
        "thruster_wrench": _thruster_wrenches(model, vehicle),
        "propeller_z_m": np.mean([site(model, name)[2] for name in vehicle.propeller_sites]),
        "sonar_m": sonar,
        "wall_m": wall,
        "parameters": p,
    }
    userdata = np.zeros(model.nuserdata)
    for name, value in values.items():
        field(userdata, name)[...] = value
    return userdata


def _mobility(vehicle: Vehicle, rigid: np.ndarray, held: Sequence[str]) -> np.ndarray:
    unknown = [axis for axis in held if axis not in AXES]
    if unknown:
        raise InputError(f"no axis '{unknown[0]}' to hold; there are: {', '.join(AXES)}")
    try:
        return sixdof.mobility(rigid, vehicle.added_mass, tuple(AXES.index(axis) for axis in held))
    except np.linalg.LinAlgError as reason:
        raise InputError(f"vehicle '{vehicle.name}': mass plus added mass: {reason}") from None


def check_parameters(model: mujoco.MjModel, p: np.ndarray) -> None:
    """Raise InputError unless p, shape (parameters.SIZE,), is a parameter vector that the time step can follow."""
    if p.shape != FIELDS["parameters"]:
        raise InputError(f"expected {parameters.SIZE} surge parameters, found an array of shape {p.shape}")
    if np.isnan(p).any():
        raise InputError(f"the surge parameter '{parameters.NAMES[int(np.isnan(p).argmax())]}' is NaN")
    tau, step = p[TAU], model.opt.timestep
    if 0.0 < tau < step:
        raise InputError(f"thrust lag tau = {tau:g} s is shorter than the time step of {step:g} s; 0 means no lag")


def _thruster_wrenches(model: mujoco.MjModel, vehicle: Vehicle) -> np.ndarray:
    if len(vehicle.thrusters) > MAX_THRUSTERS:
        raise InputError(f"vehicle '{vehicle.name}' has {len(vehicle.thrusters)} thrusters; up to {MAX_THRUSTERS} fit")
    wrenches = np.zeros(FIELDS["thruster_wrench"])
    for wrench, thruster in zip(wrenches, vehicle.thrusters, strict=False):
        wrench[:3] = thruster.direction
        wrench[3:] = np.cross(site(model, thruster.site), thruster.direction)
    return wrenches
