"""Questions to a compiled model: which body is the vehicle, its mass, its sites, where the wall ahead stands."""

from __future__ import annotations

import mujoco
import numpy as np

from ..errors import InputError
from ..plant.vehicle import Vehicle
from ..record.toml import meant
from .layout import SIZE, SURGE, TRIM

TANK_GROUP = 3  # geom group of walls and floor: what a sonar hears
HEARD = (np.arange(mujoco.mjNGROUP) == TANK_GROUP).astype(np.uint8)  # for MuJoCo's rays


def check_model(model: mujoco.MjModel, vehicle: Vehicle) -> None:
    """Raise InputError unless the callbacks can drive this model of the vehicle."""
    names = {model.actuator(i).name for i in range(model.nu)}
    if model.nuser_actuator < SIZE or SURGE not in names:
        raise InputError("this model was not made for the tank; expected one that load_world or submerge made")
    if (found := len(names - {SURGE, TRIM})) != (wanted := len(vehicle.steering)):
        raise InputError(f"the model has {found} thrusters; expected the vehicle's {wanted}")
    if propeller_height(model, vehicle) and TRIM not in names:
        raise InputError("the model was made for propellers on the vehicle's axis; the vehicle's are off it")


def vehicle_body(model: mujoco.MjModel) -> int:
    """Id of the one body with a free joint and nothing jointed to it."""
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    if len(free) != 1:
        raise InputError(f"{len(free)} bodies with a free joint; exactly one, the vehicle, was expected")
    body = int(model.jnt_bodyid[free[0]])
    freedoms = model.body_rootid[model.dof_bodyid] == body
    if np.count_nonzero(freedoms) != 6:
        raise InputError(f"the vehicle '{model.body(body).name}' must be one rigid body, without further joints")
    return body


def mass_kg(model: mujoco.MjModel) -> float:
    """Mass of the vehicle with all that is fixed to it."""
    return float(model.body_subtreemass[vehicle_body(model)])


def at_origin(model: mujoco.MjModel) -> mujoco.MjData:
    """The vehicle with its body axes along the world's, origin on origin."""
    data = mujoco.MjData(model)
    data.qpos[model.jnt_qposadr[model.body_jntadr[vehicle_body(model)]] :][:7] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    mujoco.mj_fwdPosition(model, data)
    return data


def rigid_mass(model: mujoco.MjModel, body: int) -> np.ndarray:
    """Mass matrix M_RB of the compiled body in body axes, shape (6, 6) [kg, kg m, kg m2]."""
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, at_origin(model), full)
    dof = model.body_dofadr[body]
    return full[dof : dof + 6, dof : dof + 6]


def moments(model: mujoco.MjModel, body: int) -> np.ndarray:
    """Inertia of the vehicle and all that is fixed to it about its centre of gravity, body axes, (3, 3) [kg m2]."""
    mass, centre = rigid_mass(model, body), centre_of_gravity(model, body)
    return np.asarray(mass[3:, 3:] - mass[0, 0] * (centre @ centre * np.eye(3) - np.outer(centre, centre)))


def centre_of_gravity(model: mujoco.MjModel, body: int) -> np.ndarray:
    """Centre of gravity of the vehicle and all that is fixed to it in body axes, shape (3,) [m]."""
    place, parts = at_origin(model).xipos, model.body_rootid == body
    return place[body] + model.body_mass[parts] @ (place[parts] - place[body]) / model.body_subtreemass[body]


def site(model: mujoco.MjModel, name: str) -> np.ndarray:
    """Position of a site of the vehicle in body axes, shape (3,) [m]."""
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, name)
    if index < 0:
        names = [model.site(i).name for i in range(model.nsite) if not model.site(i).name.startswith("vtank/")]
        raise InputError(f"the MJCF has no site '{name}'{meant(name, names or ['none'])}")
    return at_origin(model).site_xpos[index].copy()


def propeller_height(model: mujoco.MjModel, vehicle: Vehicle) -> float:
    """Mean z of the propellers' axes, body axes [m]."""
    if not vehicle.propeller_sites:
        raise InputError(f"{vehicle.path}: no propeller drives surge alone; expected a thruster that pushes straight "
                         "ahead, or [propeller] with sites")  # fmt: skip
    return float(np.mean([site(model, name)[2] for name in vehicle.propeller_sites]))


def sonars(model: mujoco.MjModel) -> list[str]:
    """Names of the sonars' sites, in the order of the MJCF."""
    names = [model.site(i).name for i in np.flatnonzero(model.body_rootid[model.site_bodyid] == vehicle_body(model))]
    return [name for name in names if name.startswith("sonar")]


def sonar_and_wall(model: mujoco.MjModel, body: int) -> tuple[np.ndarray, float]:
    """Position of the first sonar in body axes [m], and world x of the wall ahead of the start pose (inf: none) [m]."""
    names = sonars(model)
    position = site(model, names[0]) if names else np.zeros(3)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    origin = data.xpos[body] + data.xmat[body].reshape(3, 3) @ position
    distance = mujoco.mj_ray(model, data, origin, np.array([1.0, 0.0, 0.0]), HEARD, 1, -1, np.zeros(1, dtype=np.int32))
    return position, float(origin[0] + distance) if distance >= 0.0 else np.inf
