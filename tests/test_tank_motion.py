"""Motions of the tank with known solutions."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from bodies import GRAVITY_CENTRE, awkward_model, awkward_vehicle, body_velocity, phoenix, set_velocity, without_drag
from scipy.linalg import eigh
from scipy.optimize import fsolve
from synthetic import advance

from vtank.effects.catalogue import CATALOGUE
from vtank.effects.effect import Effect
from vtank.plant.parameters import slot
from vtank.plant.truth import load_truth, truth_names
from vtank.plant.vehicle import AXES, Vehicle
from vtank.tank import Tank

ALL_BUT_SURGE = AXES[1:]
DT = 0.01  # [s] time step of the models


def surging(p: np.ndarray, u0: float = 0.0) -> Tank:
    """The Phoenix moving ahead at u0 [m/s], the other axes held."""
    tank = Tank(*phoenix(), p, held=ALL_BUT_SURGE)
    tank.qvel[:, 0] = u0
    return tank


def without_resistance(vehicle: Vehicle) -> Vehicle:
    """The vehicle in ideal fluid."""
    return replace(vehicle, quadratic_drag=np.zeros(6), linear_drag=np.zeros(6))


def history(tank: Tank, seconds: float, every: int = 10) -> tuple[np.ndarray, np.ndarray]:
    """Time, shape (K,) [s], and rows (x, u, z), shape (K, 3), of the first simulation."""
    times, rows = [], []
    with tank:
        for _ in range(round(seconds / DT / every)):
            tank.step(every)
            times.append(tank.time[0])
            rows.append((tank.qpos[0, 0], tank.qvel[0, 0], tank.lag[0, 0]))
    return np.array(times), np.array(rows)


def test_free_decay_is_hyperbolic() -> None:
    """du/dt = -|alpha| u|u|: u = u0/(1 + |alpha| u0 t), x = ln(1 + |alpha| u0 t)/|alpha|."""
    alpha, u0 = -2.56, 0.5
    t, found = history(surging(without_drag(alpha=alpha), u0), 60.0)
    growth = 1.0 - alpha * u0 * t
    assert found[:, 1] == pytest.approx(u0 / growth, rel=1e-6)
    assert found[:, 0] == pytest.approx(np.log(growth) / -alpha, rel=1e-6)


def test_speed_settles_as_a_hyperbolic_tangent() -> None:
    """du/dt = beta n^2 - |alpha| u^2 from rest, n held: terminal speed n sqrt(beta/|alpha|)."""
    alpha, beta, n = -2.56, 0.0005, 12.0
    tank = surging(without_drag(alpha=alpha, beta=beta))
    tank.propeller_rev_s[:] = n
    terminal, rate = n * np.sqrt(-beta / alpha), n * np.sqrt(-beta * alpha)
    t, found = history(tank, 30.0)
    assert found[:, 1] == pytest.approx(terminal * np.tanh(rate * t), rel=1e-6)
    assert found[-1, 1] == pytest.approx(terminal, rel=1e-6)


def test_thrust_loss_gives_an_exponential() -> None:
    """du/dt = beta n^2 + gamma |n| u."""
    beta, gamma, n = 0.0005, -0.09, -9.0
    tank = surging(without_drag(beta=beta, thrust_loss__gamma=gamma))
    tank.propeller_rev_s[:] = n
    t, found = history(tank, 10.0)
    terminal = -beta * abs(n) * n / (gamma * abs(n))
    assert found[:, 1] == pytest.approx(terminal * -np.expm1(gamma * abs(n) * t), rel=1e-6)


def test_step_response_of_the_lag() -> None:
    """z = beta n|n| (1 - exp(-t/tau)), and the speed it leads to without drag."""
    beta, tau, n = 0.0004, 0.45, -10.0
    tank = surging(without_drag(beta=beta, thrust_lag__tau=tau))
    tank.propeller_rev_s[:] = n
    t, found = history(tank, 6.0)
    target, rise = beta * n * abs(n), -np.expm1(-t / tau)
    assert found[:, 2] == pytest.approx(target * rise, rel=1e-6)
    assert found[:, 1] == pytest.approx(target * (t - tau * rise), rel=1e-6)


def test_disturbance_is_an_acceleration() -> None:
    tank = surging(without_drag())
    tank.disturbance_m_s2[:] = -0.01
    t, found = history(tank, 5.0)
    assert found[:, 1] == pytest.approx(-0.01 * t, rel=1e-9)


def assert_tank_is_surge_model(p: np.ndarray, seconds: float) -> None:
    """Reversing propellers, other axes held: position and speed of the two agree to 1e-7 at every sample."""
    tank = surging(p)
    state = (0.0, 0.0, 0.0, 0.0)
    with tank:
        for k in range(round(seconds / 0.1)):
            n = 11.0 * np.sin(0.05 * k)
            tank.propeller_rev_s[:] = n
            tank.step(10)
            for j in range(10):
                state = advance(0.1 * k + DT * j, DT, *state, n, 0.0, p)
            assert tank.qpos[0, 0] == pytest.approx(state[0], abs=1e-7)
            assert tank.qvel[0, 0] == pytest.approx(state[1], abs=1e-7)
    assert tank.qvel[0, 1:] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("name", truth_names())
def test_held_tank_is_the_surge_model(name: str) -> None:
    assert_tank_is_surge_model(load_truth(name).vector(), 120.0)


@pytest.mark.parametrize("effect", [e for e in CATALOGUE if e.channel != "sensor"], ids=lambda effect: effect.name)
def test_every_effect_acts_in_the_tank_as_in_the_surge_model(effect: Effect) -> None:
    """Each at its typical size, on the truth of the paper; the wall stands 10 ft from the sonar in both."""
    p = load_truth("paper-ii").vector()
    before = p.copy()
    for parameter in effect.parameters:
        sign = 1.0 if parameter.bounds[1] >= parameter.scale else -1.0
        p[slot(f"{effect.name}.{parameter.name}")] = sign * parameter.scale
    assert not np.array_equal(p, before)
    assert_tank_is_surge_model(p, 20.0)


def test_wake_state_follows_the_hull() -> None:
    """T dw/dt = k u - w at constant speed: w = k u (1 - exp(-t/T)); without drag the wake does not act back."""
    tank = surging(without_drag(wake_memory__k=0.4, wake_memory__T=2.0), 0.3)
    with tank:
        tank.step(300)
    assert tank.lag[0, 1] == pytest.approx(0.4 * 0.3 * -np.expm1(-1.5), rel=1e-6)


def test_sway_decays_and_yaw_settles_by_their_drag() -> None:
    """One axis at a time: free decay in sway, tanh in yaw under the moment of the two lateral thrusters."""
    model, vehicle = phoenix()
    mass = model.body_mass[1] + vehicle.added_mass[1, 1]
    drag = vehicle.quadratic_drag[1]
    assert vehicle.linear_drag[1] == 0.0
    tank = Tank(model, vehicle, without_drag(), held=("surge", "heave", "roll", "pitch", "yaw"))
    set_velocity(tank.qpos, tank.qvel, np.array([0.0, 0.4, 0.0, 0.0, 0.0, 0.0]))
    with tank:
        tank.step(2000)
    v = body_velocity(tank.qpos, tank.qvel)[0, 1]
    assert v == pytest.approx(0.4 / (1.0 + drag / mass * 0.4 * 20.0), rel=1e-6)

    tank = Tank(model, vehicle, without_drag(), held=("surge", "sway", "heave", "roll", "pitch"))
    tank.tunnel_N[:, 2:] = (4.0, -4.0)
    moment = 4.0 * (model.site("tunnel_bow_lateral").pos[0] - model.site("tunnel_stern_lateral").pos[0])
    with tank:
        tank.step(20000)
    linear, quadratic = vehicle.linear_drag[5], vehicle.quadratic_drag[5]
    settled = (-linear + np.sqrt(linear**2 + 4.0 * quadratic * moment)) / (2.0 * quadratic)
    assert tank.qvel[0, 5] == pytest.approx(settled, rel=1e-6)


def test_steady_turn_is_the_equilibrium_of_the_equations() -> None:
    """Propellers and bow thruster held: surge, sway and yaw settle where all forces of the plane motion cancel.

    Level motion in the plane (roll, pitch, heave held), M = M_RB + M_A, centre of gravity on the x axis.
    """
    model, vehicle = phoenix()
    truth = load_truth("paper-ii")
    tank = Tank(model, vehicle, truth.vector(), held=("heave", "roll", "pitch"))
    tank.propeller_rev_s[:] = 11.0
    tank.tunnel_N[:, 2] = 3.0
    with tank:
        tank.step(60000)
        found = body_velocity(tank.qpos, tank.qvel)[0, [0, 1, 5]]
        tank.step(1000)
        assert body_velocity(tank.qpos, tank.qvel)[0, [0, 1, 5]] == pytest.approx(found, rel=1e-9)

    mass, added, x_g = model.body_mass[1], vehicle.added_mass, model.body_ipos[1, 0]
    arm = model.site("tunnel_bow_lateral").pos[0]

    def unbalanced(state: np.ndarray) -> np.ndarray:
        u, v, r = state
        d1, d2 = vehicle.linear_drag[[1, 5]], vehicle.quadratic_drag[[1, 5]]
        thrust = truth.beta_m_per_rev2 * 121.0 + truth.alpha_per_m * u * abs(u) + truth.gamma_per_rev * 11.0 * u
        sway_impulse = (mass + added[1, 1]) * v + (mass * x_g + added[1, 5]) * r
        surge_impulse = (mass + added[0, 0]) * u
        return np.array(
            [
                (mass + added[0, 0]) * thrust + r * sway_impulse,
                3.0 - (d1[0] + d2[0] * abs(v)) * v - r * surge_impulse,
                3.0 * arm
                - (d1[1] + d2[1] * abs(r)) * r
                - (added[1, 1] - added[0, 0]) * u * v
                - (mass * x_g + added[1, 5]) * u * r,
            ]
        )

    assert found == pytest.approx(fsolve(unbalanced, found * 1.1, xtol=1e-13), rel=1e-6)


def test_phoenix_floats_at_rest() -> None:
    """Neutrally trimmed: nothing moves in 60 s but the rounding of weight and buoyancy (1e-4 N on 1935 N)."""
    model, vehicle = phoenix()
    with Tank(model, vehicle, load_truth("paper-ii").vector()) as tank:
        tank.step(6000)
    surplus = vehicle.buoyancy_N - model.body_mass[1] * 9.80665
    assert abs(surplus) < 1e-3
    assert tank.qpos[0] == pytest.approx(model.qpos0, abs=2.0 * abs(surplus) / model.body_mass[1] * 60.0**2 + 1e-9)


@pytest.mark.parametrize(("axis", "published_rad_s"), [(3, 2.3), (4, 0.48)])
def test_natural_frequencies_of_roll_and_pitch(axis: int, published_rad_s: float) -> None:
    """Small free swing about one axis in ideal fluid: sqrt(weight z_G / (I + A)), near the published figures."""
    model, vehicle = phoenix()
    tank = Tank(model, without_resistance(vehicle), without_drag(), held=[name for name in AXES if name != AXES[axis]])
    inertia = tank.mass[axis, axis]
    frequency = np.sqrt(model.body_mass[1] * 9.80665 * model.body_ipos[1, 2] / inertia)
    assert frequency == pytest.approx(published_rad_s, rel=0.03)
    tank.qvel[:, axis] = 1e-4
    with tank:
        for _ in range(20):
            tank.step(100)
            assert tank.qvel[0, axis] == pytest.approx(1e-4 * np.cos(frequency * tank.time[0]), abs=1e-10)


def test_free_pitch_swings_at_the_eigenfrequency_of_the_coupled_equations() -> None:
    """Nothing held: pitch drags surge and heave along, the spectrum's line is the generalized eigenvalue."""
    model, vehicle = phoenix()
    tank = Tank(model, without_resistance(vehicle), without_drag())
    total = tank.mass
    stiffness = np.zeros((6, 6))
    stiffness[3, 3] = stiffness[4, 4] = model.body_mass[1] * 9.80665 * model.body_ipos[1, 2]
    squares, shapes = eigh(stiffness, total)
    pitch = [i for i in range(6) if squares[i] > 1e-6 and abs(shapes[4, i]) > abs(shapes[3, i])]
    frequency, shape = np.sqrt(squares[pitch[0]]), shapes[:, pitch[0]]
    set_velocity(tank.qpos, tank.qvel, 1e-5 * shape / np.abs(shape).max())
    start = body_velocity(tank.qpos, tank.qvel)[0]
    with tank:
        for _ in range(8):
            tank.step(250)
            now = body_velocity(tank.qpos, tank.qvel)[0]
            assert now == pytest.approx(start * np.cos(frequency * tank.time[0]), abs=1e-6 * np.abs(start).max())
    assert frequency == pytest.approx(0.48, rel=0.03)


def test_body_of_the_waters_density_moves_with_the_water() -> None:
    """Uniformly accelerating water and a neutrally buoyant body at rest in it: no force is left, whatever M_A."""
    model = awkward_model(gravity=-9.80665)
    vehicle = replace(awkward_vehicle(drag=True, buoyancy_N=20.0 * 9.80665), centre_of_buoyancy_m=GRAVITY_CENTRE)
    flow, rate = np.array([0.2, -0.1, 0.15]), np.array([0.03, 0.02, -0.01])
    with Tank(model, vehicle, without_drag(alpha=-1.0)) as tank:
        tank.qvel[:, :3] = flow
        tank.set_water(flow, rate)
        tank.step(1000)
    assert tank.qvel[0] == pytest.approx(np.concatenate([flow + 10.0 * rate, np.zeros(3)]), abs=1e-10)
    assert tank.qpos[0, :3] == pytest.approx(10.0 * flow + 50.0 * rate, abs=1e-10)


def test_motion_in_a_steady_stream_is_that_in_still_water_carried_along() -> None:
    stream = np.array([0.4, 0.25, -0.3])
    nu = np.array([0.3, -0.2, 0.1, 0.25, 0.35, -0.3])
    ends = []
    for carried in (np.zeros(3), stream):
        model, vehicle = awkward_model(gravity=-9.80665), awkward_vehicle(drag=True, buoyancy_N=200.0)
        with Tank(model, vehicle, without_drag(alpha=-1.0, thrust_loss__gamma=-0.1)) as tank:
            set_velocity(tank.qpos, tank.qvel, nu)
            tank.qvel[:, :3] += carried
            tank.set_water(carried)
            tank.propeller_rev_s[:] = 4.0
            tank.step(1000)
            ends.append(np.concatenate([tank.qpos[0], tank.qvel[0]]))
    difference = np.concatenate([10.0 * stream, np.zeros(4), stream, np.zeros(3)])
    assert ends[1] - ends[0] == pytest.approx(difference, abs=1e-9)


def test_euler_integration_is_allowed_and_of_first_order() -> None:
    errors = []
    for timestep in (0.01, 0.005):
        model = awkward_model(timestep)
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
        with Tank(model, awkward_vehicle(), without_drag(alpha=-1.0), held=ALL_BUT_SURGE) as tank:
            tank.qvel[:, 0] = 0.5
            tank.step(round(4.0 / timestep))
            errors.append(tank.qvel[0, 0] - 0.5 / 3.0)
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.02)
