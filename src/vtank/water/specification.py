"""MuJoCo's specifications compiled as the water needs them."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from ..errors import InputError

HALF_TURN = (0.0, 1.0, 0.0, 0.0)  # about x: leaves a diagonal inertia what it is


def compiled(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """The model, its free bodies in the axes that the MJCF gives them; InputError says what MuJoCo says."""
    for joint in spec.joints:
        joint.align = mujoco.mjtAlignFree.mjALIGNFREE_FALSE
    try:
        return spec.compile()
    except ValueError as reason:
        raise InputError(f"MuJoCo cannot compile the model: {' '.join(str(reason).split())}") from None


def make_room(spec: mujoco.MjSpec, model: mujoco.MjModel, bodies: list[int]) -> None:
    """Let M have room beside its diagonal: MuJoCo leaves it out for bodies whose inertia is along their own axes.

    Where the compiler takes all inertias from shapes, every body states the one that it got.
    """
    forced = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO
    for i in range(1, model.nbody) if forced else bodies:
        body: Any = next(body for body in spec.bodies if body.id == i)
        body.explicitinertial, body.mass, body.ipos = True, model.body_mass[i], model.body_ipos[i]
        body.iquat = HALF_TURN if i in bodies else model.body_iquat[i]
        body.inertia, body.fullinertia = model.body_inertia[i], np.full(6, np.nan)
