"""The centre of gravity is not where the vehicle file has it."""

from __future__ import annotations

import mujoco
import numpy as np

from ....plant.vehicle import Vehicle
from ..effect import VEHICLE, PlacedEffect, Values
from .offset import xyz
from .rigid import free


def heavy_elsewhere(spec: mujoco.MjSpec, p: Values) -> None:
    """The centre of gravity of the whole vehicle shifted, inertia about it kept."""
    body = free(spec)
    model = spec.copy().compile()
    index = model.body(body.name).id
    body.explicitinertial, body.mass = True, model.body_mass[index]
    share = model.body_subtreemass[index] / model.body_mass[index]
    body.ipos = model.body_ipos[index] + share * np.array([p["x"], p["y"], p["z"]])
    body.iquat, body.inertia, body.fullinertia = model.body_iquat[index], model.body_inertia[index], np.full(6, np.nan)


def moved(vehicle: Vehicle, place: str) -> dict[str, float] | None:
    """How far off the corrected centre is from where the vehicle has it."""
    places = {axis: vehicle.corrections.get(f"centre_of_gravity_{axis}@hull") for axis in "xyz"}
    centre = dict(zip("xyz", vehicle.centre_m or (0.0, 0.0, 0.0), strict=True))
    return {axis: at - centre[axis] for axis, at in places.items() if at is not None} or None


EFFECT = PlacedEffect(
    "centre_of_gravity",
    VEHICLE,
    "r_G -> r_G + (x, y, z)",
    xyz(),
    rigid=heavy_elsewhere,
    of=moved,
    order=1,
)
