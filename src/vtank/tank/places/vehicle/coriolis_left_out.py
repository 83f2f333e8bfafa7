"""Coriolis and Munk terms of the added mass are left out, or part of them."""

from __future__ import annotations

import numpy as np

from .. import laws
from ..effect import VEHICLE, Array, Moving, Number, PlacedEffect, Values


def left_out(s: Moving, place: str, p: Values) -> Array:
    """Takes away a share of the added mass' Coriolis and centripetal forces, the Munk moment among them."""
    return p["share"] * np.array(laws.turning(s.vehicle.added_mass, tuple(s.through)))


EFFECT = PlacedEffect(
    "coriolis_left_out",
    VEHICLE,
    "C_A -> (1 - share) C_A",
    (Number("share", ("",), "of them that is left out", 1.0, 0.0, 1.0, usual=lambda _: 0.8, slot="left_out"),),
    wrench=left_out,
    order=5,
)
