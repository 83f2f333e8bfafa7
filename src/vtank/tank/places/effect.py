"""What is said of an effect at a place: its name, its numbers, and where in the tank it acts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import mujoco
import numpy as np
from numpy.typing import NDArray

from ...plant.vehicle import AXES, Vehicle
from .usual import Usual

Array = NDArray[np.float64]
Values = Mapping[str, float]
VEHICLE = "vehicle"  # the place of what is the vehicle's own
KINDS = ("axis", "thruster", "fin", "sensor", VEHICLE)
INPUT = ("_rev_s", "", "_N")  # endings of a number by the thruster's input: rev_s, command, N


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
        channel: that it changes alone, which the sensor must measure; "" for all.
        usual: what is usual at a place; shape: whether that is so whatever the size of the effect.
        slot: name in `rigid.layout`, but for the place, of what a diagnosis moves where this is found; "" for none.
    """

    name: str
    endings: tuple[str, ...]
    meaning: str
    default: float | None = None
    low: float = -1e6
    high: float = 1e6
    channel: str = ""
    usual: Callable[[Usual], float] = field(kw_only=True, default=lambda _: 1.0)
    shape: bool = field(kw_only=True, default=False)
    slot: str = field(kw_only=True, default="")


TO_EARTH = np.array([[1.0], [-1.0], [-1.0]])  # from the world's axes, north, west, up, to north, east, down


@dataclass(eq=False)
class Moving:
    """A vehicle at one instant, as the forces of effects see it; what follows from the rest is found when asked for.

    Attributes:
        time_s: since the start [s]. step_s: time step [s].
        vehicle: with the effects that change it.
        turn: takes body axes to the world's, shape (3, 3).
        velocity: of the origin in world axes and angular in body axes, shape (6,) [m/s, rad/s].
        displaced: displacement of the origin since the start, world axes, shape (3,) [m].
        water: () -> velocity of the water there, world axes [m/s].
        last_heading: an instant ago, beyond half a turn too [rad].
        gears: wrench of each thruster at 1 N, by its name, shape (6,).
        asked: what acts of the inputs, by thruster.
        ahead: () -> distance from the origin along the body's x to what is there [m]; infinite for nothing.
        memory: of effects that have any, by effect and place; `keep` of an effect carries it over a step.
    """

    time_s: float
    step_s: float
    vehicle: Vehicle
    turn: Array
    velocity: Array
    displaced: Array
    water: Callable[[], Any]
    last_heading: float
    gears: Mapping[str, Array]
    asked: Mapping[str, float]
    ahead: Callable[[], float]
    memory: dict[str, float]

    @cached_property
    def nu(self) -> Array:
        """Velocity over ground, body axes, shape (6,) [m/s, rad/s]."""
        return np.concatenate([self.velocity[:3] @ self.turn, self.velocity[3:]])

    @cached_property
    def through(self) -> Array:
        """Velocity through the water, body axes, shape (6,) [m/s, rad/s]."""
        return np.concatenate([(self.velocity[:3] - self.water()) @ self.turn, self.velocity[3:]])

    @cached_property
    def earth(self) -> Array:
        """Takes body axes to north, east, down, shape (3, 3)."""
        return TO_EARTH * self.turn

    @cached_property
    def gap_m(self) -> float:
        """Distance from the sonar to the wall ahead [m]."""
        return self.ahead() - self.vehicle.sonar_x_m

    @cached_property
    def heading(self) -> float:
        """Heading, counted on beyond half a turn [rad]."""
        change = math.atan2(self.earth[1, 0], self.earth[0, 0]) - self.last_heading
        return self.last_heading + (change + math.pi) % (2.0 * math.pi) - math.pi

    @cached_property
    def away(self) -> Array:
        """Displacement since the start in body axes [m], and roll, pitch and turn of the heading [rad], shape (6,)."""
        roll, pitch = math.atan2(self.earth[2, 1], self.earth[2, 2]), -math.asin(min(max(self.earth[2, 0], -1.0), 1.0))
        return np.concatenate([self.displaced @ self.turn, [roll, pitch, self.heading]])


@dataclass(frozen=True)
class PlacedEffect:
    """An effect that may be switched on at a place.

    Attributes:
        name: that of its file. kind: of its place, one of KINDS, that of its folder. law: the formula, for people.
        numbers: its parameters.
        text: that it takes: the "channel" of a sensor that is meant, default all; the "other" thruster whose inputs are
            exchanged with this one's.
        places: axes at which it may stand, of an effect along an axis; channels: of which a sensor must have one.
        changes: (vehicle, place, values) -> the vehicle that is flown instead.
        drifts: values -> current to the north, east and down [m/s].
        rigid: (specification, values) changes the rigid body.
        input: (inputs, values) -> the inputs that act, of a thruster or a fin, shape (n,).
        recorded: (inputs, values, random numbers) -> what is recorded of the inputs, shape (n,).
        delay: values -> by how much they act later [s].
        thrust: (time_s, inputs, forces, values) -> forces [N], shape (n,).
        wrench: (Moving, place, values) -> what acts on the body besides, shape (6,) [N, N m].
        keep: (Moving, place, values) -> its memory one step on.
        heavier: (Moving, values) -> added mass in surge besides [kg], held over a step.
        of: (vehicle, place) -> numbers that stand for the vehicle's corrections there, or None; by default those of
            its numbers that have a slot.
        order: place among the effects of its kind, in which they act; by default the last.
    """

    name: str
    kind: str
    law: str
    numbers: tuple[Number, ...] = ()
    text: Literal["", "channel", "other"] = ""
    places: tuple[str, ...] = AXES
    channels: tuple[str, ...] = ()
    changes: Callable[[Vehicle, str, Any], Vehicle] | None = None
    drifts: Callable[[Any], tuple[float, float, float]] | None = None
    rigid: Callable[[mujoco.MjSpec, Any], None] | None = None
    input: Callable[[Array, Any], Array] | None = None
    recorded: Callable[[Array, Any, np.random.Generator], Array] | None = None
    delay: Callable[[Any], float] | None = None
    thrust: Callable[[Array, Array, Array, Any], Array] | None = None
    wrench: Callable[[Moving, str, Any], Array] | None = None
    keep: Callable[[Moving, str, Any], float] | None = None
    heavier: Callable[[Moving, Any], float] | None = None
    of: Callable[[Vehicle, str], dict[str, Any] | None] | None = None
    order: float = math.inf

    def corrected(self, vehicle: Vehicle, place: str) -> dict[str, Any] | None:
        """All of its numbers where the vehicle's corrections are this effect at a place; None where they are not."""
        if self.of:
            found = self.of(vehicle, place)
        else:
            c, at = vehicle.corrections, "hull" if place == VEHICLE else place
            slots = {number.name: f"{number.slot}@{at}" for number in self.numbers if number.slot}
            found = {name: c[slot] for name, slot in slots.items() if slot in c} or None
        return None if found is None else {number.name: number.default or 0.0 for number in self.numbers} | found


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
    others: Any = {kind: tuple(replace(part, **changed) if part.name == name else part for part in parts)}
    return replace(vehicle, **others)


def part(vehicle: Vehicle, kind: str, name: str) -> Any:
    """The thruster, fin or sensor of that name."""
    return next(part for part in getattr(vehicle, kind) if part.name == name)
