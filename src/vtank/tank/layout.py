"""What stands where in mjModel.actuator_user of the actuators that carry the surge equation.

SURGE has its two states and makes its force, at the body's origin. TRIM, where the propellers are off the axis, makes
the thrust's pitching moment. The numbers may differ between the simulations of a batch. All are SI, in body axes.
"""

from __future__ import annotations

import math

import numpy as np

from ..plant import parameters
from ..water.record import starts

SURGE, TRIM = "vtank/surge", "vtank/trim"  # names of the actuators
SURGING, TRIMMING = 0.0628321, 0.0628322  # first number of their rows, which nobody else would write there

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
