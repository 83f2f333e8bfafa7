"""Clearance between the hull and the walls ahead and astern, before a run and after it."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..plant.vehicle import Vehicle, load_vehicle
from ..record.files import is_file
from ..record.toml import find_file, meant, no_file, shown
from ..resources import models_dir
from .scenario import Scenario

WALLS = ("basin", "sea")  # in models/
LENGTHS_M = {"basin": 6.096}  # [m] wall ahead to wall astern: 20 ft, a guess (models/README.md); others are not known
MARGIN_M = 0.1  # [m] clearance that a command must leave for overshoot; a choice

vehicle_at = functools.cache(load_vehicle)  # by the file's whole path


def vehicle_path(name_or_path: str) -> Path:
    """The vehicle's file."""
    return find_file(name_or_path, models_dir(), "vehicle").resolve()


def vehicle_of(name_or_path: str) -> Vehicle:
    """The vehicle of that name or file, read once in a process."""
    vehicle: Vehicle = vehicle_at(vehicle_path(name_or_path))
    return vehicle


def walls_at(name_or_path: str) -> Path:
    """The MJCF of walls: of that name in models/, or at that path."""
    return Path(name_or_path) if name_or_path.endswith(".xml") else models_dir() / f"{name_or_path}.xml"


def missing_walls(name_or_path: str) -> str:
    """What is wrong with a name or path of walls; "" where they are there."""
    path = walls_at(name_or_path)
    if is_file(path):
        return ""
    known = f"; or one of {', '.join(WALLS)}"
    if name_or_path.endswith(".xml"):
        return no_file(path) + known
    return f"no walls named {shown(name_or_path)}{meant(name_or_path, WALLS)}; or the path of an .xml file"


def walls_path(scenario: Scenario) -> Path:
    """The MJCF of the walls; InputError where there is none."""
    if missing := missing_walls(scenario.walls):
        raise InputError(f"{scenario.path}: walls: {missing}")
    return walls_at(scenario.walls).resolve()


def clearances(scenario: Scenario, furthest_m: float, nearest_m: float) -> tuple[float, float]:
    """Water left before the bow and behind the stern [m] when x ranges from nearest_m to furthest_m.

    Infinite astern where the walls' distance is not known.
    """
    vehicle = vehicle_of(scenario.vehicle)
    bow, stern = vehicle.ends_m
    ahead = scenario.standoff_m - furthest_m - (bow - vehicle.sonar_x_m)
    length = LENGTHS_M.get(scenario.walls, np.inf)
    astern = length - scenario.standoff_m - (vehicle.sonar_x_m - stern) + nearest_m
    return ahead, astern


def check_command(scenario: Scenario) -> None:
    """InputError where the commanded motion itself, or the start, leaves too little water."""
    position = np.zeros(1)
    key = "standoff_m"
    if scenario.excitation.loop == "position" and scenario.excitation.axis == "surge":
        fine = np.arange(0.0, scenario.duration_s, 0.02)
        position, key = np.append(position, scenario.excitation.command(fine, scenario.duration_s)[0]), "excitation"
    _check(scenario, position, MARGIN_M, f"{key}: the commanded motion")


def check_motion(scenario: Scenario, position_m: np.ndarray) -> None:
    """InputError where the vehicle, whose simulated position is given [m], struck a wall."""
    _check(scenario, position_m, 0.0, "excitation: the simulated motion")


def _check(scenario: Scenario, position_m: np.ndarray, margin_m: float, what: str) -> None:
    ahead, astern = clearances(scenario, float(np.max(position_m)), float(np.min(position_m)))
    for clearance, place in ((ahead, "the wall ahead"), (astern, "the wall astern")):
        if not clearance >= margin_m:
            found = f"comes too near {place}: {clearance:.2f} m of water left, at least {margin_m:g} m expected"
            if clearance <= 0.0:
                found = f"hits {place}: {-clearance:.2f} m too far"
            remedy = "choose a smaller amplitude, another offset or another standoff_m"
            raise InputError(f"{scenario.path}: {what} {found}; {remedy}")
