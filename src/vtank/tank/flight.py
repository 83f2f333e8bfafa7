"""A whole vehicle under way, step by step: what it measures, what effects push it, and whether it still can go on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..plant.vehicle import Vehicle
from ..water.installation import installed
from ..water.record import field
from .instruments import measured
from .mjcf import mujoco_says
from .model import HEARD, TANK_GROUP, vehicle_body
from .places.effect import Moving, Placed
from .places.laws import water_velocity

Array = NDArray[np.float64]
SMALLEST_M = 1e-6  # [m] from the origin of a corner that tells a direction; a choice
FARTHEST = 1e6  # [SI] of any measurement, beyond which a flight has diverged; a choice


class Flight:
    """A flight of a number of steps from where the vehicle floats, to be advanced inside `tank.forces()`.

    Attributes:
        done: steps that are behind it.
        ended: why it can go no further, "" while it can: it has struck something.
        depths_m: least and greatest depth of its origin so far [m].
        above_s: when its origin first was above the surface; None where it never was [s].
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        vehicle: Vehicle,
        effects: Sequence[Placed],
        steps: int,
        velocity: Sequence[float] | Array = (0.0,) * 6,
    ) -> None:
        """model, vehicle, effects: of a `Whole`. velocity: at the start, body axes, shape (6,) [m/s, rad/s]."""
        self.done, self.ended, self.vehicle, self.effects = 0, "", vehicle, effects
        self.model, self.data = model, mujoco.MjData(model)
        self._gears = {t.name: gear for t, gear in zip(vehicle.thrusters, model.actuator_gear, strict=False)}
        self.body = vehicle_body(self.model)
        self.dof = self.model.body_dofadr[self.body]
        self.sensordata = np.full((steps, self.model.nsensordata), np.nan)
        self.acting: Mapping[str, float] = {}
        self._memory: dict[str, float] = {}
        self._heading = 0.0
        mujoco.mj_kinematics(self.model, self.data)
        turn = self.data.xmat[self.body].reshape(3, 3)
        self.data.qvel[self.dof : self.dof + 6] = np.concatenate([turn @ velocity[:3], velocity[3:]])
        self._start = self.data.xpos[self.body].copy()
        self.depths_m, self.above_s = (-float(self._start[2]),) * 2, None if self._start[2] <= 0.0 else 0.0
        self._corners = corners(self.model, self.body)
        around = self.model.body_rootid[self.model.geom_bodyid] != self.body
        pushed = any(placed.effect.wrench for placed in effects)
        callbacks = {"passive": self._push} if pushed else {}
        self._callbacks = lambda: callbacks
        self._heavier = [placed for placed in effects if placed.effect.heavier]
        self._added = field(model.body_user[self.body], "added_mass")
        self._nominal_kg = float(self._added[0, 0])
        self._walled = bool((self.model.geom_group[around] == TANK_GROUP).any())

    @property
    def step_s(self) -> float:
        """Time step [s]."""
        return float(self.model.opt.timestep)

    def times(self, steps: int) -> Array:
        """Times of the first steps, shape (steps,) [s]."""
        return self.step_s * np.arange(steps, dtype=np.float64)

    def advance(self, control: Array, acting: Mapping[str, Array] | None = None) -> None:
        """Step under a row of controls for each step, (n, nu), unless it has ended; acting: inputs, (n,) by thruster.

        InputError where the motion diverges.
        """
        with mujoco_says("cannot step it"), installed(self._callbacks):
            try:
                self._advance(control, acting or {})
            finally:
                self._added[0, 0] = self._nominal_kg

    def _advance(self, control: Array, acting: Mapping[str, Array]) -> None:
        for row, ctrl in enumerate(control):
            if self.ended:
                return
            if self._heavier:
                self._added[0, 0] = self._nominal_kg + self._more_kg()
            self.acting = {name: float(values[row]) for name, values in acting.items()}
            self.data.ctrl[:] = ctrl
            mujoco.mj_step(self.model, self.data)
            self._keep()

    def now(self) -> None:
        """Have the sensors measure at this instant, before the step that begins here."""
        if self.done < len(self.sensordata):
            with installed(self._callbacks):
                mujoco.mj_forward(self.model, self.data)
            self.sensordata[self.done] = self.data.sensordata

    def true(self, rows: slice, name: str = "") -> dict[str, Mapping[str, Array]]:
        """Each instrument's channels, or one's, free of error, at some steps: (n,) by its name and theirs [SI]."""
        return measured(self.model, self.vehicle.sensors, self.sensordata[rows], name)

    def _more_kg(self) -> float:
        """Added mass in surge that effects bring [kg]."""
        mujoco.mj_kinematics(self.model, self.data)
        moving = self._moving(self.data)
        return sum(placed.effect.heavier(moving, placed.values) for placed in self._heavier if placed.effect.heavier)

    def _keep(self) -> None:
        """What was measured at the beginning of the step; whether the vehicle is still where it may be."""
        row = self.data.sensordata
        if not (np.abs(row) < FARTHEST).all() or not (np.abs(self.data.qvel) < FARTHEST).all():
            raise InputError(
                f"{self.vehicle.path}: the motion diverged after {self.done * self.step_s:.4g} s; its numbers or "
                f"commands are out of range, or the time step of {self.step_s:g} s is too long for them"
            )
        self.sensordata[self.done] = row
        self.done += 1
        depth_m = -float(self.data.xpos[self.body, 2])
        self.depths_m = min(depth_m, self.depths_m[0]), max(depth_m, self.depths_m[1])
        if depth_m < 0.0 and self.above_s is None:
            self.above_s = self.done * self.step_s
        if self.effects:
            moving = self._moving(self.data)
            for placed in self.effects:
                if placed.effect.keep:
                    self._memory[placed.name] = placed.effect.keep(moving, placed.place, placed.values)
        if self._walled and (struck := self._struck()):
            self.ended = f"strikes {struck}"

    def _struck(self) -> str:
        """Name of the wall that the box around the hull reaches, "" for none."""
        place, turn = self.data.xpos[self.body], self.data.xmat[self.body].reshape(3, 3)
        geom = np.zeros(1, dtype=np.int32)
        for corner in self._corners:
            distance = mujoco.mj_ray(self.model, self.data, place, turn @ corner, HEARD, 1, -1, geom)
            if 0.0 <= distance <= 1.0:
                return f"'{self.model.geom(int(geom[0])).name or 'a wall'}'"
        return ""

    def _moving(self, data: mujoco.MjData) -> Moving:
        user, turn, place = self.model.body_user, data.xmat[self.body].reshape(3, 3), data.xpos[self.body]
        moving = Moving(
            time_s=data.time,
            step_s=self.step_s,
            vehicle=self.vehicle,
            turn=turn,
            velocity=data.qvel[self.dof : self.dof + 6],
            displaced=place - self._start,
            water=lambda: water_velocity(user[self.body], user[0], data.time, place, turn),
            last_heading=self._heading,
            gears=self._gears,
            asked=self.acting,
            ahead=lambda: self._ahead(data, place, turn),
            memory=self._memory,
        )
        self._heading = moving.heading
        return moving

    def _ahead(self, data: mujoco.MjData, place: Array, turn: Array) -> float:
        """Distance from the origin along the body's x to the wall [m]."""
        geom = np.zeros(1, dtype=np.int32)
        distance = float(mujoco.mj_ray(self.model, data, place, turn[:, 0].copy(), HEARD, 1, -1, geom))
        return distance if distance >= 0.0 else np.inf

    def _push(self, model: Any, data: mujoco.MjData) -> None:
        """MuJoCo's passive callback: the forces of effects, in every Runge-Kutta stage."""
        moving = self._moving(data)
        wrench = np.sum([p.effect.wrench(moving, p.place, p.values) for p in self.effects if p.effect.wrench], axis=0)
        turn, passive = data.xmat[self.body].reshape(3, 3), data.qfrc_passive
        passive[self.dof : self.dof + 3] += turn @ wrench[:3]
        passive[self.dof + 3 : self.dof + 6] += wrench[3:]


def corners(model: mujoco.MjModel, body: int) -> Array:
    """Corners of the box around all shapes and sites of the vehicle, and the middles of its faces, (K, 3) [m].

    Those at its origin are left out: MuJoCo ends the process over a ray without a direction.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    place, turn = data.xpos[body], data.xmat[body].reshape(3, 3)
    sites = np.flatnonzero(model.body_rootid[model.site_bodyid] == body)
    points = list((data.site_xpos[sites] - place) @ turn)
    signs = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    for i in np.flatnonzero(model.body_rootid[model.geom_bodyid] == body):
        shape = data.geom_xmat[i].reshape(3, 3) @ (model.geom_aabb[i, :3] + signs * model.geom_aabb[i, 3:]).T
        points += list((turn.T @ (data.geom_xpos[i][:, None] + shape - place[:, None])).T)
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    middle, half = 0.5 * (high + low), 0.5 * (high - low)
    faces = np.concatenate([np.eye(3), -np.eye(3)])
    box = middle + np.concatenate([signs, faces]) * half
    return np.asarray(box[np.linalg.norm(box, axis=1) > SMALLEST_M])
