"""A standing wave carries the hull to and fro with the water."""

from __future__ import annotations

import math

from ....plant.vehicle import AXES, Vehicle
from ..effect import Array, Moving, Number, PlacedEffect, Values, along
from .resistance import carried


def seiche(s: Moving, axis: str, p: Values) -> Array:
    """Water that swings to and fro: drag at the speed through it, and the force of its acceleration."""
    i, angle = AXES.index(axis), p["frequency"] * s.time_s + p["phase"]
    mass = s.vehicle.mass_kg + s.vehicle.added_mass[i, i]  # displaced mass, as of what floats in balance
    rate = p["amplitude"] * p["frequency"] * math.cos(angle)
    return carried(s, axis, p["amplitude"] * math.sin(angle)) + along(axis, mass * rate)


def swell(vehicle: Vehicle, axis: str) -> dict[str, float] | None:
    """The corrections' sine and cosine as amplitude and phase."""
    c = vehicle.corrections
    sine, cosine = (c.get(f"{name}@{axis}", 0.0) for name in ("swell", "swell_ahead"))
    if not (sine or cosine):
        return None
    frequency = c.get(f"swell_rate@{axis}", 0.0)
    return {"amplitude": math.hypot(sine, cosine), "frequency": frequency, "phase": math.atan2(cosine, sine)}


EFFECT = PlacedEffect(
    "seiche",
    "axis",
    "drag at u_r - U, F += (m + m_A) dU/dt, U = amplitude sin(frequency t + phase)",
    (
        Number("amplitude", ("_m_s",), "of the water's speed", low=0.0, high=5.0, usual=lambda _: 0.05),
        Number("frequency", ("_rad_s",), "of the wave", low=0.01, high=20.0, usual=lambda _: 0.7, shape=True),
        Number("phase", ("_rad",), "at the start", 0.0, -7.0, 7.0, usual=lambda _: 1.0, shape=True),
    ),
    places=AXES[:3],
    wrench=seiche,
    of=swell,
    order=7,
)
