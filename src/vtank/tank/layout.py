"""What stands where in mjModel.actuator_user of the actuators that carry the surge equation.

SURGE has its two states and makes its force, at the body's origin. TRIM, where the propellers are off the axis, makes
the thrust's pitching moment. Fins of a whole vehicle (fins.py) have rows of their own. The numbers may differ between
the simulations of a batch. All are SI, in body axes.
"""

from __future__ import annotations

import math

import numpy as np

from ..plant import parameters
from ..water.record import starts

SURGE, TRIM = "vtank/surge", "vtank/trim"  # names of the actuators
SURGING, TRIMMING, FINNING = 0.0628321, 0.0628322, 0.0628323  # first number of their rows: nobody else writes that

FIELDS: dict[str, tuple[int, ...]] = {
    "magic": (),
    "body": (),  # the vehicle
    "moving_mass_kg": (),
    "disturbance_m_s2": (),  # surge acceleration by turbulence
    "sonar_m": (3,),
    "wall_m": (),  # world x of the wall ahead
    "parameters": (parameters.SIZE,),  # the surge equation's vector p
}
FINS: dict[str, tuple[int, ...]] = {  # of an actuator that makes a fin's force along one direction
    "magic": (),
    "body": (),
    "place_m": (3,),
    "axis": (3,),
    "along": (3,),
    "pressure_area": (),  # half the density times the area [kg/m]
    "lift_per_rad": (),
    "stall_rad": (),
    "drag": (),
    "suction": (),
}
AT, FIN_AT = starts(FIELDS), starts(FINS)
SIZE: int = AT.end


def field(rows: np.ndarray, name: str, fields: dict[str, tuple[int, ...]] = FIELDS) -> np.ndarray:
    """Writable view of a field: rows (..., nuser_actuator) -> shape (..., *fields[name])."""
    start, shape = getattr(AT if fields is FIELDS else FIN_AT, name), fields[name]
    return rows[..., start : start + math.prod(shape)].reshape((*rows.shape[:-1], *shape))
