"""The world of a run: the vehicle of one MJCF within the walls of another. Neither has to know of the tank.

What the tank needs is written into MuJoCo's specification here, before it is compiled: integrator, water, actuators,
the group of the geoms that a sonar hears. Of the vehicle's file only
the body with the free joint is taken, with all that hangs on it. What stands for water there (density, viscosity,
gravcomp) is switched off, since the tank brings its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from .. import water
from ..errors import InputError
from ..plant.vehicle import Vehicle, load_vehicle
from ..resources import models_dir
from .layout import SIZE, SURGE, TRIM
from .mjcf import mujoco_says, named, read, read_hull
from .model import TANK_GROUP, mass_kg, propeller_height, vehicle_body
from .prepare import without_surge

ORIGIN = "vtank/origin"  # site at the vehicle's origin
LAW: dict[str, Any] = {"gainprm": np.zeros(mujoco.mjNGAIN), "biastype": mujoco.mjtBias.mjBIAS_USER}  # of a callback
LEVEL = (0.0, 1.0, 0.0, 0.0)  # quaternion of a body with axes x forward, z down that heads along the world's x
SHORTEST_S = 1e-5  # [s] time step below which a run would not end in a day; a choice
FREE = mujoco.mjtJoint.mjJNT_FREE
SWITCHED_OFF = (
    mujoco.mjtDisableBit.mjDSBL_CONTACT  # a run that strikes a wall is refused instead
    | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    | mujoco.mjtDisableBit.mjDSBL_AUTORESET  # what diverges must be seen, not started anew
)


def load_model() -> mujoco.MjModel:
    """The Phoenix in the test tank."""
    return load_world(load_vehicle("phoenix"), models_dir() / "basin.xml")


def load_world(vehicle: Vehicle, walls: Path, period_s: float | None = None, look: bool = True) -> mujoco.MjModel:
    """The vehicle's MJCF within the walls of another; InputError names the file and what is wrong with it.

    The time step is the one of the vehicle's MJCF, shortened where period_s [s] is not a multiple of it. look: with the
    shapes that are there for the eye alone, which MuJoCo moves in every step; without them nothing else changes.
    """
    hull, tank = read_hull(vehicle), read(walls)
    with named(walls):
        if tank.joints:
            raise InputError(f"the body '{tank.joints[0].parent.name}' has a joint: walls were expected to stand still")
    with named(vehicle.mjcf):
        model = submerge(hull, vehicle, tank, look)
        mass = mass_kg(model)
        if abs(mass - vehicle.mass_kg) > 1e-6 * mass:
            raise InputError(f"mass {mass:g} kg, but the vehicle file says mass_kg {vehicle.mass_kg:g}")
        if not model.opt.timestep >= SHORTEST_S:
            raise InputError(f"timestep {model.opt.timestep:g} s; expected {SHORTEST_S:g} s or more")
    if not (model.geom_group == TANK_GROUP).any():
        raise InputError(
            f"{walls}: no walls for the sonar to hear: expected geoms that collide, or in group {TANK_GROUP}"
        )
    if period_s is not None:
        model.opt.timestep = period_s / math.ceil(period_s / model.opt.timestep - 1e-6)
    return model


def submerge(
    hull: mujoco.MjSpec, vehicle: Vehicle, walls: mujoco.MjSpec | None = None, look: bool = True
) -> mujoco.MjModel:
    """The model that the tank steps: the one free body of `hull`, the vehicle, within `walls`, or in open water.

    Specifications and errors as of `set_afloat`, `look` as of `load_world`.
    """
    heard = _heard(walls) if walls else []
    world = set_afloat(hull, walls)
    if not look:
        _without_look(world, heard)
    _inject(world, vehicle)
    with mujoco_says("cannot put it between the walls"):
        if propeller_height(world.compile(), vehicle):
            add_actuator(world, TRIM, **LAW)
        model = water.add(world, {free_body(world).name: without_surge(vehicle)})
    mark_walls(model)
    return model


def set_afloat(hull: mujoco.MjSpec, walls: mujoco.MjSpec | None = None) -> mujoco.MjSpec:
    """The one free body of `hull` within `walls`, or in open water, with an integrator and a site at its origin.

    The body floats as it stands at its start in `hull`: that is level, heading along x. Both specifications are used
    up. InputError where something but the water would act on the body.
    """
    world = walls or mujoco.MjSpec()
    for actuator in list(world.actuators):
        world.delete(actuator)  # walls stand still, and the controls are the vehicle's alone
    for actuator in list(hull.actuators):
        if not (np.any(actuator.gainprm) or np.any(actuator.biasprm)):
            hull.delete(actuator)  # it pushes nothing
    for joint in hull.joints:
        joint.align = mujoco.mjtAlignFree.mjALIGNFREE_FALSE  # or MuJoCo may turn the body's axes
    with mujoco_says("cannot compile it"):
        model = hull.compile()
    body = vehicle_body(model)
    freedoms = model.body_rootid[model.dof_bodyid] == body
    if model.dof_armature[freedoms].any() or model.dof_frictionloss[freedoms].any():
        raise InputError("the free joint must have armature and frictionloss 0: the vehicle file brings the water's")
    if model.opt.gravity[0] != 0.0 or model.opt.gravity[1] != 0.0:
        raise InputError("gravity must act along the world's z axis")
    for bond in _bonds(hull):
        raise InputError(
            f"{bond} acts on the vehicle '{model.body(body).name}', and nobody here would command it; expected none: "
            "the thrusters stand in the vehicle file"
        )
    for kind in ("cameras", "geoms", "lights", "sites"):
        taken = {element.name for element in getattr(hull, kind)} - {""}
        for element in getattr(world, kind):
            element.name += " of the walls" if element.name in taken else ""
    _move(world, hull, model.qpos0[model.jnt_qposadr[model.body_jntadr[body]] :][:7])
    _set_options(world, hull.option)
    return world


def _without_look(world: mujoco.MjSpec, heard: list[mujoco.MjsGeom]) -> None:
    """Leave out what nothing here reads and MuJoCo would move in every step; `heard`: what the sonar hears."""
    for geom in heard:
        geom.contype = 1  # or it would pass for one that is there for the eye
    for element in [*world.sensors, *world.cameras, *world.lights]:
        world.delete(element)
    world.compiler.discardvisual = True


def free_body(spec: mujoco.MjSpec) -> mujoco.MjsBody:
    """The body with the free joint."""
    return _free_joint(spec).parent


def _free_joint(spec: mujoco.MjSpec) -> mujoco.MjsJoint:
    return next(joint for joint in spec.joints if joint.type == FREE)


def _bonds(hull: mujoco.MjSpec) -> Iterator[str]:
    """Actuators, tendons and equality constraints that reach the vehicle: those that MuJoCo deletes along with it."""
    kinds = {"actuators": "the actuator", "tendons": "the tendon", "equalities": "the equality constraint"}
    for kind in kinds:
        for number, element in enumerate(getattr(hull, kind)):
            element.name = element.name or f"number {number}"
    rest = hull.copy()
    rest.delete(_free_joint(rest).parent)
    for kind, what in kinds.items():
        left = {element.name for element in getattr(rest, kind)}
        yield from (f"{what} '{e.name}'" for e in getattr(hull, kind) if e.name not in left)


def _move(world: mujoco.MjSpec, hull: mujoco.MjSpec, start: np.ndarray) -> None:
    """Move the vehicle into the world, above x = y = 0, level at its start.

    start: its pose in `hull`, shape (7,). A body whose axes are not x forward, z down is carried by one whose are.
    """
    joint = _free_joint(hull)
    body, frame = joint.parent, world.worldbody.add_frame()
    body.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    body.pos, body.quat = (0.0, 0.0, start[2]), start[3:]
    if abs(start[3:] @ LEVEL) < 1.0 - 1e-12:
        carrier = world.worldbody.add_body(pos=body.pos, quat=LEVEL)
        carrier.add_joint(type=FREE, damping=joint.damping, stiffness=joint.stiffness)
        hull.delete(joint)
        body.pos, frame = np.zeros(3), carrier.add_frame(quat=LEVEL)  # LEVEL is its own inverse
    for part in body.find_all("body"):
        part.gravcomp = 0.0
    with mujoco_says("cannot put it between the walls"):
        frame.attach_body(body, "", "")


def _set_options(world: mujoco.MjSpec, own: mujoco.MjOption) -> None:
    """Integrator, origin and room for the laws; `own`: the vehicle's options, of which gravity and time step count."""
    option, body = world.option, free_body(world)
    body.name = body.name or "vtank/vehicle"
    option.timestep, option.gravity = own.timestep, own.gravity
    option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    option.disableflags, option.enableflags = int(SWITCHED_OFF), 0
    world.nuser_actuator = max(world.nuser_actuator, SIZE)
    body.add_site(name=ORIGIN)


def _inject(world: mujoco.MjSpec, vehicle: Vehicle) -> None:
    """Add the tank's actuators, which act at the body's origin; their gear is the wrench at 1 N: `prepare` finds it."""
    add_actuator(world, SURGE, dyntype=mujoco.mjtDyn.mjDYN_USER, actdim=2, **LAW)
    for number in range(len(vehicle.steering)):
        add_actuator(world, f"vtank/thruster {number}")


def add_actuator(world: mujoco.MjSpec, name: str, **settings: Any) -> None:
    """An actuator at the vehicle's origin."""
    world.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_SITE, target=ORIGIN, **settings)


def _heard(walls: mujoco.MjSpec) -> list[mujoco.MjsGeom]:
    """What a sonar hears: the geoms that would stop the vehicle; where none does, those of group 3 as MuJoCo's models
    keep the shapes that do."""
    solid = [geom for geom in walls.geoms if geom.contype or geom.conaffinity]
    return solid or [geom for geom in walls.geoms if geom.group == TANK_GROUP]


def mark_walls(model: mujoco.MjModel) -> None:
    """Give what a sonar hears, the geoms around the vehicle that would stop it, a group of their own.

    Where none collides those of group 3 are meant: there MuJoCo's models keep the shapes that do.
    """
    around = model.body_rootid[model.geom_bodyid] != vehicle_body(model)
    solid = around & ((model.geom_contype | model.geom_conaffinity) != 0)
    heard = solid if solid.any() else around & (model.geom_group == TANK_GROUP)
    model.geom_group[model.geom_group == TANK_GROUP] = 0
    model.geom_group[heard] = TANK_GROUP
