"""A vehicle's hydrodynamics: what MuJoCo's rigid body does not know.

Body axes x forward, y starboard, z down. Rigid-body mass, inertia and centre of gravity stand in the vehicle's MJCF;
added mass, drag, buoyancy and thrusters stand in a TOML file beside it (models/phoenix.toml is the example).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..record.table import Table, open_table
from ..record.toml import find_file
from ..resources import models_dir
from ..units import G_M_S2
from .actuators import Fin, Thruster, read_fin, read_thruster
from .sensor import Sensor, read_sensors

CORRECTED = "vtank.whole/2"  # schema of the file of a vehicle that a diagnosis corrected
KEYS = ("name", "mjcf", "body", "added_mass", "quadratic_drag", "linear_drag", "propeller", "thruster", "fin", "sensor",
        "sites", "hull")  # fmt: skip
BODY = ("mass_kg", "inertia_kg_m2", "centre_of_gravity_m", "centre_of_buoyancy_m", "buoyancy_N", "heave_N_per_m")
MOST_TRIM = 0.5  # of the weight by which buoyancy may miss it: generous for a heavy crawler or a light float; a choice
AHEAD = (1.0, 0.0, 0.0)
AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
ADDED_MASS = ("surge_kg", "sway_kg", "heave_kg", "roll_kg_m2", "pitch_kg_m2", "yaw_kg_m2")
COUPLING = {"sway_yaw_kg_m": (1, 5), "heave_pitch_kg_m": (2, 4), "surge_pitch_kg_m": (0, 4), "sway_roll_kg_m": (1, 3)}
QUADRATIC_DRAG = tuple(f"{axis}_N_s2_per_m2" for axis in AXES[:3]) + tuple(
    f"{axis}_N_m_s2_per_rad2" for axis in AXES[3:]
)
LINEAR_DRAG = tuple(f"{axis}_N_s_per_m" for axis in AXES[:3]) + tuple(f"{axis}_N_m_s_per_rad" for axis in AXES[3:])


@dataclass(frozen=True)
class Vehicle:
    """Hydrodynamics of one vehicle.

    Attributes:
        name: as in the file.
        mjcf: path of the rigid body.
        mass_kg: mass of the rigid body, the same as in the MJCF [kg].
        added_mass: shape (6, 6), symmetric, positive: -X_udot, ..., -N_rdot [kg, kg m, kg m2].
        quadratic_drag: shape (6,), positive; entry 0 is the published surge drag, which the tank does not use because
            surge drag comes from the truth [N/(m/s)2, N m/(rad/s)2].
        linear_drag: shape (6,) [N/(m/s), N m/(rad/s)].
        buoyancy_N: buoyant force, up [N].
        centre_of_buoyancy_m: shape (3,) in body axes [m].
        propeller_sites: sites of the propellers that drive surge; where the file names none, the thrusters' that push
            straight ahead.
        propeller_diameter_m: [m], NaN where the file has none.
        thrusters: all thrusters of the file, the propellers among them where it lists them.
        sites: places on the body, name of the MJCF's site -> body axes [m].
        fins: control surfaces, and fixed ones.
        sensors: instruments.
        heave_N_per_m: by which the origin of a surface craft is held at its waterline, 0 for what dives [N/m].
        path: of the file it was read from.
        centre_m: centre of gravity, body axes [m], where the file gives it; `tank.described` reads it from the MJCF.
        inertia: of the body about its centre of gravity, roll, pitch and yaw [kg m2], in the same way.
        corrections: what a diagnosis found otherwise: numbers that take the place of the file's, by the names of
            `rigid.layout`; `tank.corrected` makes a flight of them.
    """

    name: str
    mjcf: Path
    mass_kg: float
    added_mass: np.ndarray
    quadratic_drag: np.ndarray
    linear_drag: np.ndarray
    buoyancy_N: float
    centre_of_buoyancy_m: np.ndarray
    propeller_sites: tuple[str, ...]
    propeller_diameter_m: float
    thrusters: tuple[Thruster, ...]
    sites: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    fins: tuple[Fin, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    heave_N_per_m: float = 0.0
    path: Path = Path()
    centre_m: tuple[float, float, float] | None = None
    inertia: tuple[float, float, float] | None = None
    corrections: Mapping[str, float] = field(default_factory=dict)

    @property
    def steering(self) -> tuple[Thruster, ...]:
        """The thrusters but those that push straight ahead at a propeller's site: these are the surge equation's."""
        return tuple(t for t in self.thrusters if not (t.site in self.propeller_sites and t.direction == AHEAD))

    @property
    def complete(self) -> bool:
        """Whether nothing that the equations of motion need is left to the MJCF."""
        seated = {t.site for t in self.thrusters} | {fin.site for fin in self.fins}
        return seated <= self.sites.keys() and self.centre_m is not None and self.inertia is not None

    @property
    def moving_mass_kg(self) -> float:
        """m - X_udot: what a surge force accelerates [kg]."""
        return self.mass_kg + float(self.added_mass[0, 0])

    @property
    def sonar_x_m(self) -> float:
        """How far the first sonar stands ahead of the body's origin [m]; 0 where the file lists none."""
        return next((place[0] for name, place in self.sites.items() if name.startswith("sonar")), 0.0)

    def instrument(self, column: str) -> str:
        """The instrument of a recorded column: what stands before its dot, else the only one that has its channel.

        "" where none of the file has it, or several have.
        """
        named, _, channel = column.rpartition(".")
        having = [sensor.name for sensor in self.sensors if channel in sensor.channels]
        return named or (having[0] if len(having) == 1 else "")

    @property
    def ends_m(self) -> tuple[float, float]:
        """Foremost and hindmost of the listed places [m], body axes."""
        along = [place[0] for place in self.sites.values()] or [0.0]
        return max(along), min(along)


def load_vehicle(name_or_path: str | Path = "phoenix") -> Vehicle:
    """The vehicle of that name in models/, of a TOML file, or of a diagnosed model; InputError names file and key."""
    return _load(find_file(name_or_path, models_dir(), "vehicle"), ())


def _load(path: Path, through: tuple[Path, ...]) -> Vehicle:
    """through: diagnosed models on the way to this file."""
    file = open_table(path)
    if file.entries.get("schema") == CORRECTED:
        return _corrected(file, through)
    file.check_keys(KEYS)
    body, propeller = file.table("body").check_keys(BODY), file.table("propeller").check_keys(("sites", "diameter_m"))
    places, thrusters = file.table("sites"), tuple(read_thruster(table) for table in file.tables("thruster"))
    return Vehicle(
        name=file.text("name"),
        mjcf=Path(file.file("mjcf", ending="")),
        mass_kg=body.positive("mass_kg"),
        added_mass=_added_mass(file.table("added_mass")),
        quadratic_drag=_drag(file.table("quadratic_drag"), QUADRATIC_DRAG, None),
        linear_drag=_drag(file.table("linear_drag"), LINEAR_DRAG, 0.0),
        buoyancy_N=_buoyancy_N(body),
        centre_of_buoyancy_m=np.array(body.vector("centre_of_buoyancy_m")),
        propeller_sites=propeller.texts("sites") if propeller.entries else _ahead(thrusters),
        propeller_diameter_m=propeller.positive("diameter_m") if propeller.entries else math.nan,
        thrusters=thrusters,
        fins=tuple(read_fin(table) for table in file.tables("fin")),
        sensors=read_sensors(file.table("sensor")),
        heave_N_per_m=body.number("heave_N_per_m", 0.0, 0.0),
        path=path,
        centre_m=body.vector("centre_of_gravity_m") if body.has("centre_of_gravity_m") else None,
        inertia=body.vector("inertia_kg_m2") if body.has("inertia_kg_m2") else None,
        sites={key.removesuffix("_m"): places.vector(key) for key in places.entries},
    )


def _corrected(file: Table, through: tuple[Path, ...]) -> Vehicle:
    """The vehicle of a diagnosed model: its file's, with what the diagnosis found otherwise."""
    if file.has("plant"):
        told = (
            "stands for a simulator that it was fitted to, which flies itself; expected a diagnosis of a vehicle file"
        )
        raise file.error("plant", told)
    path = find_file(file.file("vehicle", presets=(models_dir(), "vehicle")), models_dir(), "vehicle")
    if path.resolve() in (*through, file.path.resolve()):
        raise file.error("vehicle", "a diagnosed model of itself; expected the vehicle file that was diagnosed")
    known, found = _load(path, (*through, file.path.resolve())), file.table("diagnosed")
    corrections = {**known.corrections, **{name: found.number(name) for name in found.entries}}
    return replace(known, name=f"{known.name}, corrected", path=file.path, corrections=corrections)


def _ahead(thrusters: tuple[Thruster, ...]) -> tuple[str, ...]:
    """Sites of those that push straight ahead."""
    return tuple(thruster.site for thruster in thrusters if thruster.direction == AHEAD)


def _buoyancy_N(body: Table) -> float:
    """Of [body]; InputError where neither what dives nor what floats has so little or so much of it [N]."""
    mass, buoyancy = body.positive("mass_kg"), body.positive("buoyancy_N")
    weight = mass * G_M_S2
    if abs(buoyancy / weight - 1.0) > MOST_TRIM:
        in_kilograms = abs(buoyancy / mass - 1.0) <= MOST_TRIM
        cause = "is it in kilograms?" if in_kilograms else "has its decimal point slipped, or that of mass_kg?"
        told = f"found {buoyancy:g} N, but {mass:g} kg weigh {weight:.4g} N; expected within {MOST_TRIM:.0%} of that"
        raise body.error("buoyancy_N", f"{told}; {cause}")
    return buoyancy


def _added_mass(table: Table) -> np.ndarray:
    table.check_keys((*ADDED_MASS, *COUPLING))
    matrix = np.diag([table.number(key) for key in ADDED_MASS])
    for key, (row, column) in COUPLING.items():
        matrix[row, column] = matrix[column, row] = table.number(key, 0.0)
    if np.linalg.eigvalsh(matrix)[0] < 0.0:
        raise InputError(
            f"{table.path}: {table.name}: the matrix has a negative eigenvalue; added mass cannot be negative"
        )
    return matrix


def _drag(table: Table, keys: tuple[str, ...], default: float | None) -> np.ndarray:
    table.check_keys(keys)
    values = np.array([table.number(key, default) for key in keys])
    if values.min() < 0.0:
        key = keys[int(values.argmin())]
        raise table.error(key, "drag coefficients are given as positive numbers")
    return values
