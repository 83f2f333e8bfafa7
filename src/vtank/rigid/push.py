"""What pushes a whole vehicle: a thruster under its recorded input, or a recorded component of the wrench."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..plant.actuators import Thruster
from ..plant.vehicle import Vehicle
from ..record.columns import WRENCH
from ..record.run import INPUTS

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
POINTS = 4001  # of the table of steady force over input: a parabola within 1e-7 of its end; a choice


@dataclass(frozen=True)
class Push:
    """A force along a direction at a place, and a couple for each newton of it.

    Attributes:
        name: of the thruster, or the column of the wrench.
        column: of its input in a recording.
        direction, place_m, couple: body axes [-, m, m].
        lag_s: of the force behind the input [s].
        thruster: whose law turns input into force; None where the input is the force.
    """

    name: str
    column: str
    direction: Vector
    place_m: Vector = (0.0, 0.0, 0.0)
    couple: Vector = (0.0, 0.0, 0.0)
    lag_s: float = 0.0
    thruster: Thruster | None = None

    @property
    def kind(self) -> str:
        """Of its input: how its column ends."""
        return self.column.rpartition("_")[2]

    @property
    def unit(self) -> str:
        """Of its input."""
        return {"command": "-", "N": "N"}.get(self.kind, "N" if self.thruster is None else "rev/s")

    def table(self, reach: float) -> Array:
        """Steady force [N] over inputs from -reach to reach, shape (POINTS,)."""
        asked = np.linspace(-reach, reach, POINTS)
        return asked if self.thruster is None else self.thruster.force_N(asked)


def pushes(vehicle: Vehicle, columns: Iterable[str]) -> tuple[Push, ...]:
    """All that pushes the vehicle in recordings with these columns; InputError where nothing does.

    A thruster is driven by its own input, else by its measured force NAME_N, else by the one input of a single-axis
    run where it is a propeller. Where no thruster has a column, the recorded wrench pushes.
    """
    columns = set(columns)
    found = [push for t in vehicle.thrusters if (push := _thruster(vehicle, t, columns))]
    if found:
        return tuple(found)
    for i, name in enumerate(WRENCH):
        if name in columns:
            along, about = ((1.0 if i == k else 0.0 for k in range(first, first + 3)) for first in (0, 3))
            found.append(Push(name, name, tuple(along), couple=tuple(about)))  # type: ignore[arg-type]
    if "thrust_N" in columns:
        found.append(Push("thrust_N", "thrust_N", (1.0, 0.0, 0.0)))
    fins = [fin.column for fin in vehicle.fins if fin.column in columns]
    if not found and not fins:
        wanted = ", ".join([*(t.column for t in vehicle.thrusters), *WRENCH])
        raise InputError(f"no input of {vehicle.name} was recorded; expected at least one of {wanted}")
    return tuple(found)


def _thruster(vehicle: Vehicle, thruster: Thruster, columns: set[str]) -> Push | None:
    name = thruster.name
    where = vehicle.sites[thruster.site]
    own = Push(name, thruster.column, thruster.direction, where, lag_s=thruster.lag_s, thruster=thruster)
    if thruster.column in columns:
        return own
    if f"{name}_N" in columns:
        return Push(name, f"{name}_N", thruster.direction, where)
    single = {"rev_s": "n_rev_s", "command": "command", "N": "thrust_N"}[thruster.input]
    if thruster.site in vehicle.propeller_sites and single in columns and single in INPUTS[:2]:
        return Push(name, single, thruster.direction, where, lag_s=thruster.lag_s, thruster=thruster)
    return None
