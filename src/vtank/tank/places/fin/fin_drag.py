"""A fin drags more than its file says once it is turned, as one of a low aspect ratio or with a gap does."""

from __future__ import annotations

import math

import numpy as np

from ..effect import Array, Moving, Number, PlacedEffect, Values, part


def dragging(s: Moving, name: str, p: Values) -> Array:
    """Against the flow along the hull, with the square of the sine of the angle."""
    at = np.array(s.vehicle.sites[part(s.vehicle, "fins", name).site])
    ahead = float((s.through[:3] + np.cross(s.nu[3:], at))[0])
    force = np.array([-p["k"] * (ahead * math.sin(s.asked.get(name, 0.0))) ** 2, 0.0, 0.0])
    return np.concatenate([force, np.cross(at, force)])


EFFECT = PlacedEffect(
    "fin_drag",
    "fin",
    "X -= k u_r^2 sin^2(angle)",
    (
        Number(
            "k",
            ("_N_s2_per_m2",),
            "drag per square of the speed",
            low=0.0,
            usual=lambda s: s.force / s.u**2,
            slot="induced_drag",
        ),
    ),
    wrench=dragging,
    order=4,
)
