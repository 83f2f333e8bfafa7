"""Every number of a whole vehicle in one vector, in blocks: the hull, each thruster, fin, instrument and column.

Named QUANTITY@PLACE, as `linear_drag@yaw`, `gain@bow_port`, `latency@dvl`, `bias@dvl.surge_m_s`. What a vehicle file
states stands in `null`; the other slots are at the value where they do nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..plant.vehicle import AXES, Vehicle
from ..plant.vehicle import COUPLING as COUPLING_OF
from ..record.columns import channel_of
from ..units import G_M_S2
from .flow import STILL, Flow
from .push import Push

Array = NDArray[np.float64]
G = G_M_S2

# Offsets of quantities within their block; those of an axis take six slots, vectors three.
MASS, CENTRE, INERTIA, ADDED, COUPLED = 0, 1, 4, 7, 13
LINEAR, QUADRATIC, ASYMMETRY, FRICTION, FORCE = 17, 23, 29, 35, 41
WEIGHT, BUOYANCY, BUOYED, WATERLINE = 47, 48, 49, 52
CURRENT, PULL, TETHER, CORIOLIS, LEFT_OUT, COUPLING, CROSSFLOW, NOSE = 53, 56, 59, 60, 61, 62, 67, 69
DRIFT, SPRING, WAKE, RECOVERY, SWELL, SWELL_RATE, SWELL_AHEAD, HELD_AT, TRIM = 70, 76, 82, 88, 94, 97, 100, 103, 106
TAIL, WALL_DRAG, WALL_MASS, FLOWS, LENT = 110, 111, 112, 113, 119
HULL = 120
DIRECTION, PLACE, COUPLE, GAIN, DEADBAND, SATURATION, SKEWED, LAG = 0, 3, 6, 9, 10, 11, 12, 13
DELAY, LOSS, SAG, LOST, SLOWER, MISREAD = 14, 15, 16, 17, 18, 19
YAWED, PITCHED, WIRED, SPIKED, ROTOR, PATH = 20, 21, 22, 23, 24, 25
THRUSTER = 26
AXIS, SEAT, PRESSURE, LIFT, STALL, DRAG, GONE, OFFSET, INDUCED, LATE, SUCTION = 0, 3, 6, 7, 8, 9, 10, 11, 12, 13, 14
HOLDS, LEANS, ASLANT, RATIO, SWEPT = 15, 16, 17, 18, 19
FIN = 20
LATENCY, SKEW, ROTATED, SITE, EARTH, BEARING = 0, 1, 2, 5, 8, 9
SENSOR = 10
SCALE, BIAS = 0, 1
COLUMN = 2
COUPLES = {"surge": "v r", "sway": "u r", "yaw": "u v", "heave": "u q", "pitch": "u w"}
XYZ = ("x", "y", "z")


def _hull_names() -> list[str]:
    along = [f"{q}@{axis}" for q in ("linear_drag", "quadratic_drag", "drag_asymmetry", "coulomb_friction", "force")
             for axis in AXES]  # fmt: skip
    return [
        "mass@hull", *(f"centre_of_gravity_{i}@hull" for i in XYZ), *(f"inertia@{axis}" for axis in AXES[3:]),
        *(f"added_mass@{axis}" for axis in AXES),
        *(f"added_mass_{pair}@hull" for pair in ("sway_yaw", "heave_pitch", "surge_pitch", "sway_roll")),
        *along, "weight@hull", "buoyancy@hull", *(f"centre_of_buoyancy_{i}@hull" for i in XYZ), "waterline@heave",
        *(f"{quantity}_{i}@hull" for quantity in ("current", "pull") for i in ("north", "east", "down")),
        "tether@hull", "coriolis@hull", "left_out@hull", *(f"coupling@{axis}" for axis in COUPLES),
        "crossflow_h@hull", "crossflow_v@hull", "nose@hull",
        *(f"{q}@{axis}" for q in ("drift", "spring", "wake", "recovery") for axis in AXES),
        *(f"{q}@{axis}" for q in ("swell", "swell_rate", "swell_ahead") for axis in AXES[:3]),
        *(f"held_at_{i}@hull" for i in XYZ), "trim@hull", *(f"trim_{i}@hull" for i in XYZ), "tail@hull",
        "wall_drag@surge", "wall_mass@surge", *(f"flow@{axis}" for axis in AXES), "lent@hull",
    ]  # fmt: skip


THRUSTER_NAMES = (*(f"direction_{i}" for i in XYZ), *(f"place_{i}" for i in XYZ), *(f"couple_{i}" for i in XYZ), "gain",
                  "deadband", "saturation", "asymmetry", "lag", "delay", "loss", "sag",
                  "lost", "slower", "misread", "yawed", "pitched", "wired", "spiked", "rotor", "path")  # fmt: skip
FIN_NAMES = (*(f"axis_{i}" for i in XYZ), *(f"place_{i}" for i in XYZ), "pressure", "lift", "stall", "drag", "lost",
             "offset", "induced_drag", "late", "suction", "holds", "leans", "aslant",
             "ratio", "path")  # fmt: skip
SENSOR_NAMES = ("latency", "skew", *(f"rotation_{i}" for i in ("roll", "pitch", "yaw")),
                *(f"position_{i}" for i in XYZ), "earth", "wall_bearing")  # fmt: skip
COLUMN_NAMES = ("scale", "bias")
COUPLED_AT = tuple(COUPLING_OF.values())


class Hull(NamedTuple):
    """Parameters (P,) for the kernels, counts of blocks, `masses`, and where the run began: place and heading (4,).

    gears: wrench of each thruster at 1 N, (K, 6); losing: whether any of them loses thrust with speed; creep: speed
    over which dry friction turns round, (6,) [m/s, rad/s], in parts of a step that are `often` as many; flow: forces of
    the water beyond drag; wall, facing: distance ahead of the start to the wall [m], from where the sonar sits, and the
    heading at which it is square [rad].
    """

    p: Array
    counts: NDArray[np.int64]
    body: Array
    water: Array
    inverse: Array
    home: Array
    gears: Array
    losing: bool
    creep: Array
    often: int
    flow: Flow
    wall: float
    facing: float
    sonar_m: float


@dataclass(frozen=True, eq=False)
class Layout:
    """Where each number of a vehicle and of its recorded columns stands.

    Attributes:
        vehicle: the nominal one.
        pushes: what pushes it: its thrusters, or the wrench that was recorded.
        sensors: names of the instruments that recorded (`Vehicle.instrument`), "" for columns without one.
        columns: the recorded channels, as they are called.
        fitted: numbers of a simulator that take the place of the vehicle file's, by name; others are passed over.
        flow: forces of the water beyond drag, in that simulator.
        followed: columns that tell of known motion alone, which the filter follows; nothing is judged by them.
    """

    vehicle: Vehicle
    pushes: tuple[Push, ...]
    sensors: tuple[str, ...]
    columns: tuple[str, ...]
    fitted: Mapping[str, float] = field(default_factory=dict)
    flow: Flow = STILL
    followed: frozenset[str] = frozenset()

    @cached_property
    def judged(self) -> NDArray[np.bool_]:
        """Columns that tell of what is asked about, (C,)."""
        return np.array([name not in self.followed for name in self.columns], dtype=bool)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of all slots, shape (P,)."""
        blocks = [(THRUSTER_NAMES, push.name) for push in self.pushes]
        blocks += [(FIN_NAMES, fin.name) for fin in self.vehicle.fins]
        blocks += [(SENSOR_NAMES, name) for name in self.sensors] + [(COLUMN_NAMES, name) for name in self.columns]
        return (*_hull_names(), *(f"{quantity}@{place}" for names, place in blocks for quantity in names))

    @cached_property
    def slots(self) -> dict[str, int]:
        """Index of each name."""
        return {name: i for i, name in enumerate(self.names)}

    @cached_property
    def counts(self) -> NDArray[np.int64]:
        """Thrusters, fins, instruments, columns; for the kernels."""
        vehicle = self.vehicle
        return np.array([len(self.pushes), len(vehicle.fins), len(self.sensors), len(self.columns)], np.int64)

    def slot(self, name: str) -> int:
        """Index of a name; InputError for an unknown one."""
        if name not in self.slots:
            raise InputError(f"no parameter '{name}' of {self.vehicle.name}")
        return self.slots[name]

    @cached_property
    def starts(self) -> tuple[int, int, int, int]:
        """First slots of the blocks of thrusters, fins, instruments and columns."""
        ends = np.cumsum([HULL, *(self.counts[:3] * (THRUSTER, FIN, SENSOR))])
        return tuple(int(end) for end in ends)  # type: ignore[return-value]

    @cached_property
    def null(self) -> Array:
        """The nominal vehicle, shape (P,)."""
        vehicle, p = self.vehicle, np.zeros(len(self.names))
        p[MASS], p[CENTRE : CENTRE + 3], p[INERTIA : INERTIA + 3] = vehicle.mass_kg, vehicle.centre_m, vehicle.inertia
        p[ADDED : ADDED + 6] = np.diag(vehicle.added_mass)
        p[COUPLED : COUPLED + 4] = [vehicle.added_mass[at] for at in COUPLED_AT]
        p[LINEAR : LINEAR + 6], p[QUADRATIC : QUADRATIC + 6] = vehicle.linear_drag, vehicle.quadratic_drag
        p[WEIGHT], p[BUOYANCY] = vehicle.mass_kg * G, vehicle.buoyancy_N
        p[BUOYED : BUOYED + 3], p[WATERLINE] = vehicle.centre_of_buoyancy_m, vehicle.heave_N_per_m
        p[CORIOLIS], p[FLOWS : FLOWS + 6] = 1.0, 1.0
        p[RECOVERY : RECOVERY + 6] = 5.0  # [s] of a wake that there is not
        p[NOSE], p[TAIL] = vehicle.ends_m
        thrusters, fins, sensors, columns = self.starts
        for k, push in enumerate(self.pushes):
            own = p[thrusters + THRUSTER * k :][:THRUSTER]
            own[DIRECTION : DIRECTION + 9] = *push.direction, *push.place_m, *push.couple
            own[GAIN], own[SATURATION], own[LAG] = 1.0, np.inf, push.lag_s
        for k, fin in enumerate(vehicle.fins):
            own = p[fins + FIN * k :][:FIN]
            own[AXIS : AXIS + 3], own[SEAT : SEAT + 3] = fin.axis, vehicle.sites[fin.site]
            own[PRESSURE], own[LIFT] = 0.5 * fin.density_kg_per_m3 * fin.area_m2, fin.lift_per_rad
            own[STALL], own[DRAG], own[SUCTION] = fin.stall_rad, fin.drag, fin.suction
            own[LEANS], own[ASLANT], own[RATIO] = 1.0, 1.0, 1.0
        known = {sensor.name: sensor for sensor in vehicle.sensors}
        for k, name in enumerate(self.sensors):
            own = p[sensors + SENSOR * k :][:SENSOR]
            if sensor := known.get(name):
                own[LATENCY], own[SKEW], own[SITE : SITE + 3] = sensor.late_s, sensor.clock_skew, sensor.position_m
                own[ROTATED : ROTATED + 3] = np.radians(sensor.rotation_deg)
        p[columns + SCALE :: COLUMN] = 1.0
        for k, column in enumerate(self.columns):
            sensor, channel = known.get(vehicle.instrument(column)), channel_of(column)
            if sensor and channel in sensor.channels:
                p[columns + COLUMN * k + BIAS] = sensor.each("bias")[sensor.channels.index(channel)]
        for name, value in (*vehicle.corrections.items(), *self.fitted.items()):
            if name in self.slots:
                p[self.slots[name]] = value
        return p

    def vector(self, values: dict[str, float]) -> Array:
        """The nominal vector with some slots set, shape (P,)."""
        p = self.null.copy()
        for name, value in values.items():
            p[self.slot(name)] = value
        return p

    def at(self, names: Iterable[str]) -> NDArray[np.int64]:
        """Indices of several slots."""
        return np.array([self.slot(name) for name in names], dtype=np.int64)


def masses(p: Array, moved: Sequence[bool] | NDArray[np.bool_]) -> tuple[Array, Array, Array]:
    """Mass matrices of the body and of the water, and the inverse of their sum over the axes that move; (6, 6) each.

    What is lent of the body [kg], and of its inertia by as much, is counted in the numbers of the added mass.

    InputError where they are not positive definite. Fossen (2011), eq. (3.44): M_RB about the body's origin.
    """
    m, inertia, (x, y, z) = p[MASS] + p[LENT], p[INERTIA : INERTIA + 3], p[CENTRE : CENTRE + 3]
    lent = p[LENT] / p[MASS] * inertia if p[LENT] else np.zeros(3)
    S = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    body = np.block([[m * np.eye(3), -m * S], [m * S, np.diag(inertia + lent) - m * S @ S]])
    water = np.diag(p[ADDED : ADDED + 6] - np.append(np.full(3, p[LENT]), lent))
    for (i, j), value in zip(COUPLED_AT, p[COUPLED : COUPLED + 4], strict=True):
        water[i, j] = water[j, i] = value
    if p[TRIM]:
        x, y, z = p[TRIM + 1 : TRIM + 4]
        T = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        body = body + p[TRIM] * np.block([[np.eye(3), -T], [T, -T @ T]])
    free, inverse = np.flatnonzero(moved), np.zeros((6, 6))
    inner = (body + water)[np.ix_(free, free)]
    if np.linalg.eigvalsh(inner)[0] <= 0.0:
        raise InputError("body and added mass together are not positive definite")
    inverse[np.ix_(free, free)] = np.linalg.inv(inner)
    return body, water, inverse
