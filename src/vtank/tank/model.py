"""Load and check the MJCF of a tank with a vehicle in it."""

from __future__ import annotations

from pathlib import Path

import mujoco

from ..errors import InputError
from ..resources import models_dir

STATES = ("thrust_lag", "wake")  # actuators that carry the states z and wake, in this order
USERDATA = 512  # float64 per simulation for parameters and inputs: the tank's layout must fit
ECHO_GROUP = 3  # geom group of everything a sonar hears


def load_tank_model(path: str | Path | None = None) -> mujoco.MjModel:
    """Compiled tank, models/tank.xml by default.

    Raises InputError, naming the file and what is wrong, where MuJoCo cannot read it or where it lacks what a tank
    needs: one free body, the two state actuators, room in userdata, echo surfaces and RK4.
    """
    path = models_dir() / "tank.xml" if path is None else Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such MJCF file")
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise InputError(f"{path}: MuJoCo cannot read it: {' '.join(str(error).split())}") from None
    for complaint in _complaints(model):
        raise InputError(f"{path}: {complaint}")
    return model


def check_sites(model: mujoco.MjModel, sites: tuple[str, ...], path: str | Path) -> None:
    """InputError where the model lacks a site that the vehicle or a scenario names."""
    there = [model.site(index).name for index in range(model.nsite)]
    for name in sites:
        if name not in there:
            raise InputError(f"{path}: no site named '{name}'; there are: {', '.join(there)}")


def _complaints(model: mujoco.MjModel) -> list[str]:
    free = [joint for joint in model.jnt_type if joint == mujoco.mjtJoint.mjJNT_FREE]
    actuators = tuple(model.actuator(index).name for index in range(model.nu))
    found = []
    if len(free) != 1 or model.nv != 6:
        found.append(
            f"expected one free body (the vehicle) and no other joint; found {len(free)} free, {model.nv} degrees of freedom"
        )
    if actuators != STATES or model.na != len(STATES):
        found.append(
            f'expected the actuators {" and ".join(STATES)}, dyntype="integrator", in this order; found {", ".join(actuators) or "none"}'
        )
    if model.nuserdata < USERDATA:
        found.append(f'expected <size nuserdata="{USERDATA}"/>; found {model.nuserdata}')
    if model.opt.integrator != mujoco.mjtIntegrator.mjINT_RK4:
        found.append('expected <option integrator="RK4"/>')
    if model.opt.density or model.opt.viscosity:
        found.append('expected <option density="0" viscosity="0"/>: water acts through the callback, not twice')
    if not (model.geom_group == ECHO_GROUP).any():
        found.append(f"expected walls for the sonar: geoms in group {ECHO_GROUP}; found none")
    return found
