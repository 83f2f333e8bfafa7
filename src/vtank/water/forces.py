"""The water's force on one body, in the body's axes: added mass, drag, cross-flow, buoyancy, current and waves.

    F = M_A (R'dU/dt - w x U - b) - C_A(nu_r) nu_r - D(nu_r) nu_r + m_w (dU/dt - g) at the centre of buoyancy

nu = (v, w) is the velocity of the body's origin, U the water's there, nu_r = nu - [U; 0], R the rotation to world axes,
b what d nu/dt is while all joints keep their speed, m_w the displaced mass. The remaining term, -M_A J dq''/dt, is in
MuJoCo's mass matrix (control.py). In waves dU/dt is the local acceleration: linear theory, the body short against them.

Sources: Kirchhoff's equations in Lamb, Hydrodynamics (1932), articles 121-126; Fossen (2021), sections 8.1 and 10.3;
force of accelerating water on displaced and added mass: Newman, Marine Hydrodynamics (1977), section 4.16; cross-flow
strips: Healey and Lienard, IEEE J. Oceanic Eng. 18 (1993); waves: Dean and Dalrymple (1991), chapters 3 and 4.
"""

from __future__ import annotations

import math

import numpy as np

from ..compiled import term
from ..plant.sixdof import Vector, Wrench, add, added_mass_forces, at, cross, drag, subtract, to_body, to_world
from .pointers import block, matrix, six, triple
from .record import AT, COMPONENT, SEA, WAVE_AT

NODES, WEIGHTS = (tuple(map(float, half)) for half in np.polynomial.legendre.leggauss(8))  # exact where no strip stalls


@term
def plus(a: Vector, b: Vector) -> Vector:
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@term
def waves(sea: np.ndarray, time: float, place: Vector) -> tuple[Vector, Vector]:
    """Velocity and acceleration of the water by the waves alone at a place below the still surface, world axes."""
    x, y, z = 0.0, 0.0, 0.0
    dx, dy, dz = 0.0, 0.0, 0.0
    height = min(place[2] - sea[WAVE_AT.surface_m], 0.0)
    for i in range(int(sea[WAVE_AT.components])):
        start = WAVE_AT.end + COMPONENT * i
        ex, ey, k, w, re, im = six(sea, start)
        phase = k * (ex * place[0] + ey * place[1]) - w * time
        c, s = math.cos(phase), math.sin(phase)
        even, odd = re * c - im * s, re * s + im * c
        above = math.exp(k * height)
        below = sea[start + 6] / above if sea[start + 6] > 0.0 else 0.0
        along, up = (above + below) * even, (above - below) * odd
        x, y, z = x + along * ex, y + along * ey, z + up
        along, up = w * (above + below) * odd, w * (above - below) * even
        dx, dy, dz = dx + along * ex, dy + along * ey, dz - up
    return (x, y, z), (dx, dy, dz)


@term
def flow(
    user: np.ndarray, sea: np.ndarray, time: float, position: np.ndarray, rotation: np.ndarray
) -> tuple[Vector, Vector]:
    """Velocity [m/s] and acceleration [m/s2] of the water at a body, world axes; arguments as of `water_force`."""
    since = time - user[AT.water_since_s]
    u, a = triple(user, AT.water_m_s), triple(user, AT.water_m_s2)
    u = (u[0] + a[0] * since, u[1] + a[1] * since, u[2] + a[2] * since)
    if sea[0] == SEA:
        place = plus(triple(position, 0), to_world(rotation, triple(user, AT.centre_of_buoyancy_m)))
        orbital, turning = waves(sea, time, place)
        u, a = plus(u, orbital), plus(a, turning)
    return u, a


@term
def cross_flow(user: np.ndarray, nu: Wrench) -> Wrench:
    """Drag of the flow across the hull, strip by strip from tail to nose, each along the flow that it meets."""
    tail, nose, sway, heave = (
        user[AT.cross_flow],
        user[AT.cross_flow + 1],
        user[AT.cross_flow + 2],
        user[AT.cross_flow + 3],
    )
    y, z, m, n = 0.0, 0.0, 0.0, 0.0
    for i in range(len(NODES)):
        x = 0.5 * (tail + nose + (nose - tail) * NODES[i])
        v, w = nu[1] + x * nu[5], nu[2] - x * nu[4]
        speed = 0.5 * (nose - tail) * WEIGHTS[i] * math.sqrt(v * v + w * w)
        across, down = -sway * speed * v, -heave * speed * w
        y, z, m, n = y + across, z + down, m - x * down, n + x * across
    return 0.0, y, z, 0.0, m, n


@term
def all_drag(user: np.ndarray, nu: Wrench) -> Wrench:
    """Drag axis by axis, and across the hull, at the origin and in the axes of drag."""
    force = drag(user[AT.drag_linear :], user[AT.drag_quadratic :], nu)
    return add(force, cross_flow(user, nu)) if user[AT.cross_flow] != user[AT.cross_flow + 1] else force


@term
def moved_drag(user: np.ndarray, nu: Wrench) -> Wrench:
    """The same where drag has a centre and axes of its own."""
    centre, axes = triple(user, AT.centre_of_drag_m), block(user, AT.drag_axes)
    w = (nu[3], nu[4], nu[5])
    there = plus((nu[0], nu[1], nu[2]), cross(w, centre))
    x, y, z, k, m, n = all_drag(user, (*to_body(axes, there), *to_body(axes, w)))
    return add(at(to_world(axes, (x, y, z)), centre), (0.0, 0.0, 0.0, *to_world(axes, (k, m, n))))


@term
def water_force(
    user: np.ndarray,
    sea: np.ndarray,
    gravity: np.ndarray,
    time: float,
    position: np.ndarray,
    rotation: np.ndarray,
    nu: Wrench,
    turning: Wrench,
) -> Wrench:
    """The force F above.

    user, sea: rows of mjModel.body_user; gravity: shape (3,) [m/s2]; position, rotation: of the body's origin and axes
    in the world; nu: velocity in body axes; turning: b above.
    """
    centre = triple(user, AT.centre_of_buoyancy_m)
    u, a = flow(user, sea, time, position, rotation)
    stream, rate = to_body(rotation, u), to_body(rotation, a)
    nu_r = subtract(nu, (*stream, 0.0, 0.0, 0.0))
    force = added_mass_forces(matrix(user, AT.added_mass), nu, stream, rate, turning)
    mass = user[AT.displaced_kg]
    lift = to_body(rotation, (a[0] - gravity[0], a[1] - gravity[1], a[2] - gravity[2]))
    force = add(force, at((mass * lift[0], mass * lift[1], mass * lift[2]), centre))
    return add(force, moved_drag(user, nu_r) if user[AT.drag_is_moved] != 0.0 else all_drag(user, nu_r))
