"""Clearance between the hull and the tank's walls, before a run and after it."""

from __future__ import annotations

import numpy as np

from ..errors import InputError
from .scenario import Scenario

# Lengths along x, from models/phoenix.toml and models/tank.xml
BOW_AHEAD_OF_SONAR_M = 0.04318  # [m] hull's nose, 1.10998 m, less the sonar, 1.0668 m
STERN_BEHIND_SONAR_M = 2.2225  # [m] sonar less the propeller plane, -1.1557 m
TANK_LENGTH_M = 6.096  # [m] 20 ft, a guess (models/README.md)
MARGIN_M = 0.1  # [m] clearance that a command must leave for overshoot; a choice


def clearances(scenario: Scenario, furthest_m: float, nearest_m: float) -> tuple[float, float]:
    """Water left before the bow and behind the stern [m] when x ranges from nearest_m to furthest_m."""
    ahead = scenario.standoff_m - furthest_m - BOW_AHEAD_OF_SONAR_M
    astern = TANK_LENGTH_M - scenario.standoff_m - STERN_BEHIND_SONAR_M + nearest_m
    return ahead, astern


def check_command(scenario: Scenario) -> None:
    """InputError where the commanded motion itself, or the start, leaves too little water."""
    position = np.zeros(1)
    key = "standoff_m"
    if scenario.excitation.loop == "position":
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
