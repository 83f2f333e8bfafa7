"""Puts bodies of a MuJoCo model into water."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from ..errors import InputError
from ..plant.vehicle import Vehicle
from ..record.toml import meant
from ..waves import Waves, wave_number
from ..waves.sea import surface
from .body import Array, Body, of_vehicle, row
from .constants import set_const
from .record import MAGIC, SEA, SIZE, WAVE_AT, field
from .specification import compiled, make_room

FREE = mujoco.mjtJoint.mjJNT_FREE
Wet = Vehicle | Body | Mapping[str, Vehicle | Body]


def add(
    model: mujoco.MjSpec | mujoco.MjModel,
    wet: Wet,
    current_m_s: Sequence[float] | Array = (0.0, 0.0, 0.0),
    waves: Waves | None = None,
    towards_rad: float = 0.0,
    seed: int = 0,
) -> mujoco.MjModel:
    """Put bodies of a model into water; step it inside `vtank.water.forces()`.

    Args:
        model: a specification, which is changed and compiled, or a model that was compiled from such a one.
        wet: hydrodynamics by the body's name, in that body's axes; or those of the model's one free body.
        current_m_s: velocity of the water, shape (3,), world axes [m/s].
        waves: over the still water at z = 0, for all wet bodies.
        towards_rad: where the waves run, from the world's x to its y [rad].
        seed: of an irregular sea.

    Returns the compiled model. What else stands for water in it (density, viscosity, gravcomp of wet bodies) is
    switched off. Raises InputError where body, numbers or solver do not fit; `set_const` lists the last.
    """
    bodies = wet if isinstance(wet, Mapping) else {_free_body(model): wet}
    gravity = float(np.linalg.norm((model.option if isinstance(model, mujoco.MjSpec) else model.opt).gravity))
    rows = {}
    current = np.asarray(current_m_s, dtype=float)
    if current.shape != (3,) or not np.isfinite(current).all():
        raise InputError(f"current_m_s: found {current_m_s!r}; expected three finite numbers along the world's axes")
    for name, body in bodies.items():
        if not isinstance(body, Vehicle | Body):
            raise InputError(
                f"body '{name}': found {body!r:.80}; expected a Vehicle (vtank.load_vehicle) or a water.Body"
            )
        rows[name] = row(of_vehicle(body, gravity) if isinstance(body, Vehicle) else body, name)
        field(rows[name], "water_m_s")[:] = current
    sea = _sea(waves or Waves(), towards_rad, seed)
    if isinstance(model, mujoco.MjSpec):
        return _into_spec(model, rows, sea)
    return _into_model(model, rows, sea)


def _free_body(model: mujoco.MjSpec | mujoco.MjModel) -> str:
    """Name of the one body with a free joint."""
    if isinstance(model, mujoco.MjSpec):
        names = [joint.parent.name for joint in model.joints if joint.type == FREE]
    else:
        names = [model.body(i).name for i in model.jnt_bodyid[model.jnt_type == FREE]]
    if len(names) != 1:
        raise InputError(
            f"{len(names)} bodies with a free joint: expected one, or hydrodynamics by the names of bodies"
        )
    return names[0]


def _sea(waves: Waves, towards_rad: float, seed: int) -> Array:
    """The world's row; empty in a calm."""
    if waves.reflection or waves.ramp_s:
        raise InputError(
            "waves that a wall reflects, or that are faded in, are not for whole models: expected 0 for both"
        )
    rad_s, amplitude = surface(waves, np.random.default_rng(seed))
    if not rad_s.size:
        return np.empty(0)
    k = wave_number(rad_s, waves.water_depth_m)
    speed = -rad_s * amplitude / np.expm1(-2.0 * k * waves.water_depth_m)
    way = np.ones_like(k) * math.cos(towards_rad), np.ones_like(k) * math.sin(towards_rad)
    parts = [*way, k, rad_s, speed.real, speed.imag, np.exp(-2.0 * k * waves.water_depth_m)]
    sea = np.concatenate([np.zeros(WAVE_AT.end), np.transpose(parts).ravel()])
    sea[:3] = SEA, rad_s.size, 0.0
    return sea


def _into_spec(spec: mujoco.MjSpec, rows: dict[str, Array], sea: Array) -> mujoco.MjModel:
    spec.nuser_body = max(spec.nuser_body, SIZE, sea.size)
    spec.option.density = spec.option.viscosity = 0.0
    for name, numbers in rows.items():
        if (body := spec.body(name)) is None:
            names = [body.name for body in spec.bodies if body.name and body.name != "world"]
            raise InputError(f"no body '{name}' to put into water{meant(name, names or ['none with a name'])}")
        if np.any(body.userdata) and body.userdata[0] != MAGIC:
            raise InputError(f"body '{name}' has user data of its own; expected none: the water stands there")
        body.userdata, body.gravcomp = numbers, 0.0
    if sea.size:
        spec.worldbody.userdata = sea
    model = compiled(spec)
    if crowded := [i for i in range(1, model.nbody) if model.body_simple[i] and model.body_user[i, 0] == MAGIC]:
        make_room(spec, model, crowded)
        model = compiled(spec)
    set_const(model)
    return model


def _into_model(model: mujoco.MjModel, rows: dict[str, Array], sea: Array) -> mujoco.MjModel:
    if model.nuser_body < max(SIZE, sea.size):
        raise InputError(
            f"a compiled model with room for {model.nuser_body} numbers per body, where the water takes "
            f"{max(SIZE, sea.size)}; expected its MjSpec, as of mujoco.MjSpec.from_file, which is compiled here with "
            "that room and with room for added mass in its mass matrix: nuser_body gives the first alone"
        )
    for name, numbers in rows.items():
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
        if index < 0:
            names = [model.body(i).name for i in range(1, model.nbody)]
            raise InputError(f"no body '{name}' to put into water{meant(name, names)}")
        model.body_user[index, :SIZE] = numbers
        model.body_gravcomp[index] = 0.0
    model.body_user[0, : sea.size] = sea
    model.opt.density = model.opt.viscosity = 0.0
    set_const(model)
    return model
