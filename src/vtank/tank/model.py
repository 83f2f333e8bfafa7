"""What the tank needs of a MuJoCo model: one free body, two integrators for its extra states, room in userdata."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from xml.sax.saxutils import quoteattr

import mujoco
import numpy as np

from ..effects import thrust_lag
from ..errors import InputError
from ..plant.vehicle import Vehicle
from ..resources import models_dir
from .layout import SIZE

STATES = (thrust_lag.EFFECT.name, "wake")  # integrators that carry the surge equation's extra states
TANK_GROUP = 3  # geom group of walls and floor: what a sonar hears
INTEGRATORS = (mujoco.mjtIntegrator.mjINT_RK4, mujoco.mjtIntegrator.mjINT_EULER)


def load_model(path: str | Path | None = None) -> mujoco.MjModel:
    """The compiled MJCF, by default models/tank.xml; InputError names the file and what is wrong with it."""
    path = models_dir() / "tank.xml" if path is None else Path(path)
    _check_file(path)
    return _checked(lambda: mujoco.MjModel.from_xml_path(str(path)), str(path))


def load_world(vehicle: Vehicle, walls: Path) -> mujoco.MjModel:
    """The vehicle's MJCF within the walls of another; InputError names the files and what is wrong with them."""
    for path in (vehicle.mjcf, walls):
        _check_file(path)
    includes = "".join(f"<include file={quoteattr(str(path.resolve()))}/>" for path in (vehicle.mjcf, walls))
    text = f'<mujoco model="{vehicle.name}">{includes}</mujoco>'
    model = _checked(lambda: mujoco.MjModel.from_xml_string(text), f"{vehicle.mjcf} in {walls}")
    mass = float(model.body(vehicle_body(model)).mass[0])
    if abs(mass - vehicle.mass_kg) > 1e-6 * mass:
        raise InputError(f"{vehicle.mjcf}: mass {mass:g} kg, but the vehicle file says mass_kg {vehicle.mass_kg:g}")
    return model


def _check_file(path: Path) -> None:
    if not path.is_file():
        raise InputError(f"{path}: no such MJCF file")


def _checked(compile: Callable[[], mujoco.MjModel], path: str) -> mujoco.MjModel:
    try:
        model = compile()
    except ValueError as reason:
        raise InputError(f"{path}: MuJoCo cannot read it: {' '.join(str(reason).split())}") from None
    try:
        check_model(model)
    except InputError as reason:
        raise InputError(f"{path}: {reason}") from None
    if not (model.geom_group == TANK_GROUP).any():
        raise InputError(f"{path}: no walls for the sonar to hear: expected geoms in group {TANK_GROUP}")
    return model


def check_model(model: mujoco.MjModel) -> None:
    """Raise InputError, saying what was expected, unless the callback can drive this model."""
    option = model.opt
    if model.nuserdata < SIZE:
        raise InputError(f'the MJCF reserves {model.nuserdata} userdata; write <size nuserdata="{SIZE}"/> or more')
    if option.integrator not in INTEGRATORS:
        raise InputError('the MJCF must use <option integrator="RK4"/> or "Euler": others bend the added mass')
    if option.density != 0.0 or option.viscosity != 0.0:
        raise InputError("the MJCF must have density and viscosity 0: vtank brings the water, it would count twice")
    if option.gravity[0] != 0.0 or option.gravity[1] != 0.0:
        raise InputError("gravity must act along the world's z axis")
    _check_states(model)
    vehicle_body(model)


def _check_states(model: mujoco.MjModel) -> None:
    addresses = []
    for name in STATES:
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name)
        if index < 0 or model.actuator_dyntype[index] != mujoco.mjtDyn.mjDYN_INTEGRATOR:
            raise InputError(f'the MJCF needs an actuator \'{name}\' with dyntype="integrator" and gainprm="0"')
        if model.actuator_gainprm[index].any() or model.actuator_biasprm[index].any():
            raise InputError(f"the actuator '{name}' only carries a state: its gain and bias must be 0")
        if model.actuator_ctrllimited[index] or model.actuator_actlimited[index]:
            raise InputError(f"the actuator '{name}' only carries a state: it must not be limited")
        addresses.append((index, model.actuator_actadr[index]))
    if addresses[1] != (addresses[0][0] + 1, addresses[0][1] + 1):
        raise InputError(f"the actuators {' and '.join(STATES)} must follow each other in the MJCF")


def vehicle_body(model: mujoco.MjModel) -> int:
    """Id of the one body with a free joint and nothing jointed to it."""
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    if len(free) != 1:
        raise InputError(f"the MJCF has {len(free)} bodies with a free joint; exactly one, the vehicle, was expected")
    body = int(model.jnt_bodyid[free[0]])
    freedoms = model.body_rootid[model.dof_bodyid] == body
    if np.count_nonzero(freedoms) != 6:
        raise InputError(f"the vehicle '{model.body(body).name}' must be one rigid body, without further joints")
    if model.dof_armature[freedoms].any():
        raise InputError("the free joint must have armature 0: added mass stands in the vehicle file")
    return body


def rigid_mass(model: mujoco.MjModel, body: int) -> np.ndarray:
    """Mass matrix M_RB of the compiled body in body axes, shape (6, 6) [kg, kg m, kg m2]."""
    data = mujoco.MjData(model)
    start = model.jnt_qposadr[model.body_jntadr[body]]
    data.qpos[start + 3 : start + 7] = (1.0, 0.0, 0.0, 0.0)
    mujoco.mj_fwdPosition(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    dof = model.body_dofadr[body]
    return full[dof : dof + 6, dof : dof + 6]


def site(model: mujoco.MjModel, name: str) -> np.ndarray:
    """Position of a site in body axes, shape (3,) [m]."""
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, name)
    if index < 0:
        names = ", ".join(model.site(i).name for i in range(model.nsite))
        raise InputError(f"the MJCF has no site '{name}'; there are: {names or 'none'}")
    return model.site_pos[index]


def sonars(model: mujoco.MjModel) -> list[str]:
    """Names of the sonars' sites, in the order of the MJCF."""
    names = [model.site(i).name for i in np.flatnonzero(model.site_bodyid == vehicle_body(model))]
    return [name for name in names if name.startswith("sonar")]


def sonar_and_wall(model: mujoco.MjModel, body: int) -> tuple[np.ndarray, float]:
    """Position of the first sonar in body axes [m], and world x of the wall ahead of the start pose (inf: none) [m]."""
    names = sonars(model)
    position = site(model, names[0]) if names else np.zeros(3)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    origin = data.xpos[body] + data.xmat[body].reshape(3, 3) @ position
    group = np.zeros(mujoco.mjNGROUP, dtype=np.uint8)
    group[TANK_GROUP] = 1
    distance = mujoco.mj_ray(model, data, origin, np.array([1.0, 0.0, 0.0]), group, 1, -1, np.zeros(1, dtype=np.int32))
    return position, float(origin[0] + distance) if distance >= 0.0 else np.inf
