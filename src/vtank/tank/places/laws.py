"""Laws of the water that MuJoCo's callback has, to be called from Python too."""

from __future__ import annotations

import numpy as np

from ...compiled import law
from ...plant.sixdof import Vector, Wrench, coriolis
from ...water.forces import cross_flow, flow


@law
def water_velocity(
    user: np.ndarray, sea: np.ndarray, time: float, position: np.ndarray, rotation: np.ndarray
) -> Vector:
    """Velocity of the water at a body, world axes [m/s]."""
    return flow(user, sea, time, position, rotation)[0]


@law
def strips(user: np.ndarray, nu: Wrench) -> Wrench:
    """Drag of the flow across the hull."""
    return cross_flow(user, nu)


@law
def turning(added: np.ndarray, nu: Wrench) -> Wrench:
    """C_A(nu) nu."""
    return coriolis(added, nu)
