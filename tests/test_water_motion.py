"""Motions in water with known solutions: ideal fluid, free decay, terminal speed, waves, order of convergence."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from chains import Link, random_links, specification

from vtank import water
from vtank.water import Body
from vtank.waves import Waves

RK4 = mujoco.mjtIntegrator.mjINT_RK4
BALL = """<mujoco><option timestep="{step}" gravity="0 0 {gravity}" integrator="RK4"/><worldbody>
<body name="ball"><freejoint/><inertial pos="0 0 0" mass="10" diaginertia="0.2 0.2 0.2"/></body></worldbody></mujoco>"""


def ball(body: Body, step: float = 0.01, gravity: float = 0.0, **sea: object) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = water.add(mujoco.MjSpec.from_string(BALL.format(step=step, gravity=gravity)), body, **sea)
    return model, mujoco.MjData(model)


def ideal(links: list[Link]) -> list[Link]:
    """The same bodies, dead weight and drag taken away."""
    return [replace(link, water=Body(link.water.added_mass) if link.water else None) for link in links]


def floating(step: float) -> mujoco.MjModel:
    """The vehicle with arm and fin alone, in ideal fluid."""
    links = ideal([link for link in random_links() if link.name not in ("buoy", "post", "flag")])
    spec = specification(links)
    spec.option.gravity, spec.option.timestep, spec.option.integrator = np.zeros(3), step, RK4
    return water.add(spec, {link.name: link.water for link in links if link.water})


def momentum(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[float, np.ndarray]:
    """Kinetic energy of bodies and water [J]; their impulse and its moment about the world's origin, shape (6,)."""
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    push = full @ data.qvel
    body = int(model.jnt_bodyid[0])
    moment = data.xmat[body].reshape(3, 3) @ push[3:6] + np.cross(data.xpos[body], push[:3])
    return 0.5 * float(data.qvel @ push), np.concatenate([push[:3], moment])


def test_energy_and_impulse_of_a_jointed_vehicle_are_conserved() -> None:
    """100 s of tumbling in ideal fluid, arm and fin flailing: to 1e-9."""
    model = floating(0.002)
    data = mujoco.MjData(model)
    data.qvel[:] = 0.2 * np.random.default_rng(4).normal(size=model.nv)
    with water.forces():
        energy, impulse = momentum(model, data)
        start = data.qpos.copy()
        for _ in range(10):
            mujoco.mj_step(model, data, 5000)
            now, pushed = momentum(model, data)
            lever = 1.0 + np.linalg.norm(data.qpos[:3])
            assert now == pytest.approx(energy, rel=1e-9)
            assert pushed[:3] == pytest.approx(impulse[:3], abs=1e-9 * np.linalg.norm(impulse[:3]))
            assert pushed[3:] == pytest.approx(impulse[3:], abs=1e-9 * np.linalg.norm(impulse[:3]) * lever)
    assert data.time == pytest.approx(100.0) and np.abs(data.qpos - start).max() > 1.0


def test_order_of_convergence_is_four() -> None:
    """Everything jointed, in a current and under all forces, over 1 s."""
    links = random_links()
    ends = []
    for step in (0.008, 0.004, 0.002, 0.0005):
        spec = specification([replace(link, water=smooth(link.water)) for link in links])
        spec.option.integrator, spec.option.timestep = RK4, step
        bodies = {link.name: smooth(link.water) for link in links if link.water}
        model = water.add(spec, bodies, current_m_s=(0.2, 0.1, -0.05))
        data = mujoco.MjData(model)
        data.qvel[:] = 0.1 * np.random.default_rng(5).normal(size=model.nv)
        with water.forces():
            mujoco.mj_step(model, data, round(1.0 / step))
        ends.append(np.concatenate([data.qpos, data.qvel]))
    errors = np.array([np.linalg.norm(end - ends[-1]) for end in ends[:-1]])
    assert np.log2(errors[:-1] / errors[1:]).min() >= 3.9, errors


def smooth(body: Body | None) -> Body | None:
    """Without the corners of |u|u, which no method of fourth order sees through."""
    return body and replace(body, drag_quadratic=(0.0,) * 6, cross_flow=(0.0,) * 4)


def test_free_decay_and_terminal_speed_have_their_closed_forms() -> None:
    """(m + m_A) du/dt = -q u|u|: hyperbola; under net weight W from rest: U tanh(W t/((m + m_A) U)), U = sqrt(W/q)."""
    added, q = 7.0, 30.0
    body = Body(np.diag([added] * 3 + [0.1] * 3), displaced_kg=8.0, drag_quadratic=(q, q, q, 1.0, 1.0, 1.0))
    model, data = ball(body)
    data.qvel[0] = 0.8
    with water.forces():
        for _ in range(20):
            mujoco.mj_step(model, data, 100)
            assert data.qvel[0] == pytest.approx(0.8 / (1.0 + q * 0.8 * data.time / (10.0 + added)), rel=1e-6)
    model, data = ball(body, gravity=-9.81)
    weight = (10.0 - 8.0) * 9.81
    limit = np.sqrt(weight / q)
    with water.forces():
        for _ in range(10):
            mujoco.mj_step(model, data, 100)
            sinking = limit * np.tanh(weight / (10.0 + added) / limit * data.time)
            assert data.qvel[2] == pytest.approx(-sinking, rel=1e-6)
    assert data.qvel[2] == pytest.approx(-limit, rel=1e-6)


def test_linear_drag_against_a_current_decays_exponentially_to_it() -> None:
    model, data = ball(
        Body(np.diag([5.0] * 3 + [0.1] * 3), drag_linear=(6.0,) * 3 + (0.1,) * 3), current_m_s=(0.0, 0.3, 0.0)
    )
    with water.forces():
        mujoco.mj_step(model, data, 300)
    assert data.qvel[1] == pytest.approx(0.3 * -np.expm1(-6.0 / 15.0 * 3.0), rel=1e-8)


def test_a_neutral_body_rides_on_the_waves_as_the_water_does() -> None:
    """No drag, buoyancy alone: to first order in steepness it runs round with the water, whatever its added mass."""
    waves = Waves("regular", height_m=0.002, period_s=3.0, water_depth_m=20.0)
    body = Body(np.diag([5.0, 8.0, 3.0, 0.1, 0.1, 0.1]), displaced_kg=10.0)
    model, data = ball(body, gravity=-9.80665, waves=waves, towards_rad=0.7)
    w = 2.0 * np.pi / 3.0
    k = w * w / 9.80665
    size = 0.001 * w * np.exp(-2.0 * k)
    data.qpos[2] = -2.0
    data.qvel[:3] = np.array([np.cos(0.7), np.sin(0.7), 0.0]) * size
    with water.forces():
        for _ in range(6):
            mujoco.mj_step(model, data, 50)
            along = np.array([np.cos(0.7), np.sin(0.7)]) * size * np.cos(w * data.time)
            assert data.qvel[:2] == pytest.approx(along, abs=0.01 * size)
            assert data.qvel[2] == pytest.approx(-size * np.sin(w * data.time), abs=0.01 * size)


def test_waves_are_those_of_the_orbit() -> None:
    """The compiled sum against vtank.waves, irregular, in shallow water: velocity felt by a body held still."""
    from vtank.waves.orbit import point
    from vtank.waves.sea import surface

    waves = Waves("irregular", height_m=0.4, period_s=4.0, water_depth_m=6.0, components=30)
    model, data = ball(Body(np.zeros((6, 6)), drag_linear=(1.0,) * 6), waves=waves, seed=3)
    orbit = point(*surface(waves, np.random.default_rng(3)), -1.5, 6.0, x_m=2.0)
    data.qpos[:3] = (2.0, 5.0, -1.5)
    with water.forces():
        for time in (0.0, 1.3, 7.7):
            data.time = time
            mujoco.mj_forward(model, data)
            along, up = orbit.velocity(np.array([time]))[0]
            assert data.qfrc_fluid[:3] == pytest.approx([along, 0.0, up], abs=1e-12)
