"""Offsets and forces by their three components."""

from __future__ import annotations

from ..effect import Number

EARTH = ("north", "east", "down")


def xyz(slot: str = "") -> tuple[Number, ...]:
    """A place; slot: of its components, before the axis."""

    def one(axis: str) -> Number:
        slots, words = f"{slot}_{axis}" if slot else "", f"along the body's {axis}"
        return Number(axis, ("_m",), words, 0.0, -10.0, 10.0, usual=lambda s: 0.05 * s.hull, slot=slots)

    return one("x"), one("y"), one("z")
