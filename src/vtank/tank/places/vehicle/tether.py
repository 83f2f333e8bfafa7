"""A cable pulls at a place of the hull, and back to where the run began."""

from __future__ import annotations

import numpy as np

from ..effect import VEHICLE, Array, Moving, Number, PlacedEffect, Values
from .offset import EARTH, xyz


def pulled(s: Moving, place: str, p: Values) -> Array:
    """A tension, and a spring about where the run began, in earth axes, at a place of the body."""
    at = np.array([p["x"], p["y"], p["z"]])
    tension = s.earth.T @ [p[axis] for axis in EARTH]  # away[:3] is in body axes already
    start = s.earth.T @ at  # the place of attachment at the start, heading north and level
    force = tension - p["k"] * (s.away[:3] + at - start)
    return np.concatenate([force, np.cross(at, force)])


EFFECT = PlacedEffect(
    "tether",
    VEHICLE,
    "F = R' (north, east, down) - k (displacement of the place)",
    (
        *(
            Number(axis, ("_N",), f"tension {axis}", 0.0, usual=lambda s: s.force, slot=f"pull_{axis}")
            for axis in EARTH
        ),
        Number("k", ("_N_per_m",), "stiffness", 0.0, 0.0, usual=lambda s: 0.3 * s.force, slot="tether"),
        *xyz("held_at"),
    ),
    wrench=pulled,
    order=8,
)
