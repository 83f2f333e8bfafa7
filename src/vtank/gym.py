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
from .plant.truth import load_truth
from .plant.vehicle import load_vehicle
from .resources import models_dir
from .tank import forces, load_world, prepare
from .tank.model import vehicle_body

Array = NDArray[np.float64]
PERIOD_S = 0.1  # [s] between actions; a choice
EPISODE_STEPS = 600  # one minute; a choice
FULL_REV_S = 15.0  # [rev/s] propeller speed at full command, what the paper's experiments reach; a choice
NEAR_M = np.array([0.6, 0.4, 0.3])  # [m] how far the goal is from the start at most, ahead, aside and down; a choice
LOST_M = 2.0  # [m] from the goal, where an episode ends; a choice
LIMITS = np.repeat([10.0, np.pi, 10.0, 10.0], 3)  # of what is observed, far beyond what a vehicle reaches; a choice
EFFORT = 0.01  # what a full command costs, in metres of distance; a choice


class Tank(gymnasium.Env[Array, Array]):
    """A vehicle of vtank before the walls of the test tank, all six degrees of freedom free.

    Action, shape (1 + K,), -1 to 1: share of full propeller speed, and of each thruster's largest force in the order of
    the vehicle file. Observation, shape (12,): from vehicle to goal in the vehicle's axes [m]; roll, pitch, yaw [rad];
    linear [m/s] and angular velocity [rad/s] in the vehicle's axes. Reward of a step: less the distance [m], less the
    mean square of the action times 0.01. An episode ends 2 m from the goal and is cut off after one minute.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, vehicle: str = "phoenix", truth: str = "paper-ii") -> None:
        """`vehicle`, `truth`: names or paths of a vehicle file and of surge parameters; InputError as they."""
        self.vehicle = load_vehicle(vehicle)
        model = load_world(self.vehicle, models_dir() / "basin.xml", PERIOD_S)
        self.model = prepare(model, self.vehicle, load_truth(truth).vector())
        self.data = mujoco.MjData(self.model)
        self.body = vehicle_body(self.model)
        self.steps = round(PERIOD_S / self.model.opt.timestep)
        self.full = np.array([FULL_REV_S, *(thruster.limit_N for thruster in self.vehicle.steering)])
        self.goal = np.zeros(3)
        self.action_space = spaces.Box(-1.0, 1.0, (1 + len(self.vehicle.steering),), np.float64)
        self.observation_space = spaces.Box(-LIMITS, LIMITS, dtype=np.float64)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """At rest where the vehicle floats, with a goal near by."""
        super().reset(seed=seed)
        mujoco.mj_resetData(self.model, self.data)
        self.goal = self.model.body(self.body).pos + NEAR_M * self.np_random.uniform(-1.0, 1.0, 3)
        with forces():
            mujoco.mj_forward(self.model, self.data)
        return self._observation(), {}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """One period of 0.1 s under a held action."""
        asked = np.clip(np.asarray(action, dtype=float), -1.0, 1.0)
        self.data.ctrl[: self.full.size] = self.full * asked
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


gymnasium.register(id="vtank/Tank-v0", entry_point=Tank, max_episode_steps=EPISODE_STEPS)
