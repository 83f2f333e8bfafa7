"""Bodies for the tests of the tank: an awkward one in which every coupling is at work, and the Phoenix in its tank."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from vtank.plant.parameters import vector
from vtank.plant.vehicle import Thruster, Vehicle, load_vehicle
from vtank.tank import load_model, submerge

MASS = 20.0  # [kg]
INERTIA = np.array([[1.2, 0.1, -0.2], [0.1, 2.6, 0.15], [-0.2, 0.15, 2.9]])  # [kg m2] about the centre of gravity
GRAVITY_CENTRE = np.array([0.03, -0.02, 0.05])  # [m]
BUOYANCY_CENTRE = np.array([0.02, 0.01, -0.04])  # [m]
G = 9.80665  # [m/s2]

MJCF = """
<mujoco>
  <option timestep="{timestep}" gravity="0 0 {gravity}"/>
  <worldbody>
    <body name="awkward" quat="0 1 0 0">
      <freejoint/>
      <inertial mass="20" pos="0.03 -0.02 0.05" fullinertia="1.2 2.6 2.9 0.1 -0.2 0.15"/>
      <site name="propeller" pos="-0.8 0 0.1"/>
      <site name="side" pos="0.4 0.1 -0.2"/>
      <site name="oblique" pos="-0.3 0.2 0.1"/>
    </body>
  </worldbody>
</mujoco>
"""
THRUSTERS = (Thruster("side", (0.0, 1.0, 0.0), 50.0), Thruster("oblique", (0.36, -0.48, 0.8), 50.0))


def symmetric_mass(seed: int = 5) -> np.ndarray:
    """A full added-mass matrix, shape (6, 6), positive definite, of the size of the body's own mass."""
    scale = np.diag(np.sqrt([4.0, 18.0, 25.0, 0.8, 2.0, 1.5]))
    mix = np.random.default_rng(seed).normal(size=(6, 6))
    correlation = 0.9 * np.eye(6) + 0.1 * mix @ mix.T / 6.0
    return scale @ correlation @ scale


def afloat(xml: str) -> mujoco.MjModel:
    """The vehicle of an MJCF in open water, as the tank steps it."""
    return submerge(mujoco.MjSpec.from_string(xml), awkward_vehicle())


def awkward_model(timestep: float = 0.01, gravity: float = 0.0) -> mujoco.MjModel:
    """One free body with its centre of gravity off the origin and full inertia; gravity [m/s2] along world z."""
    return afloat(MJCF.format(timestep=timestep, gravity=gravity))


def awkward_vehicle(drag: bool = False, buoyancy_N: float = 0.0) -> Vehicle:
    """Its water: full added mass; on request drag on all axes but surge, and buoyancy at its own centre."""
    return Vehicle(
        name="awkward",
        mjcf=Path("inline"),
        mass_kg=MASS,
        added_mass=symmetric_mass(),
        quadratic_drag=drag * np.array([0.0, 30.0, 50.0, 2.0, 6.0, 5.0]),
        linear_drag=drag * np.array([0.0, 2.0, 3.0, 0.5, 1.0, 0.8]),
        buoyancy_N=buoyancy_N,
        centre_of_buoyancy_m=BUOYANCY_CENTRE,
        propeller_sites=("propeller",),
        propeller_diameter_m=0.1,
        thrusters=THRUSTERS,
    )


def rigid_mass() -> np.ndarray:
    """M_RB of the awkward body about its origin, by the textbook (Fossen 2011, eq. 3.44), shape (6, 6)."""
    s = skew(GRAVITY_CENTRE)
    return np.block([[MASS * np.eye(3), -MASS * s], [MASS * s, INERTIA - MASS * s @ s]])


def skew(a: np.ndarray) -> np.ndarray:
    """Matrix of the cross product a x, shape (3, 3)."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def rotation(qpos: np.ndarray) -> np.ndarray:
    """Body to world, shape (..., 3, 3), of poses (..., 7) with MuJoCo's quaternion (w, x, y, z)."""
    return Rotation.from_quat(qpos[..., [4, 5, 6, 3]]).as_matrix()


def body_velocity(qpos: np.ndarray, qvel: np.ndarray) -> np.ndarray:
    """nu = (v, w) in body axes, shape (..., 6), from MuJoCo's mixed velocity."""
    v = np.einsum("...ji,...j->...i", rotation(qpos), qvel[..., :3])
    return np.concatenate([v, qvel[..., 3:]], axis=-1)


def set_velocity(qpos: np.ndarray, qvel: np.ndarray, nu: np.ndarray) -> None:
    """Write nu, shape (..., 6) in body axes, into MuJoCo's velocity."""
    qvel[..., :3] = np.einsum("...ij,...j->...i", rotation(qpos), nu[..., :3])
    qvel[..., 3:] = nu[..., 3:]


def phoenix() -> tuple[mujoco.MjModel, Vehicle]:
    """The model and the vehicle that come with vtank."""
    return load_model(), load_vehicle("phoenix")


def without_drag(**values: float) -> np.ndarray:
    """Surge parameters: no drag, no thrust, no lag, except for those given (dots as double underscores)."""
    return vector({name.replace("__", "."): value for name, value in values.items()})
