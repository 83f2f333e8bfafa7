"""Added mass in MuJoCo is exact: acceleration from rest, conserved energy and impulse, order of convergence."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from bodies import (
    GRAVITY_CENTRE,
    MJCF,
    afloat,
    awkward_model,
    awkward_vehicle,
    body_velocity,
    phoenix,
    rigid_mass,
    rotation,
    set_velocity,
    symmetric_mass,
    without_drag,
)

from vtank.plant.vehicle import Vehicle
from vtank.tank import Tank, forces, prepare

TOTAL = rigid_mass() + symmetric_mass()
TUMBLE = np.array([0.3, -0.2, 0.1, 0.25, 0.35, -0.3])  # [m/s, rad/s]


def afloat_data(model: mujoco.MjModel | None = None, vehicle: Vehicle | None = None, **values: float) -> mujoco.MjData:
    """The awkward body, or another, with surge parameters of its own."""
    return mujoco.MjData(prepare(model or awkward_model(), vehicle or awkward_vehicle(), without_drag(**values)))


def acceleration_from_rest(data: mujoco.MjData) -> np.ndarray:
    """dnu/dt in body axes, shape (6,), of a resting body."""
    with forces():
        mujoco.mj_forward(data.model, data)
    return np.concatenate([rotation(data.qpos).T @ data.qacc[:3], data.qacc[3:]])


def turned(data: mujoco.MjData) -> None:
    """A pose without symmetry."""
    data.qpos[3:] = np.array([0.4, -0.7, 0.2, 0.55]) / np.linalg.norm([0.4, -0.7, 0.2, 0.55])


@pytest.mark.parametrize("axis", range(6))
def test_acceleration_from_rest_is_force_over_total_mass(axis: int) -> None:
    """Every axis, all couplings: the force acts at the centre of gravity, in world axes, as MuJoCo's user gives it."""
    data = afloat_data()
    turned(data)
    wrench = np.zeros(6)
    wrench[axis] = 7.0
    turn = rotation(data.qpos)
    data.xfrc_applied[1] = np.concatenate([turn @ wrench[:3], turn @ wrench[3:]])
    at_origin = wrench + np.concatenate([np.zeros(3), np.cross(GRAVITY_CENTRE, wrench[:3])])
    expected = np.linalg.solve(TOTAL, at_origin)
    assert acceleration_from_rest(data) == pytest.approx(expected, rel=1e-10, abs=1e-12)


def test_surge_from_rest_is_force_over_mass_less_x_udot() -> None:
    """The issue's line on the Phoenix itself, the other axes held: F / (m - Xudot), to 1e-10."""
    model, vehicle = phoenix()
    data = mujoco.MjData(prepare(model, vehicle, without_drag(), held=("sway", "heave", "roll", "pitch", "yaw")))
    body = model.body("phoenix").id
    data.xfrc_applied[body, 0] = 10.0
    found = acceleration_from_rest(data)
    assert found[0] == pytest.approx(10.0 / (model.body_mass[body] + vehicle.added_mass[0, 0]), rel=1e-10)
    assert found[1:] == pytest.approx(0.0, abs=1e-14)


def test_thrusters_and_propellers_push_with_their_levers() -> None:
    data, vehicle = afloat_data(beta=0.002), awkward_vehicle()
    turned(data)
    data.ctrl[:3] = (5.0, 3.0, -4.0)
    thrust = TOTAL[0, 0] * 0.002 * 25.0
    side, oblique = np.array([0.0, 3.0, 0.0]), -4.0 * np.array(vehicle.thrusters[1].direction)
    force = side + oblique + [thrust, 0.0, 0.0]
    moment = np.cross([0.4, 0.1, -0.2], side) + np.cross([-0.3, 0.2, 0.1], oblique) + [0.0, 0.1 * thrust, 0.0]
    expected = np.linalg.solve(TOTAL, np.concatenate([force, moment]))
    assert acceleration_from_rest(data) == pytest.approx(expected, rel=1e-10, abs=1e-12)


def test_weight_and_buoyancy_act_at_their_own_centres() -> None:
    model = awkward_model(gravity=-9.80665)
    vehicle = awkward_vehicle(buoyancy_N=180.0)
    data = afloat_data(model, vehicle)
    turned(data)
    up = rotation(data.qpos).T @ [0.0, 0.0, 1.0]
    weight, buoyancy = -20.0 * 9.80665 * up, 180.0 * up
    moment = np.cross(GRAVITY_CENTRE, weight) + np.cross(vehicle.centre_of_buoyancy_m, buoyancy)
    expected = np.linalg.solve(TOTAL, np.concatenate([weight + buoyancy, moment]))
    assert acceleration_from_rest(data) == pytest.approx(expected, rel=1e-10, abs=1e-12)


def test_mujocos_passive_forces_count() -> None:
    """A spring of the free joint itself, far from where it is slack: its force and moment move the whole mass."""
    xml = MJCF.replace("<freejoint/>", '<joint type="free" stiffness="30"/>')
    data = afloat_data(afloat(xml.format(timestep=0.01, gravity=0.0)))
    turned(data)
    data.qpos[:3] = (2.0, -1.0, 0.5)
    found = acceleration_from_rest(data)
    spring = np.concatenate([rotation(data.qpos).T @ data.qfrc_spring[:3], data.qfrc_spring[3:]])
    assert np.abs(spring).min() > 0.1
    assert found == pytest.approx(np.linalg.solve(TOTAL, spring), rel=1e-10, abs=1e-12)


def test_mass_edited_by_the_user_counts() -> None:
    model = awkward_model()
    model.body_mass[1] = 33.0
    held = ("sway", "heave", "roll", "pitch", "yaw")
    data = mujoco.MjData(prepare(model, awkward_vehicle(), without_drag(), held))
    data.xfrc_applied[1, 0] = 5.0
    assert acceleration_from_rest(data)[0] == pytest.approx(5.0 / (33.0 + symmetric_mass()[0, 0]), rel=1e-10)


def tumbling(timestep: float = 0.01, gravity: float = 0.0) -> Tank:
    tank = Tank(awkward_model(timestep, gravity), awkward_vehicle(), without_drag())
    set_velocity(tank.qpos, tank.qvel, TUMBLE)
    return tank


def invariants(tank: Tank) -> tuple[float, np.ndarray]:
    """Kinetic energy of body and water [J]; impulse and its moment about the world's origin, world axes, (6,)."""
    nu, turn = body_velocity(tank.qpos, tank.qvel)[0], rotation(tank.qpos)[0]
    momentum = TOTAL @ nu
    p = turn @ momentum[:3]
    h = turn @ momentum[3:] + np.cross(tank.qpos[0, :3], p)
    return 0.5 * nu @ momentum, np.concatenate([p, h])


def test_energy_and_impulse_are_conserved_in_ideal_fluid() -> None:
    """100 s of tumbling over some 30 m, centre of gravity off the origin, full added mass: to 1e-9."""
    with tumbling() as tank:
        energy, impulse = invariants(tank)
        for _ in range(20):
            tank.step(500)
            now, impulse_now = invariants(tank)
            scale = np.linalg.norm(impulse[:3])
            assert now == pytest.approx(energy, rel=1e-9)
            assert impulse_now[:3] == pytest.approx(impulse[:3], abs=1e-9 * scale)
            lever = 1.0 + np.linalg.norm(tank.qpos[0, :3])
            assert impulse_now[3:] == pytest.approx(impulse[3:], abs=1e-9 * scale * lever)
    assert tank.time == pytest.approx(100.0)
    assert np.ptp(body_velocity(tank.qpos, tank.qvel)[0] / TUMBLE) > 0.5  # it did tumble


def test_order_of_convergence_is_four() -> None:
    """Error after 8 s of pose, velocity and lag against the step length; thrust, surge drag and weight at work."""

    def end(timestep: float) -> np.ndarray:
        p = without_drag(alpha=-0.5, beta=0.002, thrust_loss__gamma=-0.05, thrust_lag__tau=0.7)
        model = awkward_model(timestep, gravity=-9.80665)
        with Tank(model, awkward_vehicle(buoyancy_N=20.0 * 9.80665), p) as tank:
            set_velocity(tank.qpos, tank.qvel, TUMBLE)
            tank.propeller_rev_s[:] = 6.0
            tank.tunnel_N[:] = (0.6, -0.4)
            tank.step(round(8.0 / timestep))
            return np.concatenate([tank.qpos[0], tank.qvel[0], tank.lag[0, :1]])

    exact = end(0.00125)
    errors = np.array([np.linalg.norm(end(step) - exact) for step in (0.02, 0.01, 0.005)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders.min() >= 3.9, (errors, orders)
