"""What stands where in mjModel.body_user: a row for every wet body, and the sea's in the row of the world.

There the numbers survive mj_resetData, travel with MjSpec, and may differ between the simulations of a batch
(`batch.expand("body_user")`). All are SI; vectors in axes of the body unless said otherwise.
"""

from __future__ import annotations

import math
from collections import namedtuple
from itertools import accumulate
from typing import Any

import numpy as np

MAGIC = 0.0628318  # first number of a wet body's row: nobody else would write it there, and XML keeps it
SEA = 0.0628319  # first number of the world's row where there are waves
COMPONENT = 7  # numbers of a wave: its way along x and y, wave number [1/m], frequency [rad/s], its velocity in water
# without bed, w a/(1 - exp(-2 k h)), real and imaginary [m/s], and exp(-2 k h), what the bed throws back

FIELDS: dict[str, tuple[int, ...]] = {
    "magic": (),
    "added_mass": (6, 6),
    "drag_linear": (6,),
    "drag_quadratic": (6,),
    "centre_of_drag_m": (3,),
    "drag_axes": (3, 3),  # takes axes of drag to the body's
    "drag_is_moved": (),  # whether these two matter
    "cross_flow": (4,),  # hindmost and foremost x [m], drag per length in sway and in heave [N/(m/s)2/m]
    "displaced_kg": (),
    "centre_of_buoyancy_m": (3,),
    "water_m_s": (3,),  # velocity of the water at the time water_since_s, world axes; waves come on top
    "water_m_s2": (3,),  # its acceleration, world axes
    "water_since_s": (),
}
WAVES: dict[str, tuple[int, ...]] = {
    "magic": (),
    "components": (),
    "surface_m": (),  # z of the still water
}

Starts: Any = namedtuple  # mypy wants names that are written out


def starts(fields: dict[str, tuple[int, ...]]) -> Any:
    """Index of the first number of each field, by name; and `end`."""
    return Starts("AT", [*fields, "end"])(*accumulate(map(math.prod, fields.values()), initial=0))


AT, WAVE_AT = starts(FIELDS), starts(WAVES)
SIZE: int = AT.end


def field(rows: np.ndarray, name: str) -> np.ndarray:
    """Writable view of a field of wet bodies: rows (..., nuser_body) -> shape (..., *FIELDS[name])."""
    start, shape = getattr(AT, name), FIELDS[name]
    return rows[..., start : start + math.prod(shape)].reshape((*rows.shape[:-1], *shape))
