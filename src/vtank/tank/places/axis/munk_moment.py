"""The moment of a slender hull in oblique flow is another than its added masses say."""

from __future__ import annotations

from ..effect import Array, Moving, Number, PlacedEffect, Values, along


def munk(s: Moving, axis: str, p: Values) -> Array:
    """A moment c u w about pitch, -c u v about yaw."""
    u, v, w = s.through[:3]
    return along(axis, p["c"] * u * (w if axis == "pitch" else -v))


EFFECT = PlacedEffect(
    "munk_moment",
    "axis",
    "M += c u_r w_r about pitch, N -= c u_r v_r about yaw",
    (Number("c", ("_kg",), "difference of added masses", usual=lambda s: 0.3 * s.mass, slot="coupling"),),
    places=("pitch", "yaw"),
    wrench=munk,
    order=8,
)
