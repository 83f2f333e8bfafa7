"""Forces along one axis that no catalogue has: what is called unknown when it is found."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ....plant.vehicle import AXES, Vehicle
from ....tank.places import Moving, Placed, PlacedEffect, Usual, along


def draw_strange(random: np.random.Generator, vehicle: Vehicle, axis: str, size: float, duration_s: float) -> Placed:
    """A force of a drawn family along an axis; size 1 is usual."""
    usual = Usual(vehicle, "axis", axis)
    family, push = str(random.choice(sorted(FAMILIES))), size * usual.force
    rad_s, phase = random.uniform(0.2, 1.2), random.uniform(0.0, 6.28)
    start_s = random.uniform(0.2, 0.5) * duration_s
    numbers = {"F": push, "u": usual.u, "rad_s": rad_s, "phase": phase, "start_s": start_s}
    return strange(family, axis, numbers)


def strange(family: str, axis: str, numbers: Mapping[str, float]) -> Placed:
    """The force of a family of FAMILIES along an axis."""

    def wrench(s: Moving, place: str, p: dict[str, float]) -> NDArray[np.float64]:
        return along(place, FAMILIES[family](s, AXES.index(place), p))

    effect = PlacedEffect(family, "axis", "no catalogue has it", wrench=wrench)
    return Placed(effect, axis, numbers)


def cubic(s: Moving, i: int, p: dict[str, float]) -> float:
    """Drag with the cube of the speed."""
    return -p["F"] * (float(s.through[i]) / p["u"]) ** 3


def burst(s: Moving, i: int, p: dict[str, float]) -> float:
    """An oscillation that begins in the middle of the run and ends 15 s later."""
    inside = p["start_s"] < s.time_s < p["start_s"] + 15.0
    return p["F"] * np.sin(p["rad_s"] * s.time_s + p["phase"]) * inside


def ripple(s: Moving, i: int, p: dict[str, float]) -> float:
    """A force that changes with the place, or with the attitude."""
    return p["F"] * float(np.sin(4.0 * s.away[i] + p["phase"]) - np.sin(p["phase"]))


def hunting(s: Moving, i: int, p: dict[str, float]) -> float:
    """A force that switches to and fro."""
    return p["F"] * float(np.sign(np.sin(p["rad_s"] * s.time_s + p["phase"])))


def crossed(s: Moving, i: int, p: dict[str, float]) -> float:
    """Drag that another motion brings about: with the speed of turning, or ahead where the axis turns."""
    other = s.through[5] / 0.3 if i < 3 else s.through[0] / 0.4
    return -p["F"] * float(abs(other) * s.through[i]) / p["u"]


FAMILIES = {"cubic": cubic, "burst": burst, "ripple": ripple, "hunting": hunting, "crossed": crossed}
