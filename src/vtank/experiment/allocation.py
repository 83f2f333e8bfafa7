"""Which thrusters and fins make a wanted force, and how much of it they can.

Of all ways to make the forces along the axes that are ordered, it is the one that makes least along the others, and of
these the one with the least effort. Thrusters push and turn; fins turn only, and better the faster the hull goes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from ..plant.actuators import Fin, Thruster
from ..plant.vehicle import AXES, Vehicle

Array = NDArray[np.float64]
REACH = 1e-6  # share of a wanted force that may be missing, by rounding; a choice
RANK = 1e-6  # of the largest singular value, below which there is no force; a choice
TURNS = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])  # of a fin only the moment is asked for: its push comes with it
SLOWEST_M_S = 0.3  # [m/s] speed below which fins are not asked for more; a choice


class Allocation:
    """Of the thrusters and fins of one vehicle to the axes of AXES that are ordered.

    Attributes:
        inertia: mass or moment of inertia of each axis, added mass included, shape (6,) [kg, kg m2].
        parts: thrusters, then the fins that move.
        fins: wrench of all fins, fixed ones too, per angle and square of the speed, shape (6,) [kg/m, kg].
    """

    def __init__(self, vehicle: Vehicle, model: Any, axes: Sequence[str]) -> None:
        """model: of `tank.load_whole`, for this vehicle."""
        from ..tank.model import rigid_mass, vehicle_body  # MuJoCo takes a while to load

        self.inertia: Array = np.diag(rigid_mass(model, vehicle_body(model)) + vehicle.added_mass).copy()
        self._ordered = np.array([AXES.index(axis) for axis in axes], dtype=int)
        gears, count = model.actuator_gear, len(vehicle.thrusters)
        moving = [(i, fin) for i, fin in enumerate(vehicle.fins) if fin.limit_rad]
        self.parts: tuple[Thruster | Fin, ...] = (*vehicle.thrusters, *(fin for _, fin in moving))
        pushes = [gear * t.limit_N for gear, t in zip(gears[:count], vehicle.thrusters, strict=True)]
        self._pushes = np.array(pushes).reshape(-1, 6)
        lifts = [_lift(gears[count + 2 * i + 1], fin) for i, fin in enumerate(vehicle.fins)]
        self.fins: Array = np.sum([*lifts, np.zeros(6)], axis=0)
        self._turns = np.array([lifts[i] * TURNS * fin.limit_rad for i, fin in moving]).reshape(-1, 6)
        self.limits = np.array([t.limit_N for t in vehicle.thrusters] + [fin.limit_rad for _, fin in moving])
        self._known: dict[float, Array] = {}

    def matrix(self, surge_m_s: float) -> Array:
        """What each part has to do per wanted force or moment, at a speed ahead: shape (parts, 6) [N or rad]."""
        speed = max(surge_m_s, SLOWEST_M_S) if self._turns.size else 0.0
        if speed not in self._known:
            self._known = {speed: self._solved(speed)}
        return self._known[speed]

    def able(self, axis: str, surge_m_s: float = 1.0) -> bool:
        """Whether the force along one of the ordered axes can be made without one along the others of them.

        surge_m_s: speed ahead, without which fins turn nothing.
        """
        one = np.eye(6)[AXES.index(axis)]
        made = self._wrenches(surge_m_s) @ (self.matrix(surge_m_s) @ one / self.limits)
        return bool(np.abs((made - one)[self._ordered]).max() < REACH)

    def steers(self, axis: str) -> bool:
        """Whether fins turn the vehicle about an axis."""
        return bool(self._turns[:, AXES.index(axis)].any())

    def largest(self, axis: str, surge_m_s: float) -> float:
        """The largest force or moment along an axis that all parts can make, either way [N or N m]."""
        efforts = self.matrix(surge_m_s)[:, AXES.index(axis)]
        most = max(self.overload(efforts), self.overload(-efforts))
        return 1.0 / most if most else 0.0

    def sense(self, target: str) -> float:
        """1 where a positive force or input turns the bow to starboard, -1 where to port."""
        if target in AXES:
            return 1.0
        wrenches = np.concatenate([self._pushes, self._turns])
        turns = {part.column: wrench[5] for part, wrench in zip(self.parts, wrenches, strict=True)}
        return 1.0 if turns[target] > 0.0 else -1.0

    def overload(self, efforts: Array) -> float:
        """The largest of forces and angles over what the part can do that way: 1 at its limit.

        A thruster that pushes one way only gives nothing the other way, and stops nobody else.
        """
        most = self._most(efforts)
        return float(np.max(np.abs(efforts[most > 0.0]) / most[most > 0.0], initial=0.0))

    def room(self, efforts: Array, more: Array) -> float:
        """The largest share, up to 1, of further forces and angles that the parts can do beside `efforts`."""
        most = self._most(more)
        asked = (most > 0.0) & (np.abs(more) > REACH * most)
        free = most[asked] - efforts[asked] * np.sign(more[asked])
        return float(np.clip(np.min(free / np.abs(more[asked]), initial=1.0), 0.0, 1.0))

    def _most(self, way: Array) -> Array:
        """What each part can do the way that a number points, shape (parts,) [N or rad]."""
        pairs = zip(self.parts, np.where(way > 0.0, 1.0, -1.0).tolist(), strict=True)
        return np.array([part.limit_rad if isinstance(part, Fin) else part.most_N(side) for part, side in pairs])

    def inputs(self, efforts: Array) -> dict[str, Array]:
        """Inputs of thrusters [rev/s, -, N] and fins [rad] by column, (T,), for forces and angles, (T, parts).

        Parts that the ordered axes do not need are left out.
        """
        needed = [any(matrix[i].any() for matrix in self._known.values()) for i in range(len(self.parts))]
        parts = [(p, effort) for p, effort, used in zip(self.parts, efforts.T, needed, strict=True) if used]
        return {p.column: effort if isinstance(p, Fin) else p.input_for(effort) for p, effort in parts}

    def _wrenches(self, speed: float) -> Array:
        """Wrench of each part at its limit, shape (6, parts) [N, N m]."""
        return np.concatenate([self._pushes, self._turns * speed**2]).T

    def _solved(self, speed: float) -> Array:
        unit = self._wrenches(speed) / self.inertia[:, None]  # as accelerations, so that axes can be compared
        others = np.setdiff1d(np.arange(6), self._ordered)
        if not unit[self._ordered].size:  # which LAPACK does not take
            return np.zeros((len(self.parts), 6))
        least, free = np.linalg.pinv(unit[self._ordered], RANK), null_space(unit[self._ordered], RANK)
        if free.size:
            least = least - free @ np.linalg.pinv(unit[others] @ free, RANK) @ unit[others] @ least
        least[np.abs(least) < RANK**2 * np.abs(least).max(initial=0.0)] = 0.0  # rounding is no order to a thruster
        matrix = np.zeros((len(self.parts), 6))
        matrix[:, self._ordered] = self.limits[:, None] * least / self.inertia[self._ordered]
        return matrix


def _lift(gear: Array, fin: Fin) -> Array:
    """Wrench of a fin's lift per angle and square of the speed, shape (6,)."""
    return np.asarray(0.5 * fin.density_kg_per_m3 * fin.area_m2 * fin.lift_per_rad * gear, dtype=np.float64)


def able(vehicle: Vehicle) -> tuple[str, ...]:
    """The axes of AXES that a vehicle can push by itself."""
    from ..tank.whole import load_whole  # MuJoCo takes a while to load

    model = load_whole(vehicle).model
    return tuple(axis for axis in AXES if Allocation(vehicle, model, [axis]).able(axis))
