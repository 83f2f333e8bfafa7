"""Craft of which nothing tells whether they heave, roll and pitch: flown in the plane alone, and afloat."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vtank as vt
from vtank.diagnose.whole.diagnosis import diagnose
from vtank.diagnose.whole.model_file import model_text, predict
from vtank.diagnose.whole.plane import in_the_plane
from vtank.experiment import fly_vehicle
from vtank.plant.vehicle import Vehicle, load_vehicle
from vtank.record.table import open_table
from vtank.resources import models_dir
from vtank.rigid.recordings import record

TIMES = np.arange(0.0, 100.0, 0.1)
LOW = (0.3, 0.0, 0.6)  # [m] a speed log on a pole
NOISE = {"log.surge_m_s": 0.005, "log.sway_m_s": 0.005, "compass.yaw_rate_rad_s": 0.005, "compass.heading_rad": 0.03}


@pytest.fixture(scope="module")
def craft(tmp_path_factory: pytest.TempPathFactory) -> Vehicle:
    """A Kingfisher with a speed log deep below the deck, that tells of nothing out of the plane."""
    path = tmp_path_factory.mktemp("craft") / "craft.toml"
    text = (models_dir() / "kingfisher.toml").read_text()
    head, _, sensors = text.partition("[sensor.gps]")
    compass, sites = (
        sensors[sensors.index("[sensor.compass]") : sensors.index("[sensor.imu]")],
        sensors.index("[sites]"),
    )
    log = f"""[sensor.log]
channels = ["surge_m_s", "sway_m_s"]
position_m = {list(LOW)}
rate_hz = 10.0
noise = [0.005, 0.005]

"""
    head = head.replace('"kingfisher.xml"', f'"{models_dir() / "kingfisher.xml"}"')
    path.write_text(head + log + compass + sensors[sites:])
    return load_vehicle(path)


def commands() -> np.ndarray:
    """Of both thrusters, (N, 2): one after the other, so that it turns to either side."""
    port = 0.4 + 0.35 * np.sign(np.sin(0.45 * TIMES)) * (np.sin(0.17 * TIMES) > -0.5)
    return np.column_stack([port, 0.4 + 0.3 * np.sign(np.sin(0.31 * TIMES + 1.0))])


def in_plane(vehicle: Vehicle, seed: int, ahead_m: float = 0.0, washed_m_s: float = 0.0) -> vt.Run:
    """Surge, sway and yaw by scipy's integrator, input by input; the speed log turns with the hull in the plane.

    ahead_m: of the origin, where the centre of gravity is. washed_m_s: moment of skegs in the thrusters' wash, over
    their thrust and the rate of turn.
    """
    m = vehicle.mass_kg + np.diag(vehicle.added_mass)[:2]
    inertia = vehicle.inertia[2] + vehicle.added_mass[5, 5] + vehicle.mass_kg * ahead_m**2
    leant = vehicle.mass_kg * ahead_m
    inverse = np.linalg.inv([[m[0], 0.0, 0.0], [0.0, m[1], leant], [0.0, leant, inertia]])
    linear, quadratic = vehicle.linear_drag[[0, 1, 5]], vehicle.quadratic_drag[[0, 1, 5]]
    sides = np.array([vehicle.sites[thruster.site][1] for thruster in vehicle.thrusters])

    def rates(_: float, s: np.ndarray, force: np.ndarray) -> np.ndarray:
        u, v, r = s[:3]
        across = m[1] * v + leant * r
        turned = np.array([across * r, -m[0] * u * r, m[0] * u * v - across * u])
        pushed = np.array([s[4:].sum(), 0.0, -(sides * s[4:]).sum() - washed_m_s * np.abs(s[4:]).sum() * r])
        held = linear * s[:3] + quadratic * np.abs(s[:3]) * s[:3]
        return np.r_[inverse @ (pushed + turned - held), r, (force - s[4:]) / vehicle.thrusters[0].lag_s]

    state, states = np.zeros(6), []
    told = commands()
    for asked in told:
        states.append(state)
        force = np.array([t.force_N(np.array([c]))[0] for t, c in zip(vehicle.thrusters, asked, strict=True)])
        state = solve_ivp(rates, (0.0, 0.1), state, args=(force,), rtol=1e-8, atol=1e-10).y[:, -1]
    u, v, r, heading = np.array(states)[:, :4].T
    seen = {
        "log.surge_m_s": u,
        "log.sway_m_s": v + LOW[0] * r,
        "compass.yaw_rate_rad_s": r,
        "compass.heading_rad": heading,
    }
    rng = np.random.default_rng(seed)
    noisy = {name: x + NOISE[name] * rng.standard_normal(x.size) for name, x in seen.items()}
    return vt.Run("run_1", TIMES, {"port_command": told[:, 0], "starboard_command": told[:, 1], **noisy})


def test_a_simulator_in_the_plane_is_told_from_a_craft_afloat(craft: Vehicle) -> None:
    layout, seen, _ = record([in_plane(craft, 1)], craft)
    assert seen[0].moves.all()
    flat, (note,) = in_the_plane(layout, seen)
    assert "heave, roll, pitch" in note
    np.testing.assert_array_equal(flat[0].moves, [True, True, False, False, False, True])
    told = commands()
    orders = {"time_s": TIMES, "port_command": told[:, 0], "starboard_command": told[:, 1]}
    afloat = fly_vehicle(craft, orders, 100.0, 1)
    columns = {name: x for name, x in afloat.columns.items() if not name.startswith(("imu", "gps"))}
    layout, seen, _ = record([replace(afloat, columns=columns)], craft)
    assert not seen[0].asked[2:5].any()
    same, notes = in_the_plane(layout, seen)
    assert same is seen and not notes


@pytest.mark.slow
def test_in_the_plane_no_speed_log_seems_to_sit_elsewhere(craft: Vehicle, tmp_path: Path) -> None:
    run = in_plane(craft, 1)
    found = diagnose([run], craft, effects=("sensor_displaced", "sensor_rotated", "munk_moment"))
    assert found.verdict.kind == "none", found.verdict
    (tmp_path / "model.toml").write_text(model_text(found))
    sway = predict(open_table(tmp_path / "model.toml"), run)["columns"]["log.sway_m_s"]
    assert sway["diagnosed"] == pytest.approx(found.budget.rms["log.sway_m_s"]["diagnosed"], rel=0.05)
    (tmp_path / "other.toml").write_text(model_text(found).replace('"heave"', '"heaven"'))
    with pytest.raises(vt.InputError, match=r"other\.toml.*still.*surge, sway, heave.*found 'heaven'"):
        predict(open_table(tmp_path / "other.toml"), run)


@pytest.mark.slow
def test_a_centre_of_gravity_ahead_is_seen_in_the_plane(craft: Vehicle) -> None:
    found = diagnose(
        [in_plane(craft, 2, 0.08)], craft, effects=("sensor_displaced", "centre_of_gravity", "munk_moment")
    )
    assert found.verdict.effects == ("centre_of_gravity",), found.verdict
    (placed,) = found.selection.best.effects
    value, sd = found.selection.best.values(placed)["x"]
    assert value == pytest.approx(0.08, abs=max(3.0 * sd, 0.004))


@pytest.mark.slow
def test_skegs_in_the_wash_of_thrusters_have_no_name_and_go_with_both(craft: Vehicle) -> None:
    found = diagnose([in_plane(craft, 3, washed_m_s=0.1)], craft, effects=("drag_asymmetry", "munk_moment"))
    assert (found.verdict.kind, found.verdict.places) == ("unknown", ("yaw",)), found.verdict
    assert found.selection.blocks[0].goes_with[0] == "yaw speed and surge thrust"
