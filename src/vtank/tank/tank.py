"""The tank: N simulations of one vehicle in MuJoCo, each with its own surge parameters and inputs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import mujoco
import mujoco.batch
import numpy as np

from ..errors import InputError
from ..plant.vehicle import Vehicle
from ..water.installation import present
from ..water.record import field as wet_field
from .callbacks import callbacks
from .layout import SURGE, field
from .model import rigid_mass, vehicle_body
from .prepare import check_parameters, forces, prepare
from .rays import Walls


class Diverged(InputError):
    """A simulation ran away; `number` is its place in the tank."""

    def __init__(self, number: int, message: str) -> None:
        super().__init__(message)
        self.number = number


class Tank:
    """N simulations, stepped on `nthread` threads; results do not depend on their number.

    The tank is a context manager: it steps inside `with tank:` only, where MuJoCo's control callback is installed.
    All arrays are live views of the simulations' state; what is written to them holds from the next step.

    Attributes:
        qpos: pose, shape (N, 7): position of the body's origin [m] and quaternion, world axes (x ahead, z up).
        qvel: velocity, shape (N, 6): linear in world axes [m/s], angular in body axes [rad/s].
        lag: shape (N, 2): lagged thrust per unit of moving mass [m/s2], wake [m/s].
        time: shape (N,) [s].
        propeller_rev_s: input, shape (N,): speed of both stern propellers [rev/s].
        tunnel_N: input, shape (N, K): force of each thruster of the vehicle, in its order [N].
        disturbance_m_s2: input, shape (N,): surge acceleration by turbulence [m/s2].
        parameters: shape (N, P): parameter vectors of the surge equation.
        sonar_m, wall_m: shape (N, 3) and (N,): where the sonar is, and world x of the wall ahead of it [m].
        mass: M_RB + M_A of the vehicle, shape (6, 6) [kg, kg m, kg m2].
        wrenches: of each thruster at 1 N, shape (K, 6) [N, N m].
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        vehicle: Vehicle,
        truths: np.ndarray,
        nthread: int = 1,
        held: Sequence[str] = (),
    ) -> None:
        """`truths`: parameter vectors, shape (N, P), or (P,) for one; `held`: as for `prepare`."""
        truths = np.atleast_2d(truths)
        self.mass = rigid_mass(model, vehicle_body(model)) + vehicle.added_mass
        self.model, self.vehicle = (model := prepare(model, vehicle, truths[0], held)), vehicle
        self.batch = mujoco.batch.Batch(model, len(truths), nthread=nthread)
        self._walls = Walls(model)
        body, first = vehicle_body(model), model.actuator(SURGE).id
        law, self._wet = self.batch.expand("actuator_user")[:, first], self.batch.expand("body_user")[:, body]
        self.parameters, self.disturbance_m_s2 = field(law, "parameters"), field(law, "disturbance_m_s2")
        self.sonar_m, self.wall_m = field(law, "sonar_m"), field(law, "wall_m")
        for p in truths:
            check_parameters(model, p)
        self.parameters[:] = truths
        lag = int(model.actuator_actadr[first])
        pose, dof = int(model.jnt_qposadr[model.body_jntadr[body]]), int(model.body_dofadr[body])
        self.qpos = self.batch.bind("qpos")[:, pose : pose + 7]
        self.qvel = self.batch.bind("qvel")[:, dof : dof + 6]
        self.lag = self.batch.bind("act")[:, lag : lag + 2]
        self.time = self.batch.bind("time")
        control, thrusters = self.batch.bind("ctrl"), slice(first + 1, first + 1 + len(vehicle.steering))
        self.propeller_rev_s, self.tunnel_N = control[:, first], control[:, thrusters]
        self.wrenches = model.actuator_gear[thrusters].copy()
        self._warnings = self.batch.warning[:, :, 1]  # how often MuJoCo has warned of each kind
        self._warnings[:] = 1  # it writes the first of each to a log file
        self._context: list[Any] = []
        self._start = self.batch.state.copy()

    def __enter__(self) -> Self:
        self._context.append(forces())
        self._context[-1].__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self._context.pop().__exit__(*error)

    def step(self, nstep: int = 1) -> None:
        """Advance every simulation by nstep time steps; InputError when one of them diverges."""
        if any(present(kind) is not ours for kind, ours in callbacks().items()):
            raise RuntimeError("the tank's forces are not installed: step inside `with tank:`")
        self.batch.step(nstep=nstep)
        # a number beyond MuJoCo's limit is warned of and left out
        if (self._warnings != 1).any() or not np.isfinite(self.qvel).all():
            lost = (self._warnings != 1).any(axis=1) | ~np.isfinite(self.qvel).all(axis=1)
            step_s, number = self.model.opt.timestep, int(lost.argmax())
            last_s = max(self.time[number] - nstep * step_s, 0.0)
            raise Diverged(
                number,
                f"simulation {number} of {len(self.time)} diverged after {last_s:.4g} s; its parameters or inputs are "
                f"out of range, or the time step of {step_s:g} s is too long for them",
            )

    def reset(self) -> None:
        """Put every simulation back to the start: pose, at rest, time 0, still water, inputs 0; parameters stay."""
        self.batch.state[:] = self._start
        self.disturbance_m_s2[:] = 0.0
        self.set_water(np.zeros(3))
        self._warnings[:] = 1

    def set_water(self, velocity_m_s: np.ndarray, acceleration_m_s2: np.ndarray | float = 0.0) -> None:
        """Let the water move uniformly from now on; both broadcast to (N, 3), world axes. Null: still water."""
        wet_field(self._wet, "water_m_s")[:] = velocity_m_s
        wet_field(self._wet, "water_m_s2")[:] = acceleration_m_s2
        wet_field(self._wet, "water_since_s")[:] = self.time

    def ray(self, points: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Distances from points along directions to walls and floor, shape (N, K) [m]; inf where there is nothing.

        Args:
            points: world axes, broadcast to (N, K, 3) [m].
            directions: unit vectors in world axes, broadcast to (N, K, 3).
        """
        return self._walls.distances(points, directions, len(self.time))
