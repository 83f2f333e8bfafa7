"""What is said of an effect at a place: its name, its numbers, and where in the tank it acts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ...plant.vehicle import AXES, Vehicle

Array = NDArray[np.float64]
Values = Mapping[str, float]
VEHICLE = "vehicle"  # the place of what is the vehicle's own
KINDS = ("axis", "thruster", "fin", "sensor", VEHICLE)


@dataclass(frozen=True)
class Number:
    """A number of an effect.

    Attributes:
        name: as in its law; the key of a scenario is the name with the unit's ending.
        endings: of the key, by unit: one for all places; of an axis that of forces and that of moments; of a thruster
            those of rev_s, command, N.
        meaning: in a few words.
        default: None where it must be given.
        low, high: what is admissible.
    """

    name: str
    endings: tuple[str, ...]
    meaning: str
    default: float | None = None
    low: float = -1e6
    high: float = 1e6


@dataclass
class Moving:
    """A vehicle at one instant, as the forces of effects see it; all in body axes unless said otherwise.

    Attributes:
        time_s: since the start [s].
        step_s: time step [s].
        vehicle: with the effects that change it.
        nu, through: velocity over ground and through the water, shape (6,) [m/s, rad/s].
        away: displacement of the origin since the start [m], and roll, pitch and turn of the heading [rad], shape (6,).
        earth: takes body axes to north, east, down, shape (3, 3).
        water_m_s2: acceleration of the water that moves uniformly, and of gravity, are left to the tank.
        gears: wrench of each thruster at 1 N, by its name, shape (6,).
        asked: what acts of the inputs, by thruster.
        memory: of effects that have any, by effect and place; `keep` of an effect carries it over a step.
    """

    time_s: float
    step_s: float
    vehicle: Vehicle
    nu: Array
    through: Array
    away: Array
    earth: Array
    gears: Mapping[str, Array] = field(default_factory=dict)
    asked: Mapping[str, float] = field(default_factory=dict)
    memory: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class PlacedEffect:
    """An effect that may be switched on at a place.

    Attributes:
        name, sentence, law: for people. kind: of its place, one of KINDS.
        numbers: its parameters. text: key of a text that it takes, and whether it must be given.
        places: axes at which it may stand, of an effect along an axis; channels: of which a sensor must have one.
        changes: (vehicle, place, values) -> the vehicle that is flown instead.
        rigid: (specification, values) changes the rigid body.
        input: (inputs, values) -> the inputs that act, of a thruster or a fin, shape (n,).
        delay: values -> by how much they act later [s].
        thrust: (time_s, inputs, forces, values) -> forces [N], shape (n,).
        wrench: (Moving, place, values) -> what acts on the body besides, shape (6,) [N, N m].
        keep: (Moving, place, values) -> its memory one step on.
    """

    name: str
    kind: str
    sentence: str
    law: str
    numbers: tuple[Number, ...] = ()
    text: tuple[str, bool] | None = None
    places: tuple[str, ...] = AXES
    channels: tuple[str, ...] = ()
    changes: Callable[[Vehicle, str, Any], Vehicle] | None = None
    rigid: Callable[[mujoco.MjSpec, Any], None] | None = None
    input: Callable[[Array, Any], Array] | None = None
    delay: Callable[[Any], float] | None = None
    thrust: Callable[[Array, Array, Array, Any], Array] | None = None
    wrench: Callable[[Moving, str, Any], Array] | None = None
    keep: Callable[[Moving, str, Any], float] | None = None


@dataclass(frozen=True)
class Placed:
    """An effect that is switched on: where, with which numbers by name, and with which text."""

    effect: PlacedEffect
    place: str
    values: Mapping[str, Any]

    @property
    def name(self) -> str:
        """NAME@PLACE."""
        return f"{self.effect.name}@{self.place}"


def along(axis: str, force: float) -> Array:
    """A force or moment along one of AXES as a wrench, shape (6,)."""
    wrench = np.zeros(6)
    wrench[AXES.index(axis)] = force
    return wrench


def with_part(vehicle: Vehicle, kind: str, name: str, **changed: Any) -> Vehicle:
    """The vehicle with other attributes of one of its `thrusters`, `fins` or `sensors`."""
    parts = getattr(vehicle, kind)
    others: Any = {kind: tuple(replace(part, **changed) if label(part) == name else part for part in parts)}
    return replace(vehicle, **others)


def part(vehicle: Vehicle, kind: str, name: str) -> Any:
    """The thruster, fin or sensor of that name."""
    return next(part for part in getattr(vehicle, kind) if label(part) == name)


def label(part: Any) -> str:
    """Name of a thruster, fin or sensor; of a thruster without one, its site's."""
    return str(part.name or part.site)
