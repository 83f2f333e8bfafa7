"""Another mass turns with the hull than the vehicle file has."""

from __future__ import annotations

from ....plant.vehicle import AXES
from ..effect import Array, Moving, Number, PlacedEffect, Values, along


def coupling(s: Moving, axis: str, p: Values) -> Array:
    """The force of another turning mass: -c u r in sway, c u q in heave, c v r in surge."""
    u, v, q, r = s.through[0], s.through[1], s.nu[4], s.nu[5]
    return along(axis, p["c"] * {"surge": v * r, "sway": -u * r, "heave": u * q}[axis])


EFFECT = PlacedEffect(
    "coriolis",
    "axis",
    "X += c v_r r, Y -= c u_r r, Z += c u_r q",
    (Number("c", ("_kg",), "mass that turns besides", usual=lambda s: 0.3 * s.mass, slot="coupling"),),
    places=AXES[:3],
    wrench=coupling,
    order=9,
)
