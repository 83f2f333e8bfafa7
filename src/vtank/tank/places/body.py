"""Effects of the vehicle itself: its centres, its trim, and what pulls or carries all of it."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from ...plant.vehicle import Vehicle
from ...water.record import SIZE, field
from . import laws
from .effect import VEHICLE, Array, Moving, Number, PlacedEffect, Values

XYZ = tuple(
    Number(axis, ("_m",), f"along the body's {axis}", 0.0, -10.0, 10.0, usual=lambda s: 0.05 * s.hull) for axis in "xyz"
)
EARTH = ("north", "east", "down")
LEAD_KG_M3 = 11340.0


def buoyed_elsewhere(vehicle: Vehicle, place: str, p: Values) -> Vehicle:
    """The centre of buoyancy shifted."""
    return replace(vehicle, centre_of_buoyancy_m=vehicle.centre_of_buoyancy_m + (p["x"], p["y"], p["z"]))


def lighter(vehicle: Vehicle, place: str, p: Values) -> Vehicle:
    """More buoyancy."""
    return replace(vehicle, buoyancy_N=vehicle.buoyancy_N + p["B"])


def heavy_elsewhere(spec: mujoco.MjSpec, p: Values) -> None:
    """The centre of gravity of the whole vehicle shifted, inertia about it kept."""
    body = free(spec)
    model = spec.copy().compile()
    index = model.body(body.name).id
    body.explicitinertial, body.mass = True, model.body_mass[index]
    share = model.body_subtreemass[index] / model.body_mass[index]
    body.ipos = model.body_ipos[index] + share * np.array([p["x"], p["y"], p["z"]])
    body.iquat, body.inertia, body.fullinertia = model.body_iquat[index], model.body_inertia[index], np.full(6, np.nan)


def weighted(spec: mujoco.MjSpec, p: Values) -> None:
    """A sphere of lead, which displaces nothing, fixed to the body."""
    radius = np.cbrt(p["m"] / LEAD_KG_M3 * 0.75 / np.pi)
    free(spec).add_body(
        name="vtank/trim weight", pos=(p["x"], p["y"], p["z"]), ipos=np.zeros(3), explicitinertial=True,
        mass=p["m"], inertia=np.full(3, 0.4 * p["m"] * radius**2),
    )  # fmt: skip


def free(spec: mujoco.MjSpec) -> mujoco.MjsBody:
    """The body with the free joint."""
    return next(joint.parent for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE)


def left_out(s: Moving, place: str, p: Values) -> Array:
    """Takes away a share of the added mass' Coriolis and centripetal forces, the Munk moment among them."""
    return p["share"] * np.array(laws.turning(s.vehicle.added_mass, tuple(s.through)))


def strips(s: Moving, place: str, p: Values) -> Array:
    """Drag of the flow across the hull from tail to nose."""
    user = np.zeros(SIZE)
    field(user, "cross_flow")[...] = p["tail"], p["nose"], p["sway"], p["heave"]
    return np.array(laws.strips(user, tuple(s.through)))


def pulled(s: Moving, place: str, p: Values) -> Array:
    """A tension, and a spring about where the run began, in earth axes, at a place of the body."""
    at = np.array([p["x"], p["y"], p["z"]])
    tension = s.earth.T @ [p[axis] for axis in EARTH]  # away[:3] is in body axes already
    start = s.earth.T @ at  # the place of attachment at the start, heading north and level
    force = tension - p["k"] * (s.away[:3] + at - start)
    return np.concatenate([force, np.cross(at, force)])


VEHICLES = (
    PlacedEffect(
        "centre_of_gravity",
        VEHICLE,
        "The centre of gravity is not where the vehicle file has it.",
        "r_G -> r_G + (x, y, z)",
        XYZ,
        rigid=heavy_elsewhere,
    ),
    PlacedEffect(
        "centre_of_buoyancy",
        VEHICLE,
        "The centre of buoyancy is not where the vehicle file has it.",
        "r_B -> r_B + (x, y, z)",
        XYZ,
        changes=buoyed_elsewhere,
    ),
    PlacedEffect(
        "buoyancy",
        VEHICLE,
        "The vehicle is lighter or heavier in water than its file has it.",
        "B -> B + B",
        (Number("B", ("_N",), "more buoyancy", usual=lambda s: 0.005 * s.weight),),
        changes=lighter,
    ),
    PlacedEffect(
        "trim_weight",
        VEHICLE,
        "A weight has been added and forgotten.",
        "m, at (x, y, z)",
        (Number("m", ("_kg",), "mass of lead", low=1e-3, high=1e5, usual=lambda s: 0.0005 * s.weight), *XYZ),
        rigid=weighted,
    ),
    PlacedEffect(
        "coriolis_left_out",
        VEHICLE,
        "Coriolis and Munk terms of the added mass are left out, or part of them.",
        "C_A -> (1 - share) C_A",
        (Number("share", ("",), "of them that is left out", 1.0, 0.0, 1.0, usual=lambda _: 0.8),),
        wrench=left_out,
    ),
    PlacedEffect(
        "cross_flow_drag",
        VEHICLE,
        "Every strip of the hull drags in the flow that it meets itself.",
        "dY = -sway |V| (v + x r) dx, dZ = -heave |V| (w - x q) dx, from tail to nose",
        (
            Number(
                "sway", ("_N_s2_per_m3",), "drag per length in sway", 0.0, 0.0, usual=lambda s: 3.0 * s.force / s.u**2
            ),
            Number(
                "heave", ("_N_s2_per_m3",), "drag per length in heave", 0.0, 0.0, usual=lambda s: 3.0 * s.force / s.u**2
            ),
            Number("tail", ("_m",), "hindmost x", low=-100.0, high=100.0, usual=lambda s: -s.hull, shape=True),
            Number("nose", ("_m",), "foremost x", low=-100.0, high=100.0, usual=lambda s: s.hull, shape=True),
        ),
        wrench=strips,
    ),
    PlacedEffect(
        "current",
        VEHICLE,
        "The water drifts steadily, as a vector over ground.",
        "nu_r = nu - R' U",
        tuple(Number(axis, ("_m_s",), f"speed {axis}", 0.0, -5.0, 5.0, usual=lambda _: 0.1) for axis in EARTH),
        drifts=lambda p: (p["north"], p["east"], p["down"]),
    ),
    PlacedEffect(
        "tether",
        VEHICLE,
        "A cable pulls at a place of the hull, and back to where the run began.",
        "F = R' (north, east, down) - k (displacement of the place)",
        (
            *(Number(axis, ("_N",), f"tension {axis}", 0.0, usual=lambda s: s.force) for axis in EARTH),
            Number("k", ("_N_per_m",), "stiffness", 0.0, 0.0, usual=lambda s: 0.3 * s.force),
            *XYZ,
        ),
        wrench=pulled,
    ),
)
