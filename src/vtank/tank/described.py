"""What a vehicle's own file leaves to its MJCF: where things sit, the centre of gravity, the moments of inertia."""

from __future__ import annotations

import warnings
from dataclasses import replace

import mujoco
import numpy as np

from ..plant.vehicle import Vehicle
from .agreeing import check_files, seated
from .mjcf import mujoco_says, named, read_hull
from .model import centre_of_gravity, moments, vehicle_body
from .world import set_afloat

SLANT = 0.05  # product of inertia over the least moment above which axes that are taken for principal are not; a choice


def described(vehicle: Vehicle) -> Vehicle:
    """The vehicle with every number that equations of motion need and its file does not state, read from the MJCF.

    InputError where a thruster or fin sits at no site, or the two files differ, complete or not. Warns of products of
    inertia, which are left out where the file states no moments.
    """
    hull = read_hull(vehicle)
    with named(vehicle.mjcf):
        world = set_afloat(hull)
        with mujoco_says("cannot compile it"):
            model = world.compile()
    check_files(vehicle, model)
    if vehicle.complete:
        return vehicle
    x, y, z = centre_of_gravity(model, vehicle_body(model))
    return replace(
        seated(vehicle, model),
        centre_m=vehicle.centre_m or (float(x), float(y), float(z)),
        inertia=vehicle.inertia or _principal(vehicle, model),
    )


def _principal(vehicle: Vehicle, model: mujoco.MjModel) -> tuple[float, float, float]:
    """Moments of inertia about the centre of gravity, body axes [kg m2]."""
    about = moments(model, vehicle_body(model))
    most = np.abs(about - np.diag(np.diag(about))).max()
    if most > SLANT * np.diag(about).min():
        warnings.warn(f"{vehicle.mjcf}: products of inertia of up to {most:.3g} kg m2 are left out", stacklevel=2)
    roll, pitch, yaw = map(float, np.diag(about))
    return roll, pitch, yaw
