"""MuJoCo's control callback, compiled: added mass into the mass matrix itself, the water's forces beside it.

MuJoCo calls mjcb_control in every Runge-Kutta stage after it has built and factored the mass matrix M, and before
anything is solved with it. Here J'M_A J of every wet body is added, J taking generalized velocities to the body's own,
and M is factored anew; actuators, contacts, joints and sensors then see one body whose inertia includes the water's.
J'M_A J couples only joints that are ancestors of each other, for which M has room. What remains of the water's force
(forces.py) goes to qfrc_fluid, and by that into qfrc_passive; qfrc_applied stays the user's. Every integrator treats
these forces explicitly: a time step must be short against mass over drag.

MuJoCo may call again without having built M, or found velocities, anew (mjd_transitionFD, mj_step1). So M is marked as
wet in a number that only mj_makeM writes, the world's entry of mjData.crb, which is always zero there; and qfrc_fluid
tells what is already in qfrc_passive.
"""

from __future__ import annotations

import ctypes
import functools
from typing import Any

import mujoco
import numba
import numpy as np
from numba import types

from ..compiled import cache_folder, term
from ..plant.sixdof import Vector, Wrench, add, cross, multiply, to_body, to_world
from . import offsets
from .forces import plus, water_force
from .library import factor_mass
from .pointers import NUMBER, array_at, choice, matrix, numbers, six, triple, whole, word_at
from .record import AT, MAGIC, SIZE

OFFSETS = offsets.AT
PGS = int(mujoco.mjtSolver.mjSOL_PGS)
WET = 1.0  # mark in mjData.crb


@term
def shifted(motion: Wrench, rotation: np.ndarray, arm: Vector) -> Wrench:
    """A motion that MuJoCo gives about the tree's centre of mass, world axes, angular part first: at the body's origin
    and in the body's axes, linear part first. arm: from centre of mass to origin."""
    w = (motion[0], motion[1], motion[2])
    v = plus((motion[3], motion[4], motion[5]), cross(w, arm))
    return *to_body(rotation, v), *to_body(rotation, w)


@term
def dot(a: np.ndarray, b: Wrench) -> float:
    """a . b, from numbers of an array."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]


@term
def wet_free_mass(mass: np.ndarray, added: np.ndarray, rotation: np.ndarray) -> None:
    """Add J'M_A J of a free body to its 21 numbers of M, lower triangle by rows; J = blkdiag(R', 1)."""
    for i in range(3):
        x, y, z = rotation[i, 0], rotation[i, 1], rotation[i, 2]
        turned = (
            x * added[0, 0] + y * added[1, 0] + z * added[2, 0],
            x * added[0, 1] + y * added[1, 1] + z * added[2, 1],
            x * added[0, 2] + y * added[1, 2] + z * added[2, 2],
        )
        start = i * (i + 1) // 2
        for j in range(i + 1):
            mass[start + j] += turned[0] * rotation[j, 0] + turned[1] * rotation[j, 1] + turned[2] * rotation[j, 2]
    for i in range(3, 6):
        start = i * (i + 1) // 2
        moment = to_world(rotation, (added[i, 0], added[i, 1], added[i, 2]))
        mass[start] += moment[0]
        mass[start + 1] += moment[1]
        mass[start + 2] += moment[2]
        for j in range(3, i + 1):
            mass[start + j] += added[i, j]


@term
def factor_free(mass: np.ndarray, factor: np.ndarray, inverse: np.ndarray) -> None:
    """L'DL of a free body's 21 numbers of M as mj_factorM makes it, which takes three times as long: D, and 1/D."""
    for i in range(21):
        factor[i] = mass[i]
    for k in range(5, -1, -1):
        row = k * (k + 1) // 2
        inverse[k] = 1.0 / factor[row + k]
        for i in range(k - 1, -1, -1):
            share, start = factor[row + i] * inverse[k], i * (i + 1) // 2
            for j in range(i + 1):
                factor[start + j] -= share * factor[row + j]
            factor[row + i] = share


@term
def wet_free_body(model: int, data: int, user: np.ndarray, sea: np.ndarray, body: int, fresh: bool) -> bool:
    """The water on a body whose only joint is a free one; whether M is still to be factored."""
    dof = whole(model + OFFSETS.body_dofadr, body + 1)[body]
    rotation = numbers(data + OFFSETS.xmat, 9 * body, (3, 3))
    velocity = numbers(data + OFFSETS.qvel, dof, 6)
    v, w = to_body(rotation, triple(velocity, 0)), triple(velocity, 3)
    turning = cross(v, w)  # a velocity constant in world axes turns in the body's
    force = water_force(
        user,
        sea,
        array_at(model + OFFSETS.gravity, 3),
        array_at(data + OFFSETS.time, 1)[0],
        numbers(data + OFFSETS.xpos, 3 * body, 3),
        rotation,
        (*v, *w),
        (*turning, 0.0, 0.0, 0.0),
    )
    fluid = numbers(data + OFFSETS.qfrc_fluid, dof, 6)
    x, y, z = to_world(rotation, (force[0], force[1], force[2]))
    fluid[0] += x
    fluid[1] += y
    fluid[2] += z
    fluid[3] += force[3]
    fluid[4] += force[4]
    fluid[5] += force[5]
    if not fresh or whole(model + OFFSETS.M_rownnz, dof + 6)[dof + 5] != 6:  # set_const refuses what has no room
        return False
    start, nv = whole(model + OFFSETS.M_rowadr, dof + 1)[dof], word_at(model + OFFSETS.nv)
    mass = numbers(data + OFFSETS.M, start, 21)
    wet_free_mass(mass, matrix(user, AT.added_mass), rotation)
    if dof + 6 < nv and whole(model + OFFSETS.dof_parentid, nv)[dof + 6] >= 0:
        return True  # joints hang on it
    factor_free(mass, numbers(data + OFFSETS.qLD, start, 21), numbers(data + OFFSETS.qLDiagInv, dof, 6))
    return False


@term
def wet_jointed_body(
    model: int, data: int, user: np.ndarray, sea: np.ndarray, body: int, last: int, fresh: bool
) -> None:
    """The water on a body that hangs on a chain of joints, whose last degree of freedom is `last`."""
    nv = word_at(model + OFFSETS.nv)
    parent, rows = whole(model + OFFSETS.dof_parentid, nv), whole(model + OFFSETS.M_rowadr, nv)
    rotation, position = numbers(data + OFFSETS.xmat, 9 * body, (3, 3)), numbers(data + OFFSETS.xpos, 3 * body, 3)
    root = whole(model + OFFSETS.body_rootid, body + 1)[body]
    centre = numbers(data + OFFSETS.subtree_com, 3 * root, 3)
    arm = (position[0] - centre[0], position[1] - centre[1], position[2] - centre[2])
    velocity = array_at(word_at(data + OFFSETS.qvel), nv)
    fluid = array_at(word_at(data + OFFSETS.qfrc_fluid), nv)
    depth, dof, rest = 0, last, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    while dof >= 0:
        a, b, c, d, e, f = six(numbers(data + OFFSETS.cdof_dot, 6 * dof, 6), 0)
        s = velocity[dof]
        rest = add(rest, (s * a, s * b, s * c, s * d, s * e, s * f))
        depth += 1
        dof = parent[dof]
    force = water_force(
        user,
        sea,
        array_at(model + OFFSETS.gravity, 3),
        array_at(data + OFFSETS.time, 1)[0],
        position,
        rotation,
        shifted(six(numbers(data + OFFSETS.cvel, 6 * body, 6), 0), rotation, arm),
        shifted(rest, rotation, arm),
    )
    columns = np.empty((depth, 6))
    dof = last
    for i in range(depth):
        column = shifted(six(numbers(data + OFFSETS.cdof, 6 * dof, 6), 0), rotation, arm)
        for k in range(6):
            columns[i, k] = column[k]
        fluid[dof] += dot(columns[i], force)
        dof = parent[dof]
    if fresh and whole(model + OFFSETS.M_rownnz, nv)[last] == depth:
        added = matrix(user, AT.added_mass)
        dof = last
        for i in range(depth):
            momentum = multiply(added, six(columns[i], 0))
            row = numbers(data + OFFSETS.M, rows[dof], depth - i)
            for j in range(i, depth):
                row[depth - 1 - j] += dot(columns[j], momentum)
            dof = parent[dof]


@functools.cache
def compiled() -> Any:
    """The callback, compiled at the first call (seconds) and cached on disk.

    The offsets are a free variable of the function, so that they are part of its key in numba's cache.
    """
    o = offsets.AT

    def mjcb_control(model, data):  # type: ignore[no-untyped-def]
        width = word_at(model + o.nuser_body)
        if width < SIZE:
            return
        bodies, users = word_at(model + o.nbody), word_at(model + o.body_user)
        parent, count = whole(model + o.body_parentid, bodies), whole(model + o.body_dofnum, bodies)
        first, joints = whole(model + o.body_dofadr, bodies), whole(model + o.body_jntnum, bodies)
        nv, any_wet, fresh, changed = word_at(model + o.nv), False, False, False
        passive, fluid = array_at(word_at(data + o.qfrc_passive), nv), array_at(word_at(data + o.qfrc_fluid), nv)
        sea = array_at(users, width)
        for body in range(1, bodies):
            user = array_at(users + NUMBER * width * body, width)
            if user[0] != MAGIC:
                continue
            if not any_wet:
                any_wet = True
                mark = numbers(data + o.crb, 0, 1)
                fresh = mark[0] != WET
                mark[0] = WET
                for i in range(nv):
                    passive[i] -= fluid[i]
                    fluid[i] = 0.0
            carrier = body
            while carrier > 0 and count[carrier] == 0:
                carrier = parent[carrier]
            if carrier == body and joints[body] == 1 and count[body] == 6:
                changed |= wet_free_body(model, data, user, sea, body, fresh)
            elif carrier > 0:
                changed |= fresh
                wet_jointed_body(model, data, user, sea, body, first[carrier] + count[carrier] - 1, fresh)
        if any_wet:
            for i in range(nv):
                passive[i] += fluid[i]
            if choice(model + o.solver) == PGS or choice(model + o.noslip_iterations) > 0:
                passive[0] = np.nan  # it was switched on after `add` and would use the dry mass: MuJoCo warns of this
        if changed:
            factor_mass(model, data)

    with cache_folder():
        return numba.cfunc(types.void(types.intp, types.intp), cache=True, error_model="numpy")(mjcb_control)


@functools.cache
def callback() -> Any:
    """The compiled callback as the C function pointer that mujoco.set_mjcb_control takes."""
    return ctypes.cast(compiled().address, ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p))
