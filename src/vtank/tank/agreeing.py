"""Whether the two files of a vehicle, its own and its MJCF, fit together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..plant.vehicle import Vehicle
from .model import centre_of_gravity, mass_kg, moments, site, vehicle_body

Array = NDArray[np.float64]
NEAR = 0.02  # of the largest moment of inertia within which the two files of a vehicle may differ; a choice
NEAR_M = 1e-3  # [m] within which the two files of a vehicle may differ about a place; a choice
TURNED = np.array([1.0, -1.0, -1.0])  # from axes z up to axes z down, x ahead in both


def place(vehicle: Vehicle, model: mujoco.MjModel, key: str, name: str) -> Array:
    """Where a site is, body axes [m]; InputError names the vehicle file's key."""
    try:
        return site(model, name)
    except InputError as reason:
        raise InputError(f"{vehicle.path}: {key}.site: {reason} ({vehicle.mjcf})") from None


def seated(vehicle: Vehicle, model: mujoco.MjModel) -> Vehicle:
    """The vehicle with the places of all thrusters and fins, also of those whose site stands in the MJCF alone."""
    sites = dict(vehicle.sites)
    for kind, parts in (("thruster", vehicle.thrusters), ("fin", vehicle.fins)):
        for number, seat in enumerate(part.site for part in parts):
            if seat not in sites:
                along, across, down = place(vehicle, model, f"{kind}[{number}]", seat)
                sites[seat] = float(along), float(across), float(down)
    return replace(vehicle, sites=sites)


def check_files(vehicle: Vehicle, model: mujoco.MjModel) -> None:
    """Raise InputError where a name is given twice, or the MJCF differs about mass, places or which way is down."""
    taken: dict[str, str] = {}
    for kind, parts in (("thruster", vehicle.thrusters), ("fin", vehicle.fins)):
        for number, name in enumerate(part.name for part in parts):
            key = f"{kind}[{number}]"
            if name in taken:  # inputs and effects are found by it
                told = f"'{name}' is taken, by {taken[name]}; expected a name of its own"
                raise InputError(f"{vehicle.path}: {key}.name: {told}")
            taken[name] = key
    mass, centre = mass_kg(model), centre_of_gravity(model, vehicle_body(model))
    if abs(mass - vehicle.mass_kg) > 1e-6 * mass:
        told = f"found {vehicle.mass_kg:g}, but {vehicle.mjcf} has {mass:g} kg"
        raise InputError(f"{vehicle.path}: body.mass_kg: {told}; is one of them without payload or ballast?")
    about = np.diag(moments(model, vehicle_body(model)))
    told_twice = (
        ("centre_of_gravity_m", vehicle.centre_m, centre, NEAR_M),
        ("inertia_kg_m2", vehicle.inertia, about, NEAR * np.abs(about).max()),
    )
    for key, written, found, near in told_twice:
        if written is not None and np.abs(found - written).max() > near:
            told = f"found {_shown(written)}, but {vehicle.mjcf} has {_shown(found)}"
            raise InputError(f"{vehicle.path}: body.{key}: {told}; one of the two files was changed alone")
    sites = {model.site(i).name for i in range(model.nsite)}
    for name, written in vehicle.sites.items():
        if name in sites and np.abs((found := site(model, name)) - written).max() > NEAR_M:
            turned = np.abs(found * TURNED - written).max() <= NEAR_M
            cause = ": the z axis of one of them points up; it must point down, y to starboard" if turned else ""
            told = f"found {_shown(written)} m, but {vehicle.mjcf} has {_shown(found)}, seen from x forward, z down"
            raise InputError(f"{vehicle.path}: sites.{name}_m: {told}{cause}")
    if vehicle.centre_of_buoyancy_m[2] > centre[2] + 1e-9:
        raise InputError(
            f"{vehicle.path}: body.centre_of_buoyancy_m: z = {vehicle.centre_of_buoyancy_m[2]:g} m is below the centre "
            f"of gravity, z = {centre[2]:g} m: it would capsize; does the z axis point up? expected z down"
        )


def _shown(vector: Sequence[float] | Array) -> str:
    return "[" + ", ".join(f"{value:g}" for value in vector) + "]"
