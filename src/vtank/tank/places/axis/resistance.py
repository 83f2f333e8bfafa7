"""Drag of a vehicle along one axis, and what it is more where the water moves."""

from __future__ import annotations

from ....plant.vehicle import AXES
from ..effect import Array, Moving, along


def resistance(s: Moving, axis: str, u: float) -> float:
    """Drag of the vehicle along an axis at a speed through the water."""
    i = AXES.index(axis)
    return float(-(s.vehicle.linear_drag[i] + s.vehicle.quadratic_drag[i] * abs(u)) * u)


def carried(s: Moving, axis: str, U: float) -> Array:
    """What drag is more where the water moves along the axis at U besides."""
    u = float(s.through[AXES.index(axis)])
    return along(axis, resistance(s, axis, u - U) - resistance(s, axis, u))
