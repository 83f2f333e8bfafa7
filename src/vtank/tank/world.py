"""The world of a run: the vehicle of one MJCF within the walls of another. Neither has to know of the tank.

What the tank needs is written into MuJoCo's specification here, before it is compiled: integrator, room for the
callback's numbers, the states that it carries, the group of the geoms that a sonar hears. Of the vehicle's file only
the body with the free joint is taken, with all that hangs on it. What stands for water there (density, viscosity,
gravcomp) is switched off, since the tank brings its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from pathlib import Path

import mujoco
import numpy as np

from ..errors import InputError
from ..plant.vehicle import Vehicle, load_vehicle
from ..resources import models_dir
from .layout import SIZE
from .mjcf import mujoco_says, named, read
from .model import STATES, TANK_GROUP, vehicle_body

LEVEL = (0.0, 1.0, 0.0, 0.0)  # quaternion of a body with axes x forward, z down that heads along the world's x
FREE = mujoco.mjtJoint.mjJNT_FREE
SWITCHED_OFF = (
    mujoco.mjtDisableBit.mjDSBL_CONTACT  # such forces come too late for the added mass
    | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    | mujoco.mjtDisableBit.mjDSBL_AUTORESET  # what diverges must be seen, not started anew
)


def load_model() -> mujoco.MjModel:
    """The Phoenix in the test tank."""
    return load_world(load_vehicle("phoenix"), models_dir() / "basin.xml")


def load_world(vehicle: Vehicle, walls: Path, period_s: float | None = None) -> mujoco.MjModel:
    """The vehicle's MJCF within the walls of another; InputError names the file and what is wrong with it.

    The time step is the one of the vehicle's MJCF, shortened where period_s [s] is not a multiple of it.
    """
    hull, tank = read(vehicle.mjcf), read(walls)
    with named(walls):
        mark_walls(tank)
    with named(vehicle.mjcf):
        model = submerge(hull, tank)
        mass = float(model.body_subtreemass[vehicle_body(model)])
        if abs(mass - vehicle.mass_kg) > 1e-6 * mass:
            raise InputError(f"mass {mass:g} kg, but the vehicle file says mass_kg {vehicle.mass_kg:g}")
    if period_s is not None:
        model.opt.timestep = period_s / math.ceil(period_s / model.opt.timestep - 1e-6)
    return model


def mark_walls(walls: mujoco.MjSpec) -> None:
    """Give what a sonar hears, the geoms that would stop a hull, a group of their own.

    Where none collides those of group 3 are meant: there MuJoCo's models keep the shapes that do.
    """
    solid = [geom for geom in walls.geoms if geom.contype or geom.conaffinity]
    solid = solid or [geom for geom in walls.geoms if geom.group == TANK_GROUP]
    if not solid:
        raise InputError(f"no walls for the sonar to hear: expected geoms that collide, or some in group {TANK_GROUP}")
    if walls.joints:
        raise InputError(f"the body '{walls.joints[0].parent.name}' has a joint: walls were expected to stand still")
    _mute(walls.geoms)
    for geom in solid:
        geom.group = TANK_GROUP


def _mute(geoms: Iterable[mujoco.MjsGeom]) -> None:
    for geom in geoms:
        geom.group = 0 if geom.group == TANK_GROUP else geom.group


def submerge(hull: mujoco.MjSpec, walls: mujoco.MjSpec | None = None) -> mujoco.MjModel:
    """The model that the tank steps: the one free body of `hull` within `walls`, or in open water.

    The body floats as it stands at its start in `hull`: that is level, heading along x. Both specifications are used
    up. InputError where something but the water would act on the body.
    """
    world = walls or mujoco.MjSpec()
    for actuator in list(hull.actuators):
        if not (np.any(actuator.gainprm) or np.any(actuator.biasprm)):
            hull.delete(actuator)  # it pushes nothing
    with mujoco_says("cannot compile it"):
        model = hull.compile()
    body = vehicle_body(model)
    if model.opt.gravity[0] != 0.0 or model.opt.gravity[1] != 0.0:
        raise InputError("gravity must act along the world's z axis")
    for bond in _bonds(hull):
        raise InputError(
            f"{bond} acts on the vehicle '{model.body(body).name}' past its added mass; expected none: the thrusters "
            "stand in the vehicle file"
        )
    _set_afloat(world, hull, model.qpos0[model.jnt_qposadr[model.body_jntadr[body]] :][:7])
    _inject(world, hull.option)
    with mujoco_says("cannot put it between the walls"):
        return world.compile()


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


def _set_afloat(world: mujoco.MjSpec, hull: mujoco.MjSpec, start: np.ndarray) -> None:
    """Move the vehicle into the world, above x = y = 0, level at its start.

    start: its pose in `hull`, shape (7,). A body whose axes are not x forward, z down is carried by one whose are.
    """
    joint = _free_joint(hull)
    body, place, frame = joint.parent, [0.0, 0.0, float(start[2])], world.worldbody.add_frame()
    body.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    body.pos, body.quat = place, start[3:]
    if abs(start[3:] @ LEVEL) < 1.0 - 1e-12:
        carrier = world.worldbody.add_body(pos=place, quat=LEVEL)
        carrier.add_joint(type=FREE, damping=joint.damping, stiffness=joint.stiffness)
        hull.delete(joint)
        body.pos, frame = [0.0, 0.0, 0.0], carrier.add_frame(quat=LEVEL)  # LEVEL is its own inverse
    for part in (body, *body.find_all("body")):
        part.gravcomp = 0.0
    _mute(body.find_all("geom"))
    with mujoco_says("cannot put it between the walls"):
        frame.attach_body(body, "", "")


def _inject(world: mujoco.MjSpec, own: mujoco.MjOption) -> None:
    """Write what the tank needs into the world; `own`: the vehicle's options, of which gravity and time step count."""
    option, joint = world.option, _free_joint(world)
    option.timestep, option.gravity = own.timestep, own.gravity
    option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    option.density = option.viscosity = 0.0
    option.disableflags, option.enableflags = int(SWITCHED_OFF), 0
    world.nuserdata = SIZE
    joint.name = joint.name or "vtank/free"
    for name in STATES:
        world.add_actuator(
            name=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            target=joint.name,
            dyntype=mujoco.mjtDyn.mjDYN_INTEGRATOR,
            gainprm=np.zeros(mujoco.mjNGAIN),
        )
