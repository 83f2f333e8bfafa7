"""Effects of the water along or about one axis, in the units of that axis."""

from __future__ import annotations

import math
from dataclasses import replace

from ...plant.vehicle import AXES, Vehicle
from .effect import Array, Moving, Number, PlacedEffect, Values, along

REVERSAL = 0.005  # [m/s or rad/s] speed over which friction turns round; a guess, as of the single-axis effect
SPEED = ("_m_s", "_rad_s")


def slower(vehicle: Vehicle, axis: str, p: Values) -> Vehicle:
    """The vehicle with more linear drag along an axis."""
    drag = vehicle.linear_drag.copy()
    drag[AXES.index(axis)] += p["c"]
    return replace(vehicle, linear_drag=drag)


def friction(s: Moving, axis: str, p: Values) -> Array:
    """Against the motion over ground, whatever the speed."""
    return along(axis, -p["f"] * math.tanh(s.nu[AXES.index(axis)] / REVERSAL))


def asymmetry(s: Moving, axis: str, p: Values) -> Array:
    """Quadratic drag (1 + e) ahead, (1 - e) astern."""
    i = AXES.index(axis)
    return along(axis, -p["e"] * s.vehicle.quadratic_drag[i] * s.through[i] ** 2)


def resistance(s: Moving, axis: str, u: float) -> float:
    """Drag of the vehicle along an axis at a speed through the water."""
    i = AXES.index(axis)
    return float(-(s.vehicle.linear_drag[i] + s.vehicle.quadratic_drag[i] * abs(u)) * u)


def carried(s: Moving, axis: str, U: float) -> Array:
    """What drag is more where the water moves along the axis at U besides."""
    u = float(s.through[AXES.index(axis)])
    return along(axis, resistance(s, axis, u - U) - resistance(s, axis, u))


def drift(s: Moving, axis: str, p: Values) -> Array:
    """Drag acts on the speed less U."""
    return carried(s, axis, p["U"])


def spring(s: Moving, axis: str, p: Values) -> Array:
    """Back to where the run began."""
    return along(axis, -p["k"] * float(s.away[AXES.index(axis)]))


def wake(s: Moving, axis: str, p: Values) -> Array:
    """Drag acts on the speed less that of the wake."""
    return carried(s, axis, s.memory.get(f"wake_memory@{axis}", 0.0))


def wake_later(s: Moving, axis: str, p: Values) -> float:
    """The wake one step on: T dw/dt = k u - w."""
    before = s.memory.get(f"wake_memory@{axis}", 0.0)
    return before - math.expm1(-s.step_s / p["T"]) * (p["k"] * float(s.nu[AXES.index(axis)]) - before)


def seiche(s: Moving, axis: str, p: Values) -> Array:
    """Water that swings to and fro: drag at the speed through it, and the force of its acceleration."""
    i, angle = AXES.index(axis), p["frequency"] * s.time_s + p["phase"]
    mass = s.vehicle.mass_kg + s.vehicle.added_mass[i, i]  # displaced mass, as of what floats in balance
    rate = p["amplitude"] * p["frequency"] * math.cos(angle)
    return carried(s, axis, p["amplitude"] * math.sin(angle)) + along(axis, mass * rate)


def munk(s: Moving, axis: str, p: Values) -> Array:
    """A moment c u w about pitch, -c u v about yaw."""
    u, v, w = s.through[:3]
    return along(axis, p["c"] * u * (w if axis == "pitch" else -v))


def coupling(s: Moving, axis: str, p: Values) -> Array:
    """The force of another turning mass: -c u r in sway, c u q in heave, c v r in surge."""
    u, v, q, r = s.through[0], s.through[1], s.nu[4], s.nu[5]
    return along(axis, p["c"] * {"surge": v * r, "sway": -u * r, "heave": u * q}[axis])


def push(s: Moving, axis: str, p: Values) -> Array:
    """A constant force or moment in body axes."""
    return along(axis, p["F"])


HYDRODYNAMICS = (
    PlacedEffect(
        "linear_drag",
        "axis",
        "Drag that grows with speed itself, which the vehicle file has not.",
        "F = -c u_r",
        (
            Number(
                "c", ("_N_s_per_m", "_N_m_s_per_rad"), "drag per speed", low=0.0, usual=lambda s: 0.5 * s.force / s.u
            ),
        ),
        changes=slower,
    ),
    PlacedEffect(
        "coulomb_friction",
        "axis",
        "A guide or tether that rubs resists with a constant force.",
        "F = -f tanh(u / 5 mm/s or mrad/s)",
        (Number("f", ("_N", "_N_m"), "friction", low=0.0, usual=lambda s: 0.3 * s.force),),
        wrench=friction,
    ),
    PlacedEffect(
        "drag_asymmetry",
        "axis",
        "The two ends do not drag alike.",
        "F = -e D u_r^2",
        (
            Number(
                "e", ("",), "half the relative difference, ahead over astern", low=-0.95, high=0.95, usual=lambda _: 0.3
            ),
        ),
        wrench=asymmetry,
    ),
    PlacedEffect(
        "ambient_current",
        "axis",
        "The water drifts along the vehicle's own axis, so drag acts on another speed.",
        "drag at u_r - U",
        (Number("U", SPEED, "speed of the water", low=-5.0, high=5.0, usual=lambda s: 0.4 * s.u),),
        wrench=drift,
    ),
    PlacedEffect(
        "tether",
        "axis",
        "A slack cable pulls back to where the run began, along this axis of the vehicle.",
        "F = -k x",
        (Number("k", ("_N_per_m", "_N_m_per_rad"), "stiffness", low=0.0, usual=lambda s: 0.3 * s.force),),
        wrench=spring,
    ),
    PlacedEffect(
        "wake_memory",
        "axis",
        "The hull drags water along and meets it again on the way back.",
        "drag at u_r - w, T dw/dt = k u - w",
        (
            Number("k", ("",), "share of the speed that the wake takes up", low=0.0, high=0.9, usual=lambda _: 0.3),
            Number("T", ("_s",), "time that it takes", 5.0, 0.05, 600.0, usual=lambda _: 5.0, shape=True),
        ),
        wrench=wake,
        keep=wake_later,
    ),
    PlacedEffect(
        "seiche",
        "axis",
        "A standing wave carries the hull to and fro with the water.",
        "drag at u_r - U, F += (m + m_A) dU/dt, U = amplitude sin(frequency t + phase)",
        (
            Number("amplitude", ("_m_s",), "of the water's speed", low=0.0, high=5.0, usual=lambda _: 0.05),
            Number("frequency", ("_rad_s",), "of the wave", low=0.01, high=20.0, usual=lambda _: 0.7, shape=True),
            Number("phase", ("_rad",), "at the start", 0.0, -7.0, 7.0, usual=lambda _: 1.0, shape=True),
        ),
        places=AXES[:3],
        wrench=seiche,
    ),
    PlacedEffect(
        "munk_moment",
        "axis",
        "The moment of a slender hull in oblique flow is another than its added masses say.",
        "M += c u_r w_r about pitch, N -= c u_r v_r about yaw",
        (Number("c", ("_kg",), "difference of added masses", usual=lambda s: 0.3 * s.mass),),
        places=("pitch", "yaw"),
        wrench=munk,
    ),
    PlacedEffect(
        "coriolis",
        "axis",
        "Another mass turns with the hull than the vehicle file has.",
        "X += c v_r r, Y -= c u_r r, Z += c u_r q",
        (Number("c", ("_kg",), "mass that turns besides", usual=lambda s: 0.3 * s.mass),),
        places=AXES[:3],
        wrench=coupling,
    ),
    PlacedEffect(
        "constant_force",
        "axis",
        "Something pushes all the time, in the vehicle's own axes.",
        "F += F",
        (Number("F", ("_N", "_N_m"), "force or moment", usual=lambda s: 0.3 * s.force),),
        wrench=push,
    ),
)
