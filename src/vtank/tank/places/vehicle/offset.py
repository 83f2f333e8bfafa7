"""Offsets and forces by their three components."""

from __future__ import annotations

from ..effect import Number

XYZ = tuple(
    Number(axis, ("_m",), f"along the body's {axis}", 0.0, -10.0, 10.0, usual=lambda s: 0.05 * s.hull) for axis in "xyz"
)
EARTH = ("north", "east", "down")
