"""Six-degree-of-freedom dynamics of a rigid body in water, in body axes.

Body axes: x forward, y starboard, z down. Velocity nu = (v, w): linear velocity v of the body's origin [m/s] and
angular velocity w [rad/s]. A wrench is (force [N], moment about the origin [N m]). Vectors are tuples of 3, velocities
and wrenches tuples of 6 floats; 6x6 matrices are arrays over (v, w) [kg, kg m, kg m2]; `rotation`, shape (3, 3), takes
body axes to world axes.

    (M_RB + M_A) dnu/dt = forces - M_RB [w x v; 0] - C_A(nu_r) nu_r + M_A [dU/dt; 0]

nu_r = nu - [U; 0] is the velocity through the water, which moves uniformly at U and may accelerate; dU/dt is taken in
the turning body axes. `forces` holds all the rest: weight and the centrifugal forces of the body's own mass, buoyancy,
drag, thrust, and in accelerating water its pressure gradient. MuJoCo solves it (water/control.py); the terms are here.

Sources: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), chapters 3, 6, 7;
Kirchhoff's equations in Lamb, Hydrodynamics (1932), articles 121-126.
"""

from __future__ import annotations

import numpy as np

from ..compiled import term

Vector = tuple[float, float, float]
Wrench = tuple[float, float, float, float, float, float]


@term
def cross(a: Vector, b: Vector) -> Vector:
    """a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@term
def to_world(rotation: np.ndarray, v: Vector) -> Vector:
    """The vector v, given in body axes, in world axes."""
    return (
        rotation[0, 0] * v[0] + rotation[0, 1] * v[1] + rotation[0, 2] * v[2],
        rotation[1, 0] * v[0] + rotation[1, 1] * v[1] + rotation[1, 2] * v[2],
        rotation[2, 0] * v[0] + rotation[2, 1] * v[1] + rotation[2, 2] * v[2],
    )


@term
def to_body(rotation: np.ndarray, v: Vector) -> Vector:
    """The vector v, given in world axes, in body axes."""
    return to_world(rotation.T, v)


@term
def row(matrix: np.ndarray, i: int, x: Wrench) -> float:
    """Row i of a (6, 6) matrix times x."""
    first = matrix[i, 0] * x[0] + matrix[i, 1] * x[1] + matrix[i, 2] * x[2]
    return first + matrix[i, 3] * x[3] + matrix[i, 4] * x[4] + matrix[i, 5] * x[5]


@term
def multiply(matrix: np.ndarray, x: Wrench) -> Wrench:
    """A (6, 6) matrix times x."""
    x_y_z = row(matrix, 0, x), row(matrix, 1, x), row(matrix, 2, x)
    return *x_y_z, row(matrix, 3, x), row(matrix, 4, x), row(matrix, 5, x)


@term
def add(a: Wrench, b: Wrench) -> Wrench:
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]


@term
def subtract(a: Wrench, b: Wrench) -> Wrench:
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3], a[4] - b[4], a[5] - b[5]


@term
def at(force: Vector, position: Vector) -> Wrench:
    """Wrench of a force [N] that acts at a position [m]."""
    moment = cross(position, force)
    return force[0], force[1], force[2], moment[0], moment[1], moment[2]


@term
def coriolis(mass: np.ndarray, nu: Wrench) -> Wrench:
    """C(nu) nu for any symmetric mass matrix, from the momentum (p, h) = M nu: [w x p; w x h + v x p] (Kirchhoff)."""
    momentum = multiply(mass, nu)
    v, w = (nu[0], nu[1], nu[2]), (nu[3], nu[4], nu[5])
    p, h = (momentum[0], momentum[1], momentum[2]), (momentum[3], momentum[4], momentum[5])
    wp, wh, vp = cross(w, p), cross(w, h), cross(v, p)
    return wp[0], wp[1], wp[2], wh[0] + vp[0], wh[1] + vp[1], wh[2] + vp[2]


@term
def resistance(linear: float, quadratic: float, speed: float) -> float:
    """Drag of one axis [N or N m] at a linear or angular speed through the water."""
    return -(linear + quadratic * abs(speed)) * speed


@term
def drag(linear: np.ndarray, quadratic: np.ndarray, nu: Wrench) -> Wrench:
    """Drag, axis by axis; linear (6,) [N/(m/s), N m/(rad/s)], quadratic (6,) [N/(m/s)2, N m/(rad/s)2]."""
    return (
        resistance(linear[0], quadratic[0], nu[0]),
        resistance(linear[1], quadratic[1], nu[1]),
        resistance(linear[2], quadratic[2], nu[2]),
        resistance(linear[3], quadratic[3], nu[3]),
        resistance(linear[4], quadratic[4], nu[4]),
        resistance(linear[5], quadratic[5], nu[5]),
    )


@term
def added_mass_forces(added: np.ndarray, nu: Wrench, flow: Vector, water: Vector, turning: Wrench) -> Wrench:
    """-C_A(nu_r) nu_r + M_A ([dU/dt; 0] - turning): added mass but for its part in the mass matrix.

    `flow` is the water's velocity U [m/s], `water` its acceleration in world terms [m/s2], both given in body axes;
    in the turning axes U changes at the rate water - w x U. `turning` is the part of dnu/dt that the mass matrix does
    not multiply: what is left of it while all generalized velocities stay as they are.
    """
    carried = cross((nu[3], nu[4], nu[5]), flow)
    nu_r = (nu[0] - flow[0], nu[1] - flow[1], nu[2] - flow[2], nu[3], nu[4], nu[5])
    rate = (water[0] - carried[0], water[1] - carried[1], water[2] - carried[2], 0.0, 0.0, 0.0)
    return subtract(multiply(added, subtract(rate, turning)), coriolis(added, nu_r))
