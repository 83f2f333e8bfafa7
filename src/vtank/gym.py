"""The tank as a Gymnasium environment: import vtank.gym, then gymnasium.make("vtank/Tank-v0").

A vehicle in still water is to go to a place near by and stay there. Needs gymnasium: pip install 'vtank[gym]'.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import mujoco
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from .experiment.hold import attitude
from .plant.actuators import Fin, Thruster
from .plant.vehicle import load_vehicle
from .resources import models_dir
from .tank import forces, load_whole
from .tank.model import vehicle_body

Array = NDArray[np.float64]
PERIOD_S = 0.1  # [s] between actions; a choice
EPISODE_STEPS = 600  # one minute; a choice
NEAR_M = np.array([0.6, 0.4, 0.3])  # [m] how far the goal is from the start at most, ahead, aside and down; a choice
LOST_M = 2.0  # [m] from the goal, where an episode ends; a choice
LIMITS = np.repeat([10.0, np.pi, 10.0, 10.0], 3)  # of what is observed, far beyond what a vehicle reaches; a choice
EFFORT = 0.01  # what a full command costs, in metres of distance; a choice


class Tank(gymnasium.Env[Array, Array]):
    """A whole vehicle of vtank within the walls of the test tank, as `vtank run` flies it.

    Action, shape (K,), -1 to 1: share of the largest force that way of each thruster, then of the largest angle of each
    fin that moves, in the order of the vehicle file. Observation, shape (12,): from vehicle to goal in the vehicle's
    axes [m]; roll, pitch, yaw [rad]; linear [m/s] and angular velocity [rad/s] in the vehicle's axes. Reward of a step:
    less the distance [m], less the mean square of the action times 0.01. An episode ends 2 m from the goal and is cut
    off after one minute.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, vehicle: str = "phoenix") -> None:
        """`vehicle`: name or path of a vehicle file; InputError as `vtank.load_vehicle`."""
        self.vehicle = load_vehicle(vehicle)
        self.whole = load_whole(self.vehicle, models_dir() / "basin.xml")
        self.model = self.whole.model
        self.data = mujoco.MjData(self.model)
        self.body = vehicle_body(self.model)
        self.steps = round(PERIOD_S / self.model.opt.timestep)
        self.parts: tuple[Thruster | Fin, ...] = (
            *self.vehicle.thrusters,
            *(fin for fin in self.vehicle.fins if fin.limit_rad),
        )
        self.goal = np.zeros(3)
        self.action_space = spaces.Box(-1.0, 1.0, (len(self.parts),), np.float64)
        self.observation_space = spaces.Box(-LIMITS, LIMITS, dtype=np.float64)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """At rest where the vehicle floats, with a goal near by."""
        super().reset(seed=seed)
        mujoco.mj_resetData(self.model, self.data)
        near = NEAR_M * ((1.0, 1.0, 0.0) if self.vehicle.heave_N_per_m else (1.0, 1.0, 1.0))  # one afloat stays there
        self.goal = self.model.body(self.body).pos + near * self.np_random.uniform(-1.0, 1.0, 3)
        with forces():
            mujoco.mj_forward(self.model, self.data)
        return self._observation(), {}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """One period of 0.1 s under a held action."""
        asked = np.clip(np.asarray(action, dtype=float), -1.0, 1.0)
        inputs = {part.column: _input(part, share) for part, share in zip(self.parts, asked, strict=True)}
        self.data.ctrl[:] = self.whole.control(inputs)[0]
        with forces():
            mujoco.mj_step(self.model, self.data, self.steps)
            mujoco.mj_forward(self.model, self.data)
        seen = self._observation()
        distance = float(np.linalg.norm(seen[:3]))
        reward = -distance - EFFORT * float(np.mean(asked**2))
        return seen, reward, distance > LOST_M, False, {"distance_m": distance}

    def _observation(self) -> Array:
        turn, quaternion = self.data.xmat[self.body].reshape(3, 3), self.data.xquat[self.body]
        velocity = np.concatenate([turn.T @ self.data.qvel[:3], self.data.qvel[3:6]])
        return np.concatenate([turn.T @ (self.goal - self.data.xpos[self.body]), attitude(quaternion), velocity])


def _input(part: Thruster | Fin, share: float) -> Array:
    """Input of a thruster, or angle of a fin, for a share of the most that it can, shape (1,)."""
    if isinstance(part, Fin):
        return np.array([share * part.limit_rad])
    return part.input_for(np.array([share * part.most_N(1.0 if share > 0.0 else -1.0)]))


gymnasium.register(id="vtank/Tank-v0", entry_point=Tank, max_episode_steps=EPISODE_STEPS)
