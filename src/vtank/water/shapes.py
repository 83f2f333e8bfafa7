"""Hydrodynamics of simple shapes: what to begin with where nothing has been measured."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from scipy.special import elliprd

from .body import Body
from .specification import compiled

WATER_KG_M3 = 1000.0  # fresh water; a choice
ROBOT_KG_M3 = 1500.0  # mean density of metal, plastic and the air between; a guess: such robots sink
BLUFF = 1.0  # drag coefficient of a blunt body on its area across the flow; a guess


def ellipsoid(
    semi_axes_m: tuple[float, float, float], density_kg_m3: float = WATER_KG_M3, drag_coefficient: float = BLUFF
) -> Body:
    """A body shaped as an ellipsoid about its origin, its axes along the body's.

    Added mass is exact in ideal fluid (Lamb, Hydrodynamics (1932), articles 114 and 115; Newman (1977), section 4.14).
    Drag is that of the area across the flow, and about an axis that of strips; its coefficient is a guess.
    """
    square = np.square(semi_axes_m)
    volume = math.prod(semi_axes_m)
    mass = 4.0 / 3.0 * math.pi * density_kg_m3 * volume
    added, drag = np.zeros((6, 6)), np.zeros(6)
    # alpha_0, beta_0, gamma_0 of Lamb: abc times the integral of 1/((a2 + s) sqrt((a2 + s)(b2 + s)(c2 + s)))
    lamb = [2.0 / 3.0 * volume * elliprd(square[i - 2], square[i - 1], square[i]) for i in range(3)]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        added[i, i] = mass * lamb[i] / (2.0 - lamb[i])
        less, more, turn = square[j] - square[k], square[j] + square[k], lamb[k] - lamb[j]
        if less != 0.0:
            added[3 + i, 3 + i] = mass / 5.0 * less**2 * turn / (2.0 * less - more * turn)
        across = semi_axes_m[j], semi_axes_m[k]
        drag[i] = 0.5 * density_kg_m3 * drag_coefficient * math.pi * across[0] * across[1]
        strips = semi_axes_m[i] * (across[0] ** 4 + across[1] ** 4)  # 4/15: of sqrt(1 - s2) s3, twice both ways
        drag[3 + i] = 4.0 / 15.0 * density_kg_m3 * drag_coefficient * strips
    return Body(added, mass, drag_quadratic=drag)


def ellipsoids(
    spec: mujoco.MjSpec, body_kg_m3: float = ROBOT_KG_M3, density_kg_m3: float = WATER_KG_M3
) -> dict[str, Body]:
    """Every body of a model that moves, has mass and a name, as an ellipsoid: a first guess from mass and inertia.

    Its proportions and axes are those of the uniform ellipsoid with the body's inertia, its volume is the body's mass
    over body_kg_m3; density_kg_m3 is the water's. InputError where the specification cannot be compiled.
    """
    bodies, model = {}, compiled(spec.copy())
    for i in np.flatnonzero((model.body_mass > 0.0) & (model.body_weldid > 0)).tolist():
        inertia, mass = model.body_inertia[i], model.body_mass[i]
        square = 2.5 / mass * (inertia.sum() - 2.0 * inertia)
        axes_m = np.sqrt(np.maximum(square, 1e-4 * square.max()))  # a plate or rod without thickness gets some
        a, b, c = axes_m * np.cbrt(mass / body_kg_m3 / (4.0 / 3.0 * math.pi * axes_m.prod()))
        axes = np.zeros(9)
        mujoco.mju_quat2Mat(axes, model.body_iquat[i])
        whole = ellipsoid((float(a), float(b), float(c)), density_kg_m3)
        bodies[model.body(i).name] = whole.moved(model.body_ipos[i], axes.reshape(3, 3))
    return {name: body for name, body in bodies.items() if name}
