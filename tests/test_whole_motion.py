"""Whole vehicles against closed forms: terminal speed, lag, fins, and instruments that are elsewhere and turned."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vtank.errors import InputError
from vtank.experiment import fly_vehicle
from vtank.plant import Fin, Sensor, Thruster, Vehicle, load_vehicle
from vtank.record import read_run, write_run
from vtank.resources import models_dir
from vtank.tank import Motion, load_whole
from vtank.waves import Waves

STEP_S = 0.01
G = 9.80665
MOTION = ("surge_m_s", "sway_m_s", "heave_m_s", "roll_rate_rad_s", "pitch_rate_rad_s", "yaw_rate_rad_s")
POSE = ("north_m", "east_m", "depth_m", "roll_rad", "pitch_rad", "heading_rad")
ACCEL = ("accel_x_m_s2", "accel_y_m_s2", "accel_z_m_s2")
ALL = MOTION + POSE + ACCEL
MJCF = """
<mujoco>
  <option timestep="0.01" gravity="0 0 -9.80665"/>
  <worldbody>
    <body name="block" pos="0 0 -2" quat="0 1 0 0">
      <freejoint/>
      <inertial mass="10" pos="0 0 0" diaginertia="0.4 0.5 0.6"/>
      <site name="origin" pos="0 0 0"/><site name="stern" pos="-0.5 0 0"/><site name="side" pos="0 0.3 0"/>
    </body>
  </worldbody>
</mujoco>
"""
PORT = Sensor("port", ALL, (0.3, -0.2, 0.1), (0.0, 0.0, 45.0))
CENTRE = Sensor("centre", ALL)


@pytest.fixture(scope="module")
def block(tmp_path_factory: pytest.TempPathFactory) -> Vehicle:
    """10 kg with 5 kg of added mass in surge, neutral, with quadratic drag, one thruster of 20 N."""
    path = tmp_path_factory.mktemp("block") / "block.xml"
    path.write_text(MJCF, encoding="utf-8")
    return Vehicle(
        name="block",
        mjcf=path,
        mass_kg=10.0,
        added_mass=np.diag([5.0, 8.0, 12.0, 0.1, 0.2, 0.3]),
        quadratic_drag=np.array([30.0, 60.0, 80.0, 1.0, 1.0, 1.0]),
        linear_drag=np.zeros(6),
        buoyancy_N=10.0 * G,
        centre_of_buoyancy_m=np.zeros(3),
        propeller_sites=(),
        propeller_diameter_m=0.1,
        thrusters=(Thruster("origin", (1.0, 0.0, 0.0), 20.0), Thruster("side", (1.0, 0.0, 0.0), 20.0)),
        sensors=(CENTRE, PORT),
    )


def flown(vehicle: Vehicle, steps: int, start: tuple[float, ...] = (0.0,) * 6, **asked: float) -> Motion:
    """Motion under constant commands."""
    whole = load_whole(vehicle)
    return whole.fly(whole.control({"none": np.zeros(steps)} | {k: np.full(steps, v) for k, v in asked.items()}), start)


def free(vehicle: Vehicle) -> Vehicle:
    """Without drag."""
    return replace(vehicle, quadratic_drag=np.zeros(6))


def test_the_speed_under_constant_thrust_is_the_closed_form(block: Vehicle) -> None:
    """(m + m_A) u' = T - D u2: u = sqrt(T/D) tanh(t sqrt(T D)/(m + m_A))."""
    motion = flown(block, 400, origin_N=12.0)
    expected = np.sqrt(12.0 / 30.0) * np.tanh(motion.time_s * np.sqrt(12.0 * 30.0) / 15.0)
    assert motion.channels["centre"]["surge_m_s"] == pytest.approx(expected, abs=1e-6)
    assert motion.channels["centre"]["accel_x_m_s2"][0] == pytest.approx(12.0 / 15.0, rel=1e-9)


def test_the_lag_of_a_thruster_is_exponential(block: Vehicle) -> None:
    """Without drag: acceleration is T (1 - exp(-t/tau))/(m + m_A), and so is what an accelerometer reads."""
    lagging = replace(free(block), thrusters=(replace(block.thrusters[0], lag_s=0.3),))
    motion = flown(lagging, 300, origin_N=6.0)
    expected = 6.0 / 15.0 * -np.expm1(-motion.time_s / 0.3)
    assert motion.channels["centre"]["accel_x_m_s2"] == pytest.approx(expected, abs=1e-6)


def test_an_accelerometer_at_rest_reads_gravity_in_its_own_axes(block: Vehicle) -> None:
    tilted = Sensor("tilted", ACCEL, rotation_deg=(0.0, 30.0, 0.0))
    motion = flown(replace(block, sensors=(CENTRE, tilted)), 5)
    level, turned = ([motion.channels[name][channel][0] for channel in ACCEL] for name in ("centre", "tilted"))
    assert level == pytest.approx([0.0, 0.0, -G], abs=1e-9)
    assert turned == pytest.approx([G * 0.5, 0.0, -G * np.sqrt(0.75)], abs=1e-9)


def test_a_turned_log_reads_the_turned_velocity(block: Vehicle) -> None:
    """Turned by 45 deg to starboard, what moves straight ahead goes ahead and to port."""
    motion = flown(free(block), 20, (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)).channels["port"]
    assert motion["surge_m_s"] == pytest.approx(np.sqrt(0.5)) and motion["sway_m_s"] == pytest.approx(-np.sqrt(0.5))
    assert motion["heading_rad"] == pytest.approx(np.pi / 4.0)


def test_a_log_elsewhere_reads_the_lever_arm(block: Vehicle) -> None:
    """v + w x r, in the axes of the sensor; the gyro reads the same everywhere."""
    v, w, r = np.array([0.4, 0.1, -0.2]), np.array([0.05, -0.1, 0.3]), np.array(PORT.position_m)
    motion = flown(free(block), 2, (*v, *w)).channels["port"]
    seen = np.array([motion[name][0] for name in MOTION])
    turn = PORT.rotation.T
    assert seen == pytest.approx(np.concatenate([turn @ (v + np.cross(w, r)), turn @ w]), abs=1e-12)


def test_an_accelerometer_elsewhere_reads_the_centripetal_force(block: Vehicle) -> None:
    """Turning at rest about z, which is a principal axis: -r w2 towards the axis."""
    level = replace(free(block), added_mass=np.diag([5.0, 5.0, 5.0, 0.1, 0.1, 0.3]))
    arm = replace(level, sensors=(Sensor("arm", ACCEL, (0.4, 0.0, 0.0)),))
    motion = flown(arm, 2, (0.0, 0.0, 0.0, 0.0, 0.0, 0.5)).channels["arm"]
    assert [motion[name][0] for name in ACCEL] == pytest.approx([-0.4 * 0.25, 0.0, -G], abs=1e-9)


def test_earth_axes_are_north_east_down_and_heading_grows_to_starboard(block: Vehicle) -> None:
    """A quarter turn to starboard while going ahead ends in the north-east."""
    turning = replace(free(block), added_mass=np.zeros((6, 6)))
    steps = round(0.5 * np.pi / 0.5 / STEP_S)
    motion = flown(turning, steps, (1.0, 0.0, 0.1, 0.0, 0.0, 0.5)).channels["centre"]
    assert motion["heading_rad"][-1] == pytest.approx(0.5 * STEP_S * (steps - 1), abs=1e-3)
    assert motion["east_m"][1] == pytest.approx(0.0, abs=1e-3) and motion["depth_m"][-1] > 2.0 + 0.25
    assert motion["north_m"][-1] > 2.0  # no force turns the velocity: straight on


def test_the_yaw_of_a_thruster_beside_the_axis(block: Vehicle) -> None:
    """0.3 m to starboard, pushing ahead: a moment to port, -0.3 T over I + I_A."""
    motion = flown(free(block), 3, side_N=2.0).channels["centre"]
    rate = motion["yaw_rate_rad_s"]
    assert (rate[1] - rate[0]) / STEP_S == pytest.approx(-0.3 * 2.0 / 0.9, rel=1e-4)


def test_an_mjcf_with_its_z_axis_up_flies_the_same(block: Vehicle, tmp_path: Path) -> None:
    """The same body, its sites and start written in axes x forward, y to port, z up."""
    up = MJCF.replace(' quat="0 1 0 0"', "").replace('"side" pos="0 0.3 0"', '"side" pos="0 -0.3 0"')
    (tmp_path / "up.xml").write_text(up, encoding="utf-8")
    start = (0.5, 0.1, -0.1, 0.02, 0.05, 0.1)
    vehicle = replace(block, fins=(RUDDER,))
    one, other = (
        flown(replace(vehicle, mjcf=mjcf), 300, start, side_N=3.0, rudder_rad=0.1).channels["port"]
        for mjcf in (block.mjcf, tmp_path / "up.xml")
    )
    for channel in ALL:
        np.testing.assert_allclose(other[channel], one[channel], atol=1e-9, err_msg=channel)


def test_currents_carry_and_a_log_tells_speed_over_ground(block: Vehicle) -> None:
    whole = load_whole(block, current_m_s=(0.3, 0.0, 0.0))
    motion = whole.fly(whole.control({"none": np.zeros(20000)})).channels["centre"]
    assert motion["surge_m_s"][-1] == pytest.approx(0.3, abs=0.01) and motion["surge_m_s"][0] == 0.0


# --- fins -------------------------------------------------------------------------------------------------------------
RUDDER = Fin("rudder", "stern", (0.0, 0.0, 1.0), 0.02, 3.0, 0.35)


def push(block: Vehicle, fin: Fin, start: tuple[float, ...], angle: float) -> np.ndarray:
    """Force of a fin at the start, by accelerometers: in surge and sway, and moment in yaw [N, N m]."""
    ahead = Sensor("ahead", ACCEL, (1.0, 0.0, 0.0))
    light = replace(free(block), added_mass=np.zeros((6, 6)), sensors=(CENTRE, ahead))
    with_fin = flown(replace(light, fins=(fin,)), 2, start, **{fin.column: angle}).channels
    bare = flown(light, 2, start).channels
    here, there = ([with_fin[at][name][0] - bare[at][name][0] for name in ACCEL[:2]] for at in ("centre", "ahead"))
    return np.array([10.0 * here[0], 10.0 * here[1], 0.6 * (there[1] - here[1])])


def test_a_rudder_lifts_and_turns_the_bow_to_port(block: Vehicle) -> None:
    """A positive angle about z, its front to starboard: lift to starboard at the stern, rho/2 A U2 CL."""
    lift = 0.5 * 1000.0 * 0.02 * 4.0 * 3.0 * 0.1
    x, y, n = push(block, RUDDER, (2.0, 0.0, 0.0, 0.0, 0.0, 0.0), 0.1)
    assert (x, y) == pytest.approx((-lift * np.tan(0.1), lift), rel=1e-9)
    assert n == pytest.approx(-0.5 * lift, rel=1e-9)


def test_a_fin_meets_the_flow_of_drift_and_turning(block: Vehicle) -> None:
    """At rest in the hull, v and r give an angle of attack -atan((v - 0.5 r)/u): a force against both."""
    u, v, r = 2.0, 0.1, 0.2
    across = v - 0.5 * r
    _, y, _ = push(block, RUDDER, (u, v + 0.1, 0.0, 0.0, 0.0, r), 0.0)
    across += 0.1
    speed = np.hypot(u, across)
    alpha = -np.arctan2(across, u)
    lift, drag = 3.0 * alpha, 3.0 * alpha * np.tan(alpha)
    assert y == pytest.approx(10.0 * speed * (lift * u - drag * across), rel=1e-9)


def test_a_stalled_fin_has_no_lift_at_right_angles_and_is_continuous(block: Vehicle) -> None:
    start = (2.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    below, above = (push(block, RUDDER, start, 0.35 + d) for d in (-1e-6, 1e-6))
    assert below == pytest.approx(above, rel=1e-4)
    x, y, _ = push(block, RUDDER, start, np.pi / 2.0)
    assert abs(y) < 1e-6 and x < -30.0
    assert push(block, RUDDER, start, np.pi)[:2] == pytest.approx([0.0, 0.0], abs=1e-6)


def test_a_fin_stops_at_its_limit(block: Vehicle) -> None:
    start = (2.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    limited = replace(RUDDER, limit_rad=0.1)
    assert push(block, limited, start, 0.3) == pytest.approx(push(block, RUDDER, start, 0.1), rel=1e-12)


def test_fins_are_of_the_order_of_the_integrator(block: Vehicle) -> None:
    """Surge and the rudder's drag alone: u' = -k u2, exact 1/(1/u0 + k t)."""
    fin = replace(RUDDER, site="origin", axis=(0.0, 0.0, 1.0), drag=0.5)
    motion = flown(replace(free(block), fins=(fin,)), 500, (2.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    k = 0.5 * 1000.0 * 0.02 * 0.5 / 15.0
    expected = 1.0 / (0.5 + k * motion.time_s)
    assert motion.channels["centre"]["surge_m_s"] == pytest.approx(expected, rel=1e-8)


# --- steady force of a thruster ---------------------------------------------------------------------------------------
def test_steady_force_by_gain_curve_dead_band_and_limit() -> None:
    asked = np.array([-1.0, -0.05, 0.0, 0.3, 1.0])
    by_gain = Thruster("a", (1.0, 0.0, 0.0), 30.0, input="command", gain=40.0, dead_band=0.1)
    assert by_gain.force_N(asked) == pytest.approx([-30.0, 0.0, 0.0, 8.0, 30.0])
    by_speed = Thruster("a", (1.0, 0.0, 0.0), 1e3, input="rev_s", gain=0.5)
    assert by_speed.force_N(np.array([-4.0, 3.0])) == pytest.approx([-8.0, 4.5])
    by_curve = Thruster("a", (1.0, 0.0, 0.0), 99.0, input="command", curve=((-0.5, -4.0), (0.5, 6.0)))
    assert by_curve.force_N(asked) == pytest.approx([-4.0, 0.5, 1.0, 4.0, 6.0])


# --- recordings -------------------------------------------------------------------------------------------------------
COMMANDS = {"time_s": [0.0, 1.0, 2.0], "origin_N": [5.0, -3.0, 0.0]}


def recorded(block: Vehicle, sensor: Sensor, seed: int = 1, duration_s: float = 4.0, name: str = "surge_m_s"):
    """Times and values of a channel."""
    return fly_vehicle(replace(block, sensors=(sensor,)), COMMANDS, duration_s, seed).samples(f"{sensor.name}.{name}")


def test_latency_shifts_by_its_time(block: Vehicle) -> None:
    prompt = recorded(block, Sensor("log", ("surge_m_s",), rate_hz=10.0))
    late = recorded(block, Sensor("log", ("surge_m_s",), rate_hz=10.0, latency_s=0.3))
    assert late[0][0] == pytest.approx(0.3) and prompt[0].size == 41
    np.testing.assert_allclose(late[1], prompt[1][: late[1].size], atol=1e-12)


def test_rate_noise_and_lost_samples_are_as_the_file_says(block: Vehicle) -> None:
    calm = recorded(block, Sensor("log", ("surge_m_s",), rate_hz=50.0), duration_s=100.0)[1]
    noisy = recorded(block, Sensor("log", ("surge_m_s",), rate_hz=50.0, noise=(0.02,)), duration_s=100.0)
    assert noisy[0].size == 5001 and np.allclose(np.diff(noisy[0]), 0.02)
    assert np.std(noisy[1] - calm) == pytest.approx(0.02, rel=0.05)
    lossy = recorded(block, Sensor("log", ("surge_m_s",), rate_hz=50.0, dropout=0.25), duration_s=100.0)
    assert lossy[0].size == pytest.approx(0.75 * 5001, rel=0.04)


def test_a_seed_repeats_and_an_instrument_has_noise_of_its_own(block: Vehicle) -> None:
    sensor = Sensor("log", ("surge_m_s",), noise=(0.02,))
    one, again, other = (recorded(block, sensor, seed)[1] for seed in (1, 1, 2))
    assert np.array_equal(one, again) and not np.array_equal(one, other)
    both = fly_vehicle(replace(block, sensors=(replace(sensor, name="gps"), sensor)), COMMANDS, 4.0, 1)
    assert np.array_equal(both.samples("log.surge_m_s")[1], one)
    assert not np.array_equal(both.samples("gps.surge_m_s")[1], one)


def test_a_flight_is_a_recording_that_is_read_again(block: Vehicle, tmp_path: Path) -> None:
    down = {f"thruster_{number}_command": [0.5, 0.0] for number in (5, 6, 7, 8)}
    run = fly_vehicle("bluerov2", {"time_s": [0.0, 2.0], **down}, 5.0, seed=3)
    write_run(tmp_path / "flight.csv", run)
    back = read_run(tmp_path / "flight.csv")
    assert list(back.columns) == list(run.columns) and "dvl.heave_m_s" in back.columns
    assert back.samples("thruster_5_command")[1].tolist() == [0.5, 0.0]
    depth = back.samples("mocap.depth_m")[1]
    assert depth[-1] > depth[0] + 0.1
    assert "ping.range_m" not in back.columns  # nothing to hear in open water


def test_a_sonar_hears_the_wall_from_where_it_sits() -> None:
    vehicle = load_vehicle("phoenix")
    beams = (Sensor("ahead", ("range_m",), (1.0, 0.0, 0.0)), Sensor("port", ("range_m",), rotation_deg=(0, 0, -90.0)))
    run = fly_vehicle(replace(vehicle, sensors=beams), {"time_s": [0.0]}, 1.0, walls=models_dir() / "basin.xml")
    ahead, port = run.samples("ahead.range_m")[1][0], run.samples("port.range_m")[1][0]
    assert ahead == pytest.approx(10.0 * 0.3048 + 1.0668 - 1.0, abs=1e-6)
    assert port == pytest.approx(10.0 * 0.3048, abs=1e-6)


def test_waves_move_a_vehicle_as_their_seed_says(block: Vehicle) -> None:
    sea = Waves("irregular", height_m=0.1, period_s=3.0, water_depth_m=10.0)
    one, other = (
        fly_vehicle(replace(block, sensors=(CENTRE,)), {"time_s": [0.0]}, 5.0, seed, waves=sea) for seed in (1, 2)
    )
    difference = one.columns["centre.surge_m_s"] - other.columns["centre.surge_m_s"]
    assert np.abs(one.columns["centre.surge_m_s"]).max() > 0.005 and np.abs(difference).max() > 0.002


@pytest.mark.parametrize(
    ("commands", "said"),
    [
        ({"time_s": [0.0], "orgin_N": [1.0]}, "block has no input 'orgin_N'; did you mean 'origin_N'?"),
        ({"origin_N": [1.0]}, "no column time_s; found origin_N"),
        ({"time_s": [0.0, 0.0], "origin_N": [1.0, 2.0]}, "strictly increasing"),
        ({"time_s": [0.0, 1.0], "origin_N": [1.0]}, "origin_N: expected 2 finite numbers"),
        ({"time_s": [0.0], "origin_N": [np.nan]}, "origin_N: expected 1 finite numbers"),
    ],
)
def test_commands_that_do_not_fit_are_refused(block: Vehicle, commands: dict, said: str) -> None:
    with pytest.raises(InputError, match=said.replace("?", r"\?")):
        fly_vehicle(block, commands, 1.0)


def test_a_diverging_flight_is_an_input_error(block: Vehicle) -> None:
    wild = replace(block, quadratic_drag=np.array([1e9, 60.0, 80.0, 1.0, 1.0, 1.0]))
    with pytest.raises(InputError, match="the motion diverged after"):
        flown(wild, 200, (5.0, 0.0, 0.0, 0.0, 0.0, 0.0))


def test_surge_with_lag_and_drag_is_that_of_an_independent_integrator(block: Vehicle) -> None:
    lagging = replace(block, thrusters=(replace(block.thrusters[0], lag_s=0.2),))
    motion = flown(lagging, 300, origin_N=15.0)

    def rate(_: float, x: np.ndarray) -> list[float]:
        return [(x[1] - 30.0 * x[0] * abs(x[0])) / 15.0, (15.0 - x[1]) / 0.2]

    known = solve_ivp(rate, (0.0, 3.0), [0.0, 0.0], t_eval=motion.time_s, rtol=1e-10, atol=1e-12).y[0]
    assert motion.channels["centre"]["surge_m_s"] == pytest.approx(known, abs=1e-6)
