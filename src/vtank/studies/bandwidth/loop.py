"""The linear model of the surge loop: range filter, controller and vehicle, exact at the ticks.

Left out is everything that is not linear: quadratic drag, thrust loss, the propellers' limit, and the controller's
blunting about zero, so that thrust per unit of moving mass is (beta/beta_c) times the demand, beta_c being what the
controller takes for beta. What is left (lag, linear drag, filter, hold between ticks) is solved exactly: a sinusoid at
the ticks meets transfer functions in z = exp(i w h), as in Astrom and Wittenmark, Computer-Controlled Systems (1997).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from ...experiment import Plan, steady_state, transition
from ...plant import BETA, LINEAR_DRAG, TAU

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Loop:
    """The linear loop of one plan."""

    plan: Plan

    @property
    def ratio(self) -> float:
        """Thrust per moving mass that a demand makes, over the demand: beta/beta_c."""
        return float(self.plan.p[BETA]) / self.plan.thrust_m_per_rev2

    def filter_step(self) -> tuple[Array, Array]:
        """(keep, gain) of the range filter in the steady state: s_k = keep s_(k-1) + gain x_k, shapes (3, 3), (3,)."""
        s = self.plan.scenario
        gain, _ = steady_state(s.period_s, s.filter.q_m2_per_s5, s.filter.r_m2)
        ahead = transition(s.period_s)
        return ahead - np.outer(gain, ahead[0]), gain

    def vehicle_step(self) -> tuple[Array, Array]:
        """(step, drive) from tick to tick of (x, u, z), or (x, u) without lag: exact, the thrust being held."""
        tau = self.plan.p[TAU]
        drag = self.plan.p[LINEAR_DRAG]
        rates = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, -drag, 1.0, 0.0], [0.0, 0.0, -1.0, 1.0], [0.0, 0.0, 0.0, 0.0]])
        if tau > 0.0:
            rates[2] /= tau
        else:  # the held thrust, last of the states, acts at once
            rates = rates[[0, 1, 3], :3]
        held = expm(rates * self.plan.scenario.period_s)
        return held[:-1, :-1], held[:-1, -1]

    def stable(self) -> bool:
        """Whether the loop comes to rest by itself; where it does not, its response says nothing about a motion."""
        (step, drive), (keep, gain) = self.vehicle_step(), self.filter_step()
        gains = self.plan.scenario.control
        estimate = np.hstack([np.outer(gain, np.eye(drive.size)[0]), keep])  # s_k of (vehicle_k, s_(k-1))
        demand = -np.array([gains.position_per_s2, gains.speed_per_s, 0.0]) @ estimate
        ahead = np.hstack([step, np.zeros((drive.size, 3))]) + self.ratio * np.outer(drive, demand)
        return bool(np.abs(np.linalg.eigvals(np.vstack([ahead, estimate]))).max() < 1.0)

    def turn(self, rad_s: Array) -> Complex:
        """z = exp(i w h), the turn of a sinusoid from tick to tick, shape (W, 1, 1)."""
        return np.asarray(np.exp(1j * np.atleast_1d(rad_s) * self.plan.scenario.period_s)[:, None, None])

    def estimate(self, rad_s: Array) -> Complex:
        """Filtered position and rate for a unit position, shape (2, W) [1, 1/s]."""
        keep, gain = self.filter_step()
        return np.asarray(np.linalg.solve(np.eye(3) - keep / self.turn(rad_s), gain)[:, :2].T, dtype=np.complex128)

    def vehicle(self, rad_s: Array) -> Complex:
        """Position for a unit of commanded thrust per moving mass held between ticks, shape (W,) [s2]."""
        step, drive = self.vehicle_step()
        moved = np.linalg.solve(self.turn(rad_s) * np.eye(drive.size) - step, drive)
        return np.asarray(moved[:, 0], dtype=np.complex128)

    def controller(self, rad_s: Array) -> tuple[Complex, Complex]:
        """Demand [m/s2] for a unit of command, and for a unit of position, shape (W,) each [1/s2]."""
        gains = self.plan.scenario.control
        command = gains.position_per_s2 + 1j * np.atleast_1d(rad_s) * gains.speed_per_s
        position, rate = self.estimate(rad_s)
        feedback = -(gains.position_per_s2 * position + gains.speed_per_s * rate)
        return np.asarray(command, dtype=np.complex128), np.asarray(feedback, dtype=np.complex128)

    def response(self, rad_s: Array) -> Complex:
        """Position over commanded position, shape (W,)."""
        command, feedback = self.controller(rad_s)
        forward = self.vehicle(rad_s) * self.ratio
        return np.asarray(forward * command / (1.0 - forward * feedback))
