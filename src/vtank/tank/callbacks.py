"""MuJoCo's control callback, compiled: the water's forces on the vehicle, in every Runge-Kutta stage.

MuJoCo calls mjcb_control after it has found bias and passive forces and before it solves for the acceleration. The
callback solves the equation of motion with added mass (dynamics/sixdof.py) itself and applies the generalized force
that makes MuJoCo's own solution agree with it, so that added mass acts on the acceleration of the same instant.
It also writes the rates of the two states that MuJoCo integrates along with the motion, lagged thrust and wake.

Known limits: forces that MuJoCo finds only later (contacts, other actuators) move the rigid body without its added
mass; xfrc_applied on the vehicle is known in time and counts in full; qfrc_applied on the vehicle is overwritten.
"""

from __future__ import annotations

import ctypes
import functools
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import carray, types
from numba.extending import intrinsic

from ..compiled import cache_folder
from ..plant.sixdof import (
    Vector,
    Wrench,
    add,
    added_mass_forces,
    applied_forces,
    at,
    drag,
    subtract,
    term,
    to_body,
    to_world,
)
from ..plant.surge import memory_rate, surge_acceleration, thrust_now, thrust_rate, thrust_target
from .layout import AT, FIELDS, MAGIC, MAX_THRUSTERS, SIZE
from .offsets import OFFSETS

PARAMETERS = FIELDS["parameters"][0]
NUMBER = 8  # [bytes] of a float64, the unit of every address below


@intrinsic
def memory(typing_context: Any, address: Any) -> Any:
    """The memory at an address, as a C pointer to float64."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> ir.Value:
        return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

    return types.CPointer(types.float64)(types.intp), generate


@term
def array_at(address: int, shape: Any) -> np.ndarray:
    """The float64 array of that shape at an address."""
    return carray(memory(address), shape)


@term
def word_at(address: int) -> int:
    """The 64-bit integer at an address."""
    return array_at(address, 1).view(np.int64)[0]


@term
def triple(array: np.ndarray, start: int) -> Vector:
    """Three consecutive numbers."""
    return array[start], array[start + 1], array[start + 2]


@term
def six(array: np.ndarray, start: int) -> Wrench:
    """Six consecutive numbers."""
    return *triple(array, start), *triple(array, start + 3)


@term
def matrix(user: np.ndarray, start: int) -> np.ndarray:
    """The (6, 6) matrix that begins at an index."""
    return array_at(user.ctypes.data + NUMBER * start, (6, 6))


@term
def water_velocity(user: np.ndarray, time: float) -> Vector:
    """Velocity of the water [m/s], world axes."""
    since = time - user[AT.water_since_s]
    u, a = triple(user, AT.water_m_s), triple(user, AT.water_m_s2)
    return u[0] + a[0] * since, u[1] + a[1] * since, u[2] + a[2] * since


@term
def rigid_body_forces(
    user: np.ndarray, rotation: np.ndarray, passive: np.ndarray, bias: np.ndarray, external: np.ndarray
) -> Wrench:
    """What MuJoCo knows by now, in body axes: weight, centrifugal and passive forces, and the user's xfrc_applied.

    qfrc_* hold a force in world axes and a moment in body axes; xfrc_applied acts at the centre of gravity, world axes.
    """
    force, moment = to_body(rotation, triple(external, 0)), to_body(rotation, triple(external, 3))
    own = subtract(six(passive, 0), six(bias, 0))
    own = (*to_body(rotation, (own[0], own[1], own[2])), own[3], own[4], own[5])
    pushed = add(at(force, triple(user, AT.centre_of_gravity_m)), (0.0, 0.0, 0.0, *moment))
    return add(pushed, own)


@term
def hydrostatic(user: np.ndarray, rotation: np.ndarray, water: Vector) -> Wrench:
    """Buoyancy, and the pressure gradient of accelerating water on the displaced mass (Froude-Krylov)."""
    up = to_body(rotation, (0.0, 0.0, user[AT.buoyancy_N]))
    mass = user[AT.displaced_kg]
    force = (up[0] + mass * water[0], up[1] + mass * water[1], up[2] + mass * water[2])
    return at(force, triple(user, AT.centre_of_buoyancy_m))


@term
def thrusters(user: np.ndarray) -> Wrench:
    """Wrench of all thrusters but the stern propellers."""
    total = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(MAX_THRUSTERS):
        force = user[AT.thruster_N + i]
        if force != 0.0:
            x, y, z, k, m, n = six(user, AT.thruster_wrench + 6 * i)
            total = add(total, (force * x, force * y, force * z, force * k, force * m, force * n))
    return total


@term
def surge(
    user: np.ndarray,
    time: float,
    position: np.ndarray,
    rotation: np.ndarray,
    u: float,
    state: np.ndarray,
    rate: np.ndarray,
) -> Wrench:
    """Thrust and drag along x by the surge equation, times the moving mass m - X_udot; sets the rates of its states."""
    p = user[AT.parameters : AT.parameters + PARAMETERS]
    n, lag, wake = user[AT.propeller_rev_s], state[0], state[1]
    moving_mass = user[AT.rigid_mass] + user[AT.added_mass]
    gap = user[AT.wall_m] - position[0] - to_world(rotation, triple(user, AT.sonar_m))[0]
    target = thrust_target(time, n, p)
    thrust = thrust_now(lag, target, p)
    force = moving_mass * surge_acceleration(time, position[0], u, thrust, wake, n, gap, user[AT.disturbance_m_s2], p)
    rate[0] = thrust_rate(lag, target, p)
    rate[1] = memory_rate(time, position[0], u, thrust, wake, n, p)
    return force, 0.0, 0.0, 0.0, user[AT.propeller_z_m] * moving_mass * thrust, 0.0


@term
def control(
    user: np.ndarray,
    time: float,
    position: np.ndarray,
    rotation: np.ndarray,
    velocity: np.ndarray,
    state: np.ndarray,
    rate: np.ndarray,
    passive: np.ndarray,
    bias: np.ndarray,
    external: np.ndarray,
    applied: np.ndarray,
) -> None:
    """Set `applied` (6,) and `rate` (2,) of one vehicle from its userdata and MuJoCo's arrays of this instant.

    MuJoCo's velocity, and the forces that go with it, have linear parts in world axes and angular parts in body axes.
    """
    v, w = to_body(rotation, triple(velocity, 0)), triple(velocity, 3)
    flow = to_body(rotation, water_velocity(user, time))
    water = to_body(rotation, triple(user, AT.water_m_s2))
    nu = (*v, *w)
    nu_r = subtract(nu, (*flow, 0.0, 0.0, 0.0))
    known = rigid_body_forces(user, rotation, passive, bias, external)
    forces = added_mass_forces(matrix(user, AT.added_mass), nu, flow, water)
    forces = add(forces, hydrostatic(user, rotation, water))
    forces = add(forces, drag(user[AT.drag_linear :], user[AT.drag_quadratic :], nu_r))
    forces = add(forces, thrusters(user))
    forces = add(forces, surge(user, time, position, rotation, nu_r[0], state, rate))
    mass, r_g = user[AT.rigid_mass], triple(user, AT.centre_of_gravity_m)
    needed = applied_forces(matrix(user, AT.share), mass, r_g, known, forces, nu)
    applied[0], applied[1], applied[2] = to_world(rotation, (needed[0], needed[1], needed[2]))
    applied[3], applied[4], applied[5] = needed[3], needed[4], needed[5]


@functools.cache
def compiled() -> Any:
    """The callback, compiled at the first call (seconds) and cached on disk.

    The offsets are free variables of the function, so that they are part of its key in numba's cache.
    """
    nuserdata, time, qvel, ctrl, act, userdata, applied, passive, bias, external, xpos, xmat = OFFSETS.values()

    def mjcb_control(model, data):  # type: ignore[no-untyped-def]
        if word_at(model + nuserdata) < SIZE:
            return
        user = array_at(word_at(data + userdata), SIZE)
        if user[0] != MAGIC:
            return
        dof, body, lag, lag_input = int(user[AT.dof]), int(user[AT.body]), int(user[AT.lag]), int(user[AT.lag_input])
        control(
            user,
            array_at(data + time, 1)[0],
            array_at(word_at(data + xpos) + NUMBER * 3 * body, 3),
            array_at(word_at(data + xmat) + NUMBER * 9 * body, (3, 3)),
            array_at(word_at(data + qvel) + NUMBER * dof, 6),
            array_at(word_at(data + act) + NUMBER * lag, 2),
            array_at(word_at(data + ctrl) + NUMBER * lag_input, 2),
            array_at(word_at(data + passive) + NUMBER * dof, 6),
            array_at(word_at(data + bias) + NUMBER * dof, 6),
            array_at(word_at(data + external) + NUMBER * 6 * body, 6),
            array_at(word_at(data + applied) + NUMBER * dof, 6),
        )

    with cache_folder():
        return numba.cfunc(types.void(types.intp, types.intp), cache=True, error_model="numpy")(mjcb_control)


@functools.cache
def callback() -> Any:
    """The compiled callback as the C function pointer that mujoco.set_mjcb_control takes."""
    return ctypes.cast(compiled().address, ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p))
