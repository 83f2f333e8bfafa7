"""A full six-axis motion against Fossen's equations, written out anew in numpy and integrated by DOP853."""

from __future__ import annotations

import numpy as np
import pytest
from bodies import (
    BUOYANCY_CENTRE,
    GRAVITY_CENTRE,
    INERTIA,
    MASS,
    G,
    awkward_model,
    awkward_vehicle,
    body_velocity,
    phoenix,
    rigid_mass,
    rotation,
    set_velocity,
    skew,
    symmetric_mass,
    without_drag,
)
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from vtank.plant.truth import load_truth
from vtank.plant.vehicle import Vehicle
from vtank.tank import Tank

Array = NDArray[np.float64]


class Fossen:
    """M dnu/dt + C_RB(nu) nu + C_A(nu) nu + D(nu) nu + g = tau, Fossen (2011) chapters 3, 4 and 6."""

    def __init__(self, vehicle: Vehicle, mass: float, inertia: Array, r_g: Array, buoyancy: float, r_b: Array) -> None:
        self.vehicle, self.mass, self.inertia, self.r_g = vehicle, mass, inertia, r_g
        self.buoyancy, self.r_b = buoyancy, r_b
        s = skew(r_g)
        self.rigid = np.block([[mass * np.eye(3), -mass * s], [mass * s, inertia - mass * s @ s]])

    def coriolis_rigid(self, nu: Array) -> Array:
        """Equation 3.57: the parametrization by the angular velocity alone."""
        w = nu[3:]
        ww = skew(w)
        s = skew(self.r_g)
        about_origin = self.inertia - self.mass * s @ s
        matrix = np.block([[self.mass * ww, -self.mass * ww @ s], [self.mass * s @ ww, -skew(about_origin @ w)]])
        return matrix @ nu

    def coriolis_added(self, nu: Array) -> Array:
        """Equation 6.43."""
        linear, angular = self.vehicle.added_mass[:3] @ nu, self.vehicle.added_mass[3:] @ nu
        matrix = np.block([[np.zeros((3, 3)), -skew(linear)], [-skew(linear), -skew(angular)]])
        return matrix @ nu

    def restoring(self, turn: Array) -> Array:
        """Weight and buoyancy, body axes."""
        up = turn.T[:, 2]
        weight, buoyancy = -self.mass * G * up, self.buoyancy * up
        moment = np.cross(self.r_g, weight) + np.cross(self.r_b, buoyancy)
        return np.concatenate([weight + buoyancy, moment])

    def acceleration(self, turn: Array, nu: Array, tau: Array) -> Array:
        drag = self.vehicle.linear_drag * nu + self.vehicle.quadratic_drag * np.abs(nu) * nu
        drag[0] = 0.0
        forces = tau + self.restoring(turn) - drag - self.coriolis_rigid(nu) - self.coriolis_added(nu)
        return np.linalg.solve(self.rigid + self.vehicle.added_mass, forces)


def quaternion_rate(q: Array, w: Array) -> Array:
    """dq/dt of a body-to-world quaternion (w, x, y, z) under the angular velocity w in body axes."""
    s, v = q[0], q[1:]
    return 0.5 * np.concatenate([[-v @ w], s * w + np.cross(v, w)])


def integrate(body: Fossen, start: Array, seconds: float, tau) -> Array:
    """State (position, quaternion, nu, z) after `seconds`; tau(nu, z) -> (wrench, dz/dt)."""

    def rate(_: float, y: Array) -> Array:
        q = y[3:7] / np.linalg.norm(y[3:7])
        turn, nu = rotation(np.concatenate([y[:3], q])), y[7:13]
        wrench, lag_rate = tau(nu, y[13])
        return np.concatenate(
            [turn @ nu[:3], quaternion_rate(y[3:7], nu[3:]), body.acceleration(turn, nu, wrench), [lag_rate]]
        )

    return solve_ivp(rate, (0.0, seconds), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]


def state(tank: Tank) -> Array:
    return np.concatenate([tank.qpos[0], body_velocity(tank.qpos, tank.qvel)[0], tank.lag[0, :1]])


def test_textbook_mass_is_the_compiled_one() -> None:
    body = Fossen(awkward_vehicle(), MASS, INERTIA, GRAVITY_CENTRE, 0.0, BUOYANCY_CENTRE)
    assert body.rigid == pytest.approx(rigid_mass())
    assert body.vehicle.added_mass == pytest.approx(symmetric_mass())


def test_awkward_body_under_all_forces() -> None:
    """12 s: thrust with lag and loss off the axis, oblique thrusters, drag, weight, buoyancy, all couplings."""
    alpha, beta, gamma, tau, n, forces = -0.8, 0.002, -0.05, 0.6, 7.0, np.array([0.7, -0.5])
    vehicle = awkward_vehicle(drag=True, buoyancy_N=190.0)
    body = Fossen(vehicle, MASS, INERTIA, GRAVITY_CENTRE, 190.0, BUOYANCY_CENTRE)
    p = without_drag(alpha=alpha, beta=beta, thrust_loss__gamma=gamma, thrust_lag__tau=tau)
    moving = MASS + vehicle.added_mass[0, 0]
    places = np.array([[0.4, 0.1, -0.2], [-0.3, 0.2, 0.1]])

    def inputs(nu: Array, z: float) -> tuple[Array, float]:
        surge = moving * (alpha * nu[0] * abs(nu[0]) + z + gamma * n * nu[0])
        wrench = np.array([surge, 0.0, 0.0, 0.0, 0.1 * moving * z, 0.0])
        for force, place, thruster in zip(forces, places, vehicle.steering, strict=True):
            push = force * np.array(thruster.direction)
            wrench += np.concatenate([push, np.cross(place, push)])
        return wrench, (beta * n * n - z) / tau

    with Tank(awkward_model(0.005, gravity=-G), vehicle, p) as tank:
        set_velocity(tank.qpos, tank.qvel, np.array([0.3, -0.2, 0.1, 0.25, 0.35, -0.3]))
        tank.propeller_rev_s[:] = n
        tank.tunnel_N[:] = forces
        expected = integrate(body, state(tank), 12.0, inputs)
        tank.step(2400)
        found = state(tank)
    assert np.abs(found[7:13]).min() > 1e-3  # all axes took part
    assert found == pytest.approx(expected, abs=1e-7)


def test_phoenix_let_loose() -> None:
    """20 s of the Phoenix at its own time step, propellers ahead, one bow thruster, started with a list and a turn."""
    model, vehicle = phoenix()
    truth = load_truth("paper-ii")
    index = model.body("phoenix").id
    body = Fossen(
        vehicle,
        model.body_mass[index],
        np.diag([3.66, 56.9, 60.5]),
        model.body_ipos[index],
        vehicle.buoyancy_N,
        vehicle.centre_of_buoyancy_m,
    )
    n, moving = 11.0, model.body_mass[index] + vehicle.added_mass[0, 0]
    arm = model.site("tunnel_bow_lateral").pos

    def inputs(nu: Array, z: float) -> tuple[Array, float]:
        surge = truth.alpha_per_m * nu[0] * abs(nu[0]) + z + truth.gamma_per_rev * n * nu[0]
        side = np.array([0.0, 4.0, 0.0])
        wrench = np.concatenate([side, np.cross(arm, side)])
        wrench[0] += moving * surge
        return wrench, (truth.beta_m_per_rev2 * n * n - z) / truth.tau_s

    with Tank(model, vehicle, truth.vector()) as tank:
        set_velocity(tank.qpos, tank.qvel, np.array([0.2, -0.05, 0.03, 0.1, -0.05, 0.08]))
        tank.propeller_rev_s[:] = n
        tank.tunnel_N[:, 2] = 4.0
        expected = integrate(body, state(tank), 20.0, inputs)
        tank.step(2000)
        assert state(tank) == pytest.approx(expected, abs=1e-7)
