"""Many simulations at once: independent, alike on any number of threads, and the same as one stepped by hand."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest
from bodies import awkward_model, awkward_vehicle, phoenix, set_velocity, without_drag

from vtank.errors import InputError
from vtank.plant.truth import load_truth, truth_names
from vtank.tank import Tank, forces, prepare
from vtank.tank.layout import SURGE, field
from vtank.units import FOOT_M

TRUTHS = np.array([load_truth(name).vector() for name in truth_names()] * 3)


def stirred(nthread: int, truths: np.ndarray = TRUTHS) -> Tank:
    """Simulations with different parameters, inputs and starts."""
    tank = Tank(*phoenix(), truths, nthread=nthread)
    rng = np.random.default_rng(3)
    set_velocity(tank.qpos, tank.qvel, 0.1 * rng.normal(size=(len(truths), 6)))
    tank.propeller_rev_s[:] = 10.0 * rng.normal(size=len(truths))
    tank.tunnel_N[:] = rng.normal(size=tank.tunnel_N.shape)
    tank.disturbance_m_s2[:] = 0.01 * rng.normal(size=len(truths))
    return tank


def test_one_and_two_threads_agree_to_the_byte() -> None:
    states = []
    for nthread in (1, 2):
        with stirred(nthread) as tank:
            for _ in range(20):
                tank.step(25)
        states.append(tank.batch.state.tobytes())
    assert states[0] == states[1]


def test_tanks_may_begin_in_several_threads_at_once() -> None:
    """In a process of their own, where nothing is compiled yet: all find the same callbacks."""
    code = (
        "import sys; sys.path.insert(0, 'tests'); from concurrent.futures import ThreadPoolExecutor as Pool\n"
        "from bodies import awkward_model, awkward_vehicle, without_drag; from vtank.tank import Tank\n"
        "def fly(_):\n"
        "    with Tank(awkward_model(), awkward_vehicle(), without_drag()) as tank: tank.step(300)\n"
        "with Pool(4) as pool: list(pool.map(fly, range(8)))"
    )
    subprocess.run([sys.executable, "-c", code], cwd=Path(__file__).parents[1], check=True)


def test_simulations_do_not_disturb_each_other() -> None:
    with stirred(2) as together:
        together.step(300)
    alone = stirred(1, TRUTHS[:1])
    many = stirred(1)
    for name in ("qvel", "propeller_rev_s", "tunnel_N", "disturbance_m_s2"):
        getattr(alone, name)[:] = getattr(many, name)[:1]
    with alone:
        alone.step(300)
    assert alone.qpos[0].tobytes() == together.qpos[0].tobytes()
    assert len({row.tobytes() for row in together.qpos}) == len(TRUTHS)


def test_mj_step_by_hand_is_the_same_simulation() -> None:
    with stirred(1) as tank:
        model = prepare(phoenix()[0], tank.vehicle, TRUTHS[1])
        data = mujoco.MjData(model)
        data.qvel[:] = tank.qvel[1]
        data.ctrl[:] = (tank.propeller_rev_s[1], *tank.tunnel_N[1])
        field(model.actuator_user[model.actuator(SURGE).id], "disturbance_m_s2")[...] = tank.disturbance_m_s2[1]
        tank.step(200)
    with forces():
        mujoco.mj_step(model, data, 200)
    assert data.qpos.tobytes() == tank.qpos[1].tobytes()
    assert data.act.tobytes() == tank.lag[1].tobytes()


def test_the_tanks_arrays_are_live() -> None:
    tank = stirred(1)
    for name in ("qpos", "qvel", "lag", "time", "propeller_rev_s", "tunnel_N"):
        assert np.shares_memory(getattr(tank, name), tank.batch.state), name
    for name in ("disturbance_m_s2", "parameters", "sonar_m", "wall_m"):
        assert np.shares_memory(getattr(tank, name), tank.batch.expand("actuator_user")), name
    assert tank.tunnel_N.shape == (len(TRUTHS), 4)
    assert tank.parameters == pytest.approx(TRUTHS, abs=0.0)


def test_reset_returns_to_the_start_and_keeps_the_parameters() -> None:
    with stirred(1) as tank:
        tank.parameters[0] = TRUTHS[1]
        tank.set_water(np.array([0.1, 0.0, 0.0]))
        tank.step(100)
        tank.reset()
        fresh = Tank(tank.model, tank.vehicle, TRUTHS)
        fresh.parameters[0] = TRUTHS[1]
        assert np.array_equal(tank.batch.state, fresh.batch.state)
        for name in ("body_user", "actuator_user"):
            assert np.array_equal(tank.batch.expand(name), fresh.batch.expand(name))


def test_tank_ranges_by_ray() -> None:
    """Wall ahead at 13.5 ft, floor at 7 ft: straight, yawed, down to the floor, and nothing to hear above."""
    tank = Tank(*phoenix(), TRUTHS[:2])
    wall, floor = 13.5 * FOOT_M, -7.0 * FOOT_M
    points = np.zeros((2, 4, 3))
    points[..., 0], points[..., 2] = 1.0, -0.9
    points[1, :, 0] = 0.5
    yaw = np.radians(12.0)
    directions = np.array(
        [[1.0, 0.0, 0.0], [np.cos(yaw), np.sin(yaw), 0.0], [np.cos(1.2), 0.0, -np.sin(1.2)], [0.0, 0.0, 1.0]]
    )
    found = tank.ray(points, directions)
    for k, x in enumerate((1.0, 0.5)):
        expected = [wall - x, (wall - x) / np.cos(yaw), (-0.9 - floor) / np.sin(1.2), np.inf]
        assert found[k] == pytest.approx(expected, rel=1e-9)


def test_along_no_direction_there_is_no_range() -> None:
    """Where MuJoCo's ray would end the process: what a simulation that ran away may ask for."""
    tank = Tank(*phoenix(), TRUTHS[:1])
    found = tank.ray(np.zeros((1, 1, 3)), np.array([[0.0, 0.0, 0.0], [np.nan, np.nan, np.nan], [1.0, 0.0, 0.0]]))
    assert np.isnan(found[0, 0]) and np.isfinite(found[0, 2])


@pytest.mark.parametrize(
    ("name", "value"), [("disturbance_m_s2", 1e12), ("propeller_rev_s", np.nan), ("propeller_rev_s", 1e300)]
)
def test_diverging_simulation_is_reported_and_can_be_reset(
    name: str, value: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By its number, without MuJoCo's log file in the user's folder; a speed beyond reason never counts as rest."""
    monkeypatch.chdir(tmp_path)
    with stirred(2) as tank:
        getattr(tank, name)[2] = value
        with pytest.raises(InputError, match=f"simulation 2 of {len(TRUTHS)} diverged.*time step of 0.01 s"):
            tank.step(50)
        tank.reset()
        assert tank.parameters == pytest.approx(TRUTHS, abs=0.0)
        tank.step(50)
    assert not list(tmp_path.iterdir())


def test_divergence_is_reported_also_where_mujoco_starts_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    model = awkward_model()
    model.opt.disableflags ^= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    with Tank(model, awkward_vehicle(), without_drag()) as tank:
        tank.propeller_rev_s[:] = np.nan
        with pytest.raises(InputError, match="simulation 0 of 1 diverged"):
            tank.step(5)


def test_many_calls_of_one_step_are_one_call_of_many_steps() -> None:
    ends = []
    for calls, nstep in ((1, 100), (100, 1)):
        with Tank(awkward_model(), awkward_vehicle(drag=True), without_drag(alpha=-1.0)) as tank:
            set_velocity(tank.qpos, tank.qvel, np.array([0.3, -0.2, 0.1, 0.25, 0.35, -0.3]))
            for _ in range(calls):
                tank.step(nstep)
        ends.append(tank.qpos.tobytes() + tank.qvel.tobytes())
    assert ends[0] == ends[1]
