"""The hydrodynamics of one wet body, and its row in mjModel.body_user."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..plant.vehicle import Vehicle
from ..units import G_M_S2
from .record import FIELDS, MAGIC, SIZE, field

Array = NDArray[np.float64]
ALONG = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))  # axes along the body's


@dataclass(frozen=True, eq=False)
class Body:
    """What the water knows of a body, in the axes of its MuJoCo body, whatever they are.

    Attributes:
        added_mass: shape (6, 6), symmetric, over velocity of the origin and angular velocity [kg, kg m, kg m2].
        displaced_kg: mass of the displaced water; buoyancy is that times gravity [kg].
        centre_of_buoyancy_m: shape (3,) [m].
        drag_linear, drag_quadratic: along and about the axes of drag, shape (6,) [N/(m/s), N m/(rad/s);
            N/(m/s)2, N m/(rad/s)2].
        cross_flow: hindmost and foremost x of the hull [m], drag per length in sway and heave [N/(m/s)2/m]: Healey and
            Lienard's strips, in place of quadratic drag in these axes, pitch and yaw.
        centre_of_drag_m: shape (3,), where drag and cross-flow act [m].
        drag_axes: shape (3, 3), takes the axes of drag to the body's.
    """

    added_mass: Any
    displaced_kg: float = 0.0
    centre_of_buoyancy_m: Sequence[float] | Array = (0.0, 0.0, 0.0)
    drag_linear: Sequence[float] | Array = (0.0,) * 6
    drag_quadratic: Sequence[float] | Array = (0.0,) * 6
    cross_flow: Sequence[float] = (0.0,) * 4
    centre_of_drag_m: Sequence[float] | Array = (0.0, 0.0, 0.0)
    drag_axes: Any = ALONG

    def moved(self, place_m: Sequence[float] | Array, axes: Any = ALONG) -> Body:
        """The same hydrodynamics carried to another place [m] and turned by a rotation, shape (3, 3)."""
        turn, place = np.array(axes, dtype=float), np.array(place_m, dtype=float)
        x, y, z = place
        lever = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        there = np.block([[turn.T, -turn.T @ lever], [np.zeros((3, 3)), turn.T]])  # velocity at the new place
        return replace(
            self,
            added_mass=there.T @ np.array(self.added_mass) @ there,
            centre_of_buoyancy_m=place + turn @ self.centre_of_buoyancy_m,
            centre_of_drag_m=place + turn @ self.centre_of_drag_m,
            drag_axes=turn @ self.drag_axes,
        )


def of_vehicle(vehicle: Vehicle, gravity_m_s2: float) -> Body:
    """A vehicle's hydrodynamics: its buoyancy in N under this gravity (none: the standard one)."""
    if vehicle.corrections:
        told = "a diagnosed model, whose corrections only flights of whole vehicles have; expected its vehicle file"
        raise InputError(f"{vehicle.path}: {told}")
    return Body(
        added_mass=vehicle.added_mass,
        displaced_kg=vehicle.buoyancy_N / (abs(gravity_m_s2) or G_M_S2),
        centre_of_buoyancy_m=vehicle.centre_of_buoyancy_m,
        drag_linear=vehicle.linear_drag,
        drag_quadratic=vehicle.quadratic_drag,
    )


def row(body: Body, name: str) -> Array:
    """Numbers for mjModel.body_user, shape (SIZE,); InputError names the body and what is wrong with it."""
    numbers = np.zeros(SIZE)
    for key in ("magic", *(key for key in FIELDS if hasattr(body, key))):
        value = np.asarray(getattr(body, key, MAGIC), dtype=float)
        if value.shape != FIELDS[key]:
            raise InputError(f"body '{name}': {key} has the shape {value.shape}; expected {FIELDS[key]}")
        if not np.isfinite(value).all():
            raise InputError(f"body '{name}': {key} has a number that is not finite")
        field(numbers, key)[...] = value
    unmoved = Body(np.zeros((6, 6)))
    field(numbers, "drag_is_moved")[...] = any(
        not np.array_equal(getattr(body, key), getattr(unmoved, key)) for key in ("centre_of_drag_m", "drag_axes")
    )
    added = field(numbers, "added_mass")
    if not np.allclose(added, added.T, rtol=1e-9, atol=1e-9 * np.abs(added).max()):
        raise InputError(f"body '{name}': added_mass is not symmetric")
    for key in ("displaced_kg", "drag_linear", "drag_quadratic"):
        if field(numbers, key).min() < 0.0:
            raise InputError(f"body '{name}': {key} is negative; expected 0 or more")
    return numbers
