"""Effects at places of a whole vehicle: along an axis, on a thruster, a fin or a sensor, or of the vehicle itself.

A scenario switches them on by name and place, each number with its unit in its key:

    [effects]
    "linear_drag@yaw" = { c_N_m_s_per_rad = 2.0 }
    "thrust_deadband@bow_port" = { n0_rev_s = 3.0 }
    "current@vehicle" = { north_m_s = 0.2, east_m_s = 0.1 }

One file for each, in the folder of its kind of place: axis, thruster, fin, sensor, vehicle; to be there is to be in the
catalogue. `catalogue.table()` is the table of all of them; read.py reads them from a scenario. Nothing here is used by
a diagnosis, which has to find them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...facade import facade

if TYPE_CHECKING:
    from .catalogue import CATALOGUE
    from .effect import Moving, Number, Placed, PlacedEffect, along
    from .read import key_of, partners, places, read_placed
    from .usual import Usual

__all__ = facade(__name__)
