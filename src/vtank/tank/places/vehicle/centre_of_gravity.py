"""The centre of gravity is not where the vehicle file has it."""

from __future__ import annotations

import mujoco
import numpy as np

from ..effect import VEHICLE, PlacedEffect, Values
from .offset import XYZ
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


EFFECT = PlacedEffect(
    "centre_of_gravity",
    VEHICLE,
    "r_G -> r_G + (x, y, z)",
    XYZ,
    rigid=heavy_elsewhere,
    order=1,
)
