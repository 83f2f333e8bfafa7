"""What stands where in mjModel.actuator_user of the two actuators that carry the surge equation.

PROPULSION has its two states and makes the thrust; HULL, next to it, makes all the rest of the equation. The numbers
stand in the row of the first, and may differ between the simulations of a batch. All are SI, in body axes.
"""

from __future__ import annotations

import math

import numpy as np

from ..plant import parameters
from ..water.record import starts

PROPULSION, HULL = "vtank/propulsion", "vtank/hull"  # names of the actuators
PROPELLED, DRAGGED = (
    6.283185e-139,
    6.283185e-140,
)  # first number of their rows; any values nobody else would write there

FIELDS: dict[str, tuple[int, ...]] = {
    "magic": (),
    "body": (),  # the vehicle
    "moving_mass_kg": (),
    "disturbance_m_s2": (),  # surge acceleration by turbulence
    "sonar_m": (3,),
    "wall_m": (),  # world x of the wall ahead
    "parameters": (parameters.SIZE,),  # the surge equation's vector p
}
AT = starts(FIELDS)
SIZE: int = AT.end


def field(rows: np.ndarray, name: str) -> np.ndarray:
    """Writable view of a field: rows (..., nuser_actuator) -> shape (..., *FIELDS[name])."""
    start, shape = getattr(AT, name), FIELDS[name]
    return rows[..., start : start + math.prod(shape)].reshape((*rows.shape[:-1], *shape))
