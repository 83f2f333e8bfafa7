"""The hull drags water along and meets it again on the way back."""

from __future__ import annotations

import math

from ....plant.vehicle import AXES
from ..effect import Array, Moving, Number, PlacedEffect, Values
from .resistance import carried


def wake(s: Moving, axis: str, p: Values) -> Array:
    """Drag acts on the speed less that of the wake."""
    return carried(s, axis, s.memory.get(f"wake_memory@{axis}", 0.0))


def wake_later(s: Moving, axis: str, p: Values) -> float:
    """The wake one step on: T dw/dt = k u - w."""
    before = s.memory.get(f"wake_memory@{axis}", 0.0)
    return before - math.expm1(-s.step_s / p["T"]) * (p["k"] * float(s.nu[AXES.index(axis)]) - before)


EFFECT = PlacedEffect(
    "wake_memory",
    "axis",
    "drag at u_r - w, T dw/dt = k u - w",
    (
        Number(
            "k", ("",), "share of the speed that the wake takes up", low=0.0, high=0.9, usual=lambda _: 0.3, slot="wake"
        ),
        Number("T", ("_s",), "time that it takes", 5.0, 0.05, 600.0, usual=lambda _: 5.0, shape=True, slot="recovery"),
    ),
    wrench=wake,
    keep=wake_later,
    order=6,
)
