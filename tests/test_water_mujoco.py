"""All of MuJoCo sees the added mass: actuators, sensors, contacts, solvers, integrators, derivatives, threads."""

from __future__ import annotations

import mujoco
import mujoco.batch
import mujoco.rollout
import numpy as np
import pytest
from chains import random_links, specification

from vtank import water
from vtank.water import Body

SIX = np.diag([10.0] * 3 + [0.2] * 3)
SHIP = """<mujoco><option timestep="0.002" gravity="0 0 0"/><worldbody>
<geom type="plane" pos="{wall} 0 0" xyaxes="0 -1 0 0 0 1" size="5 5 1"/>
<body name="ship"><freejoint/>
<geom type="sphere" size="0.1" mass="{mass}"/><site name="stern"/></body></worldbody>
<actuator><motor name="screw" site="stern" gear="1 0 0 0 0 0"/></actuator>
<sensor><accelerometer name="imu" site="stern"/></sensor></mujoco>"""
INTEGRATORS = list(mujoco.mjtIntegrator.__members__)[:4]


def ship(mass: float = 10.0, wall: float = 50.0, wet: bool = True) -> mujoco.MjModel:
    spec = mujoco.MjSpec.from_string(SHIP.format(mass=mass, wall=wall))
    return water.add(spec, Body(SIX)) if wet else spec.compile()


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_actuator_accelerometer_and_speed(integrator: str) -> None:
    """10 kg and 10 kg of added mass under 20 N: 1 m/s2, seen by the sensor, 1 m/s after 1 s."""
    model = ship()
    model.opt.integrator = getattr(mujoco.mjtIntegrator, integrator)
    data = mujoco.MjData(model)
    data.ctrl[0] = 20.0
    with water.forces():
        mujoco.mj_forward(model, data)
        assert data.qacc[0] == pytest.approx(1.0, rel=1e-12)
        assert data.sensordata[0] == pytest.approx(1.0, rel=1e-12)
        mujoco.mj_step(model, data, 500)
    assert data.qvel[0] == pytest.approx(1.0, rel=1e-10)


def rebound(model: mujoco.MjModel, heavy: float) -> tuple[float, float]:
    """Speed after a wall is hit at 1 m/s, and the wall's impulse over mass times change of speed."""
    data, impulse = mujoco.MjData(model), 0.0
    data.qvel[0] = 1.0
    for _ in range(2000):
        mujoco.mj_step(model, data)
        impulse += data.qfrc_constraint[0] * model.opt.timestep
    return float(data.qvel[0]), impulse / (heavy * (data.qvel[0] - 1.0))


@pytest.mark.parametrize("solver", ["mjSOL_NEWTON", "mjSOL_CG"])
def test_a_wall_is_hit_with_the_wet_mass_and_is_as_soft(solver: str) -> None:
    """A ship of 10 kg with 10 kg of added mass bounces as one that has 20 kg; its impulse is that of 20 kg."""
    wet, heavy = ship(wall=0.5), ship(20.0, 0.5, wet=False)
    heavy.body_inertia[1] = wet.body_inertia[1] + 0.2
    mujoco.mj_setConst(heavy, mujoco.MjData(heavy))
    for model in (wet, heavy):
        model.opt.solver = getattr(mujoco.mjtSolver, solver)
    expected, _ = rebound(heavy, 20.0)
    with water.forces():
        found, share = rebound(wet, 20.0)
    assert expected < -0.01 and found == pytest.approx(expected, rel=1e-9)
    assert share == pytest.approx(1.0, abs=1e-12)


def test_without_added_mass_the_constants_are_mujocos_own() -> None:
    """Softness of contacts, limits, friction and tendons of a jointed model, and its mean inertia."""
    spec = specification(random_links())
    first, second = spec.body("hand").add_site(name="a"), spec.body("fin").add_site(name="b")
    tendon = spec.add_tendon(name="rope")
    tendon.wrap_site(first.name), tendon.wrap_site(second.name)
    model = spec.compile()
    names = ("body_invweight0", "dof_invweight0", "tendon_invweight0")
    before = [getattr(model, name).copy() for name in names] + [model.stat.meaninertia]
    water.set_const(model)
    after = [getattr(model, name) for name in names] + [model.stat.meaninertia]
    for ours, theirs in zip(after, before, strict=True):
        assert ours == pytest.approx(theirs, rel=1e-9)


def test_a_pendulum_in_water_swings_as_slowly_as_the_water_makes_it() -> None:
    """Small swings about a hinge far from the body's origin: sqrt(W l/(I + m_A l2)), where W is the weight in water."""
    xml = """<mujoco><option timestep="0.002" integrator="RK4"/><worldbody><body><body name="bob">
      <joint axis="0 1 0" pos="0 0 1"/><inertial pos="0 0 0" mass="4" diaginertia="0.01 0.01 0.01"/>
      </body></body></worldbody></mujoco>"""
    body = Body(np.diag([2.0, 2.0, 2.0, 0.0, 0.005, 0.0]), displaced_kg=1.0)
    model = water.add(mujoco.MjSpec.from_string(xml), {"bob": body})
    data = mujoco.MjData(model)
    data.qpos[0] = 1e-5
    frequency = np.sqrt(3.0 * 9.81 / (0.01 + 4.0 + 0.005 + 2.0))
    with water.forces():
        mujoco.mj_step(model, data, 2000)
    assert data.qpos[0] == pytest.approx(1e-5 * np.cos(frequency * 4.0), abs=1e-11)


def test_two_vehicles_collide_with_their_wet_masses() -> None:
    """Momentum of both, each with its own added mass, before and after."""
    spec = mujoco.MjSpec.from_string(SHIP.format(mass=10, wall=50))
    other = spec.worldbody.add_body(name="tug", pos=(0.5, 0.0, 0.0))
    other.add_freejoint()
    other.add_geom(size=(0.1, 0.0, 0.0), mass=3.0)
    model = water.add(spec, {"ship": Body(SIX), "tug": Body(0.5 * SIX)})
    data = mujoco.MjData(model)
    data.qvel[0] = 1.0
    with water.forces():
        mujoco.mj_step(model, data, 1000)
    assert data.qvel[6] > 0.7 > data.qvel[0]
    assert 20.0 * data.qvel[0] + 8.0 * data.qvel[6] == pytest.approx(20.0, rel=1e-9)


def test_repeated_calls_add_the_mass_once() -> None:
    """mj_step1 and mj_step2, mjd_transitionFD, which skips stages: as often as MuJoCo asks."""
    model = water.add(specification(links := random_links()), {k.name: k.water for k in links if k.water})
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    data, other = mujoco.MjData(model), mujoco.MjData(model)
    data.qvel[:] = other.qvel[:] = 0.3
    size = 2 * model.nv
    derived, centred = np.zeros((size, size)), np.zeros((size, size))
    with water.forces():
        mujoco.mj_step(model, data)
        mujoco.mj_step1(model, other)
        mujoco.mj_step2(model, other)
        assert np.array_equal(data.qvel, other.qvel)
        mujoco.mjd_transitionFD(model, data, 1e-6, True, derived, None, None, None)
        for column in range(model.nv):  # of the velocities, by hand, every stage anew
            ends = []
            for sign in (1.0, -1.0):
                probe = mujoco.MjData(model)
                probe.qpos[:], probe.qvel[:] = data.qpos, data.qvel
                probe.qvel[column] += sign * 1e-6
                mujoco.mj_step(model, probe)
                ends.append(probe.qvel.copy())
            centred[model.nv :, model.nv + column] = (ends[0] - ends[1]) / 2e-6
    assert derived[model.nv :, model.nv :] == pytest.approx(centred[model.nv :, model.nv :], abs=1e-6)


def test_forces_can_be_read_and_the_users_own_stay() -> None:
    model = ship()
    data = mujoco.MjData(model)
    data.qfrc_applied[1] = 3.0
    with water.forces():
        mujoco.mj_step(model, data)
    assert data.qfrc_applied[1] == 3.0 and data.qvel[1] == pytest.approx(0.002 * 3.0 / 20.0)


def test_any_number_of_threads_makes_the_same_bytes() -> None:
    """mujoco.rollout and mujoco.batch, vehicles with arms, each simulation with another added mass."""
    links = random_links()
    model = water.add(specification(links), {link.name: link.water for link in links if link.water})
    start = np.zeros((8, mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
    data = mujoco.MjData(model)
    for row in start:
        data.qvel[:] = 0.1 * np.random.default_rng(int(row[0])).normal(size=model.nv)
        mujoco.mj_getState(model, data, row, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    ends = []
    with water.forces():
        for threads in (1, 2, 3):
            with mujoco.rollout.Rollout(nthread=threads) as rollout:
                states, _ = rollout.rollout(model, [mujoco.MjData(model) for _ in range(threads)], start, nstep=50)
            batch = mujoco.batch.Batch(model, 8, nthread=threads)
            batch.expand("body_user")[:, 1, 1] *= np.linspace(1.0, 2.0, 8)
            batch.qvel[:] = 0.1
            batch.step(nstep=50)
            ends.append(states.tobytes() + batch.state.tobytes())
    assert ends[0] == ends[1] == ends[2]
    assert len({row.tobytes() for row in batch.qpos}) == 8
