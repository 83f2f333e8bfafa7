"""Near the wall ahead the water has to squeeze past the bow, so that added mass and drag grow."""

from __future__ import annotations

from ....effects.wall_proximity import NEAREST_M, growth
from ..effect import Array, Moving, Number, PlacedEffect, Values, along


def more_mass(s: Moving, p: Values) -> float:
    """Added mass in surge besides [kg]."""
    return float(p["mass"] * growth(s.gap_m) * (s.vehicle.mass_kg + s.vehicle.added_mass[0, 0]))


def squeezed(s: Moving, axis: str, p: Values) -> Array:
    """More drag, and the slope of the mass along the way, by Lagrange's equation."""
    u, u_r = float(s.nu[0]), float(s.through[0])
    drag = p["drag"] * growth(s.gap_m) * s.vehicle.quadratic_drag[0] * abs(u_r) * u_r
    return along(axis, -drag - 1.5 * more_mass(s, p) / max(s.gap_m, NEAREST_M) * u * u)


EFFECT = PlacedEffect(
    "wall_proximity",
    "axis",
    "m_A += mass g (m + m_A), F -= drag g D u_r|u_r| + 1.5 mass g/gap (m + m_A) u^2, g = (3 m/gap)^3",
    (
        Number("drag", ("",), "growth of drag at 3 m", 0.0, 0.0, 3.0, usual=lambda _: 0.3, slot="wall_drag"),
        Number("mass", ("",), "growth of moving mass at 3 m", 0.0, 0.0, 1.0, usual=lambda _: 0.1, slot="wall_mass"),
    ),
    places=("surge",),
    wrench=squeezed,
    heavier=more_mass,
    order=11,
)
