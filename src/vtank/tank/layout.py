"""What stands where in a simulation's userdata: the inputs and constants that the compiled callback works with.

MuJoCo carries mjData.userdata with each simulation and leaves it alone, so that many simulations with different
parameters run at once without globals. All numbers are SI, in body axes unless said otherwise.
"""

from __future__ import annotations

import math
from collections import namedtuple
from itertools import accumulate
from typing import Any

import numpy as np

from ..plant import parameters

MAGIC = 6.283185e-137  # first number of a simulation that is ours; any value nobody else would write there will do
MAX_THRUSTERS = 8

# Field -> shape
FIELDS: dict[str, tuple[int, ...]] = {
    "magic": (),
    # inputs
    "propeller_rev_s": (),  # speed of both stern propellers, held between ticks
    "disturbance_m_s2": (),  # surge acceleration by turbulence
    "thruster_N": (MAX_THRUSTERS,),  # force of each other thruster
    "water_m_s": (3,),  # velocity of the water at the time water_since_s, world axes
    "water_m_s2": (3,),  # its acceleration, world axes
    "water_since_s": (),
    # where the vehicle stands in the model
    "dof": (),  # first degree of freedom of its free joint
    "body": (),
    "lag": (),  # address of its states, lagged thrust and wake, in mjData.act
    "lag_input": (),  # index of their actuators in mjData.ctrl
    # the vehicle
    "rigid_mass": (6, 6),  # of the compiled model
    "added_mass": (6, 6),
    "share": (6, 6),  # of a force that reaches the rigid body: M_RB (M_RB + M_A)^-1
    "drag_linear": (6,),
    "drag_quadratic": (6,),
    "buoyancy_N": (),
    "displaced_kg": (),
    "centre_of_buoyancy_m": (3,),
    "centre_of_gravity_m": (3,),
    "thruster_wrench": (MAX_THRUSTERS, 6),  # of each thruster at 1 N
    "propeller_z_m": (),  # mean height of the propellers' axes
    "sonar_m": (3,),
    "wall_m": (),  # world x of the wall ahead
    # the surge equation's vector p
    "parameters": (parameters.SIZE,),
}


Starts: Any = namedtuple  # mypy wants names that are written out
AT = Starts("AT", [*FIELDS, "end"])(*accumulate(map(math.prod, FIELDS.values()), initial=0))  # first numbers by name
SIZE: int = AT.end


def field(userdata: np.ndarray, name: str) -> np.ndarray:
    """Writable view of a field: userdata of shape (..., nuserdata) -> shape (..., *FIELDS[name])."""
    start, shape = getattr(AT, name), FIELDS[name]
    return userdata[..., start : start + math.prod(shape)].reshape((*userdata.shape[:-1], *shape))
