"""A weight has been added and forgotten."""

from __future__ import annotations

import mujoco
import numpy as np

from ..effect import VEHICLE, Number, PlacedEffect, Values
from .offset import xyz
from .rigid import free

LEAD_KG_M3 = 11340.0


def weighted(spec: mujoco.MjSpec, p: Values) -> None:
    """A sphere of lead, which displaces nothing, fixed to the body."""
    radius = np.cbrt(p["m"] / LEAD_KG_M3 * 0.75 / np.pi)
    free(spec).add_body(
        name="vtank/trim weight", pos=(p["x"], p["y"], p["z"]), ipos=np.zeros(3), explicitinertial=True,
        mass=p["m"], inertia=np.full(3, 0.4 * p["m"] * radius**2),
    )  # fmt: skip


EFFECT = PlacedEffect(
    "trim_weight",
    VEHICLE,
    "m, at (x, y, z)",
    (
        Number("m", ("_kg",), "mass of lead", low=1e-3, high=1e5, usual=lambda s: 0.0005 * s.weight, slot="trim"),
        *xyz("trim"),
    ),
    rigid=weighted,
    order=4,
)
