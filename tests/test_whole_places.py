"""Effects at places: each moves what its law says, by as much, and nothing else."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vtank.errors import InputError
from vtank.experiment import fly_vehicle
from vtank.plant import Sensor, Thruster, Vehicle, load_vehicle
from vtank.plant.vehicle import AXES
from vtank.record.table import Table
from vtank.resources import models_dir, scenarios_dir
from vtank.tank import forces, load_whole, places
from vtank.tank.model import rigid_mass, vehicle_body
from vtank.tank.places.catalogue import CATALOGUE, table
from vtank.tank.places.effect import Placed
from vtank.tank.places.read import read_placed

NU = np.array([0.5, -0.3, 0.2, 0.1, -0.2, 0.3])  # of every test, body axes [m/s, rad/s]
D2 = {axis: i for i, axis in enumerate(AXES)}
G = 9.80665
ASKED = {"one_rev_s": 4.0, "two_command": 0.5, "three_N": -6.0}  # 8 N, 10 N and -6 N
MJCF = """
<mujoco><option timestep="0.01" gravity="0 0 -9.80665"/><worldbody>
<body name="block" pos="0 0 -2" quat="0 1 0 0"><freejoint/>
<inertial mass="10" pos="0 0 0.01" diaginertia="0.4 0.5 0.6"/>
<site name="a" pos="-0.5 0.1 0.05"/><site name="b" pos="-0.5 -0.1 0.05"/><site name="c" pos="0.4 0 0.1"/>
</body></worldbody></mujoco>
"""


@pytest.fixture(scope="module")
def block(tmp_path_factory: pytest.TempPathFactory) -> Vehicle:
    """10 kg, drag and added mass of each axis its own, a thruster of each input, one fin, an instrument for all."""
    path = tmp_path_factory.mktemp("places") / "block.xml"
    path.write_text(MJCF, encoding="utf-8")
    fin = load_vehicle("remus100").fins[1]
    channels = ("surge_m_s", "sway_m_s", "heave_m_s", "heading_rad", "yaw_rate_rad_s", "accel_x_m_s2", "depth_m")
    return Vehicle(
        name="block",
        mjcf=path,
        mass_kg=10.0,
        added_mass=np.diag([5.0, 8.0, 12.0, 0.1, 0.2, 0.3]),
        quadratic_drag=np.array([30.0, 60.0, 80.0, 1.0, 1.5, 2.0]),
        linear_drag=np.array([3.0, 4.0, 5.0, 0.3, 0.4, 0.5]),
        buoyancy_N=10.0 * G,
        centre_of_buoyancy_m=np.zeros(3),
        propeller_sites=(),
        propeller_diameter_m=0.1,
        thrusters=(
            Thruster("a", (1.0, 0.0, 0.0), 50.0, name="one", input="rev_s", gain=0.5),
            Thruster("b", (1.0, 0.0, 0.0), 50.0, name="two", input="command", gain=20.0),
            Thruster("c", (0.0, 1.0, 0.0), 50.0, name="three"),
        ),
        fins=(replace(fin, name="rudder", site="a"),),
        sensors=(Sensor("imu", channels, rate_hz=100.0), Sensor("ping", ("range_m",))),
    )


def placed(vehicle: Vehicle, **entries: Mapping[str, object]) -> tuple[Placed, ...]:
    """Effects as a scenario would have them: name__place = {...}."""
    return read_placed(
        Table(Path("mine.toml"), "effects", {k.replace("__", "@"): v for k, v in entries.items()}), vehicle
    )


def wrench(vehicle: Vehicle, effects: tuple[Placed, ...] = (), nu: np.ndarray = NU, time_s: float = 0.0) -> np.ndarray:
    """All forces at a velocity, under ASKED, by the acceleration and the vehicle's own wet mass, (6,) [N, N m]."""
    whole, first = load_whole(vehicle, effects=effects), round(time_s / 0.01)
    asked = {key: np.full(first + 1, value) for key, value in ASKED.items()} | {"rudder_rad": np.full(first + 1, 0.1)}
    rows, flight = slice(first, first + 1), whole.flight(1, nu)
    flight.data.time, flight.data.ctrl[:] = time_s, whole.control(asked, rows)[0]
    flight.acting = {name: float(values[0]) for name, values in whole.acting(asked, rows).items()}
    with forces():
        flight.now()
    turn = flight.data.xmat[flight.body].reshape(3, 3)
    own = load_whole(vehicle).model
    mass = rigid_mass(own, vehicle_body(own)) + vehicle.added_mass
    acceleration = flight.data.qacc[flight.dof : flight.dof + 6]
    return mass @ np.concatenate([turn.T @ acceleration[:3], acceleration[3:]])


def along(axis: str, force: float) -> np.ndarray:
    out = np.zeros(6)
    out[AXES.index(axis)] = force
    return out


def at(place: tuple[float, float, float], force: tuple[float, float, float]) -> np.ndarray:
    return np.concatenate([force, np.cross(place, force)])


def drag(vehicle: Vehicle, i: int, u: float) -> float:
    return -(vehicle.linear_drag[i] + vehicle.quadratic_drag[i] * abs(u)) * u


A, B, C = (-0.5, 0.1, 0.05), (-0.5, -0.1, 0.05), (0.4, 0.0, 0.1)
u, v, w, p, q, r = NU
AXIS_CASES = [
    *(
        ("linear_drag", axis, {"c_N_s_per_m" if i < 3 else "c_N_m_s_per_rad": 2.0}, -2.0 * NU[i])
        for axis, i in D2.items()
    ),
    *(("coulomb_friction", axis, {"f_N" if i < 3 else "f_N_m": 0.7}, -0.7 * np.sign(NU[i])) for axis, i in D2.items()),
    *(("drag_asymmetry", axis, {"e": 0.3}, None) for axis in AXES),
    *(("ambient_current", axis, {"U_m_s" if i < 3 else "U_rad_s": 0.2}, None) for axis, i in D2.items()),
    *(("constant_force", axis, {"F_N" if i < 3 else "F_N_m": -1.5}, -1.5) for axis, i in D2.items()),
    ("munk_moment", "pitch", {"c_kg": 3.0}, 3.0 * u * w),
    ("munk_moment", "yaw", {"c_kg": 3.0}, -3.0 * u * v),
    ("coriolis", "surge", {"c_kg": 3.0}, 3.0 * v * r),
    ("coriolis", "sway", {"c_kg": 3.0}, -3.0 * u * r),
    ("coriolis", "heave", {"c_kg": 3.0}, 3.0 * u * q),
]


@pytest.mark.parametrize(("name", "axis", "values", "force"), AXIS_CASES)
def test_an_effect_of_an_axis_pushes_along_it_alone(block: Vehicle, name, axis, values, force) -> None:
    i = AXES.index(axis)
    if name == "drag_asymmetry":
        force = -0.3 * block.quadratic_drag[i] * NU[i] ** 2
    elif name == "ambient_current":
        force = drag(block, i, NU[i] - 0.2) - drag(block, i, NU[i])
    effects = placed(block, **{f"{name}__{axis}": values})
    assert wrench(block, effects) - wrench(block) == pytest.approx(along(axis, force), abs=1e-9)


def test_a_seiche_carries_drag_and_mass(block: Vehicle) -> None:
    effects = placed(block, seiche__sway={"amplitude_m_s": 0.2, "frequency_rad_s": 2.0, "phase_rad": 0.5})
    water, rate = 0.2 * math.sin(2.0 * 0.3 + 0.5), 0.4 * math.cos(2.0 * 0.3 + 0.5)
    force = drag(block, 1, v - water) - drag(block, 1, v) + 18.0 * rate
    assert wrench(block, effects, time_s=0.3) - wrench(block, time_s=0.3) == pytest.approx(
        along("sway", force), abs=1e-9
    )


THRUSTER_CASES = [
    ("thrust_deadband__one", {"n0_rev_s": 1.0}, at(A, (0.5 * 9.0 - 8.0, 0, 0))),
    ("thrust_deadband__two", {"n0": 0.1}, at(B, (-2.0, 0, 0))),
    ("thrust_deadband__three", {"n0_N": 1.0}, at(C, (0, 1.0, 0))),
    ("thrust_saturation__one", {"n_max_rev_s": 3.0}, at(A, (4.5 - 8.0, 0, 0))),
    ("thrust_saturation__three", {"n_max_N": 2.0}, at(C, (0, 4.0, 0))),
    ("thrust_asymmetry__one", {"e": 0.2}, at(A, (0, 0, 0))),
    ("thrust_asymmetry__three", {"e": 0.2}, at(C, (0, 1.2, 0))),
    ("supply_sag__one", {"r_per_s": 0.1}, at(A, (8.0 * math.expm1(-0.1), 0, 0))),
    ("tachometer_bias__one", {"b_rev_s": 1.0}, at(A, (4.5 - 8.0, 0, 0))),
    ("thruster_dead__two", {}, at(B, (-10.0, 0, 0))),
    ("thruster_dead__two", {"share": 0.25}, at(B, (-2.5, 0, 0))),
    ("thruster_reversed__three", {}, at(C, (0, 12.0, 0))),
    ("thruster_turned__two", {"yaw_rad": 0.3}, at(B, (10.0 * (math.cos(0.3) - 1), 10.0 * math.sin(0.3), 0))),
    ("thruster_turned__two", {"pitch_rad": 0.3}, at(B, (10.0 * (math.cos(0.3) - 1), 0, -10.0 * math.sin(0.3)))),
    ("thrust_loss__two", {"gamma_N_s_per_m": 3.0}, at(B, (-3.0 * 0.5 * (u + q * 0.05 + r * 0.1), 0, 0))),
    ("thrust_loss__three", {"gamma_s_per_m": 0.5}, at(C, (0, -0.5 * 6.0 * (v + r * 0.4 - p * 0.1), 0))),
]


@pytest.mark.parametrize(("key", "values", "expected"), THRUSTER_CASES)
def test_an_effect_of_a_thruster_changes_its_force_alone(block: Vehicle, key, values, expected) -> None:
    """At the time 1 s, with all three thrusters at work."""
    effects = placed(block, **{key: values})
    assert wrench(block, effects, time_s=1.0) - wrench(block, time_s=1.0) == pytest.approx(expected, abs=1e-9)


def test_effects_of_one_thruster_act_in_their_order_whatever_the_file_has(block: Vehicle) -> None:
    """What is read less its bias, less the dead band, and then the force fades: 0.5 (4 - 1 - 0.5)^2 (1 - 0.2)."""
    entries = {
        "thruster_dead__one": {"share": 0.2},
        "thrust_deadband__one": {"n0_rev_s": 0.5},
        "tachometer_bias__one": {"b_rev_s": 1.0},
    }
    for keys in (list(entries), list(entries)[::-1]):
        whole = load_whole(block, effects=placed(block, **{key: entries[key] for key in keys}))
        assert whole.control({"one_rev_s": np.array([4.0])})[0, 0] == pytest.approx(0.5 * 2.5**2 * 0.8)


def test_exchanged_inputs_push_at_each_others_place(block: Vehicle) -> None:
    alike = replace(block, thrusters=tuple(replace(t, input="N", gain=1.0) for t in block.thrusters))
    whole = load_whole(alike, effects=placed(alike, wrong_allocation__one={"other": "three"}))
    asked = {"one_N": np.array([1.0]), "two_N": np.array([2.0]), "three_N": np.array([3.0])}
    assert whole.control(asked)[0, :3].tolist() == [3.0, 2.0, 1.0]


def test_a_delay_shifts_one_input_by_its_time(block: Vehicle) -> None:
    whole = load_whole(block, effects=placed(block, command_delay__two={"d_s": 0.025}, fin_delay__rudder={"d_s": 0.01}))
    steps = {"two_command": np.array([0, 0, 1.0, 1, 1, 1]), "one_rev_s": np.ones(6), "rudder_rad": np.arange(6.0) / 100}
    control = whole.control(steps)
    assert control[:, 1] == pytest.approx(20.0 * np.array([0, 0, 0, 0, 0.5, 1.0]))
    assert control[:, 0] == pytest.approx(np.full(6, 0.5)) and control[:, 3] == pytest.approx(
        [0, 0, 0.01, 0.02, 0.03, 0.04]
    )


def test_a_longer_lag_is_the_thrusters_own(block: Vehicle) -> None:
    """Without drag the speed under constant thrust is F/m (t - tau (1 - exp(-t/tau)))."""
    still = replace(block, thrusters=block.thrusters[:1], fins=(), linear_drag=np.zeros(6), quadratic_drag=np.zeros(6))
    still = replace(still, thrusters=(replace(still.thrusters[0], direction=(0.0, 0.0, 1.0), site="c"),))
    whole = load_whole(still, effects=placed(still, thrust_lag__one={"tau_s": 0.4}))
    motion = whole.fly(whole.control({"one_rev_s": np.full(3, 4.0)}))
    early = 8.0 / 22.0 * (0.02 + 0.4 * np.expm1(-0.02 / 0.4))
    # a force at (0.4, 0, 0.1) turns the hull too; in 0.02 s that is of third order
    assert motion.channels["imu"]["heave_m_s"][2] == pytest.approx(early, rel=1e-2)


def test_a_fin_at_an_angle_and_a_fin_that_is_smaller(block: Vehicle) -> None:
    own, none = wrench(block), wrench(replace(block, fins=()))
    weak = wrench(block, placed(block, fin_weak__rudder={"share": 0.4}))
    assert weak - none == pytest.approx(0.6 * (own - none), rel=1e-9)
    (drag,) = placed(block, fin_drag__rudder={"k_N_s2_per_m2": 5.0})
    flown = load_whole(block).vehicle
    seat, turning = np.array(flown.sites[flown.fins[0].site]), np.array([0.0, 0.0, 0.2])
    s = SimpleNamespace(
        vehicle=flown, through=np.array([1.5, 0.2, 0.1, *turning]), nu=np.array([0.0, 0.0, 0.0, *turning]),
        asked={"rudder": -0.3},
    )  # fmt: skip
    ahead = 1.5 + np.cross(turning, seat)[0]
    pull = np.array([-5.0 * (ahead * np.sin(0.3)) ** 2, 0.0, 0.0])
    assert drag.effect.wrench(s, "rudder", drag.values) == pytest.approx([*pull, *np.cross(seat, pull)])
    whole = load_whole(block, effects=placed(block, fin_offset__rudder={"angle_rad": 0.05}))
    assert whole.control({"rudder_rad": np.array([0.1])})[0, 3:5] == pytest.approx([0.15, 0.15])


# --- the vehicle itself -----------------------------------------------------------------------------------------------
def test_centres_and_buoyancy(block: Vehicle) -> None:
    here = wrench(block)
    shifted = wrench(block, placed(block, centre_of_buoyancy__vehicle={"x_m": 0.02, "z_m": -0.03}))
    assert shifted - here == pytest.approx(np.r_[0, 0, 0, np.cross((0.02, 0.0, -0.03), (0, 0, -98.0665))], abs=1e-9)
    light = wrench(block, placed(block, buoyancy__vehicle={"B_N": 2.0}))
    assert light - here == pytest.approx(along("heave", -2.0), abs=1e-9)


def test_a_shifted_centre_of_gravity_pulls_and_couples(block: Vehicle) -> None:
    whole = load_whole(block, effects=placed(block, centre_of_gravity__vehicle={"x_m": 0.05, "y_m": -0.02}))
    rigid = rigid_mass(whole.model, vehicle_body(whole.model))
    x, y, z = 0.05, -0.02, 0.01
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    assert rigid[3:, :3] == pytest.approx(10.0 * cross, abs=1e-9) and rigid[0, 0] == pytest.approx(10.0)
    assert np.linalg.eigvalsh(rigid[3:, 3:] + 10.0 * cross @ cross) == pytest.approx([0.4, 0.5, 0.6])
    assert load_whole(block).model.nbody == whole.model.nbody


def test_a_trim_weight_weighs_and_has_inertia(block: Vehicle) -> None:
    effects = placed(block, trim_weight__vehicle={"m_kg": 0.5, "x_m": 0.3})
    whole, own = load_whole(block, effects=effects), load_whole(block)
    more = rigid_mass(whole.model, vehicle_body(whole.model)) - rigid_mass(own.model, vehicle_body(own.model))
    assert more[0, 0] == pytest.approx(0.5) and more[5, 1] == pytest.approx(0.15) and more[4, 2] == pytest.approx(-0.15)
    flight = whole.flight(1)
    with forces():
        flight.now()
    mass = rigid_mass(whole.model, vehicle_body(whole.model)) + block.added_mass
    turn = np.diag([1.0, -1.0, -1.0])
    pulled = mass @ np.concatenate([turn @ flight.data.qacc[:3], flight.data.qacc[3:]])
    assert pulled == pytest.approx(at((0.3, 0.0, 0.0), (0, 0, 0.5 * G)), abs=1e-8)


def test_coriolis_terms_left_out(block: Vehicle) -> None:
    """Kirchhoff's terms of a diagonal added mass, Munk moments among them."""
    a, b, c, d, e, f = np.diag(block.added_mass)
    added = np.array(
        [q * c * w - r * b * v, r * a * u - p * c * w, p * b * v - q * a * u,
         (c - b) * v * w + (f - e) * q * r, (a - c) * u * w + (d - f) * p * r, (b - a) * u * v + (e - d) * p * q]
    )  # fmt: skip
    half = wrench(block, placed(block, coriolis_left_out__vehicle={"share": 0.5}))
    assert half - wrench(block) == pytest.approx(0.5 * added, abs=1e-9)


def test_cross_flow_drag_is_that_of_strips(block: Vehicle) -> None:
    effects = placed(
        block,
        cross_flow_drag__vehicle={"sway_N_s2_per_m3": 40.0, "heave_N_s2_per_m3": 60.0, "tail_m": -0.6, "nose_m": 0.5},
    )
    x = np.linspace(-0.6, 0.5, 200001)
    across, down = v + x * r, w - x * q
    y, z = -40.0 * np.hypot(across, down) * across, -60.0 * np.hypot(across, down) * down
    strips = [0.0, np.trapezoid(y, x), np.trapezoid(z, x), 0.0, np.trapezoid(-x * z, x), np.trapezoid(x * y, x)]
    assert wrench(block, effects) - wrench(block) == pytest.approx(np.array(strips), abs=1e-4)


def test_a_current_is_that_of_the_water(block: Vehicle) -> None:
    """It carries a hull that drags alike both ways: at rest the force is that of moving at the opposite speed."""
    effects = placed(block, current__vehicle={"north_m_s": 0.3, "east_m_s": -0.2})
    finless = replace(block, fins=())
    still = wrench(finless, effects, np.zeros(6)) - wrench(finless, nu=np.zeros(6))
    munk = [0.0, 0.0, (8.0 - 5.0) * 0.3 * 0.2]  # N = -(B - A) u_r v_r, u_r = -0.3, v_r = 0.2
    assert still == pytest.approx([-drag(block, 0, 0.3), -drag(block, 1, -0.2), 0.0, *munk], abs=1e-9)
    run = fly_vehicle(block, {"time_s": [0.0]}, 60.0, effects=effects)
    ends = [run.samples(f"imu.{channel}")[1][-1] for channel in ("surge_m_s", "sway_m_s")]
    assert np.hypot(*ends) == pytest.approx(np.hypot(0.3, 0.2), abs=0.01)


def test_a_tether_pulls_where_it_is_made_fast(block: Vehicle) -> None:
    values = {"north_N": 2.0, "east_N": 1.0, "down_N": -0.5, "x_m": 0.4, "k_N_per_m": 50.0}
    pulled = wrench(block, placed(block, tether__vehicle=values)) - wrench(block)
    assert pulled == pytest.approx(at((0.4, 0.0, 0.0), (2.0, 1.0, -0.5)), abs=1e-9)


@pytest.mark.parametrize(
    ("key", "values"), [("tether__vehicle", {"k_N_per_m": 60.0}), ("tether__surge", {"k_N_per_m": 60.0})]
)
def test_a_spring_swings_with_its_frequency(block: Vehicle, key: str, values: dict) -> None:
    """Without drag, from 0.1 m/s ahead: x = u/w sin(w t), w2 = k/(m + m_A)."""
    free = replace(block, fins=(), linear_drag=np.zeros(6), quadratic_drag=np.zeros(6))
    whole = load_whole(free, effects=placed(free, **{key: values}))
    motion = whole.fly(np.zeros((200, whole.model.nu)), (0.1, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert motion.channels["imu"]["surge_m_s"] == pytest.approx(0.1 * np.cos(2.0 * motion.time_s), abs=5e-4)


def test_a_tether_of_yaw_turns_back_beyond_half_a_turn(block: Vehicle) -> None:
    free = replace(block, fins=(), linear_drag=np.zeros(6), quadratic_drag=np.zeros(6))
    whole = load_whole(free, effects=placed(free, tether__yaw={"k_N_m_per_rad": 0.09}))
    motion = whole.fly(np.zeros((500, whole.model.nu)), (0.0, 0.0, 0.0, 0.0, 0.0, 1.5))
    # I + I_A = 0.9: w2 = 0.1, and the turn reaches 4.7 rad
    w_yaw = np.sqrt(0.1)
    assert motion.channels["imu"]["yaw_rate_rad_s"] == pytest.approx(1.5 * np.cos(w_yaw * motion.time_s), abs=2e-3)


def test_the_wake_takes_its_time_and_lessens_drag(block: Vehicle) -> None:
    """Held at a speed by a large mass: the drag goes from that of u to that of (1 - k) u within some T."""
    heavy = replace(block, fins=(), added_mass=np.diag([1e7] * 6))
    whole = load_whole(heavy, effects=placed(heavy, wake_memory__surge={"k": 0.4, "T_s": 0.5}))
    bare = load_whole(heavy)
    start = (0.5, 0.0, 0.0, 0.0, 0.0, 0.0)
    rates = [
        np.diff(each.fly(np.zeros((300, each.model.nu)), start).channels["imu"]["surge_m_s"]) for each in (whole, bare)
    ]
    wake = 0.4 * 0.5 * -np.expm1(-0.01 * np.arange(299) / 0.5)
    expected = [(drag(block, 0, 0.5 - each) - drag(block, 0, 0.5)) / 1e7 * 0.01 for each in wake]
    assert rates[0] - rates[1] == pytest.approx(np.array(expected), abs=0.05 * max(expected))


# --- sensors ----------------------------------------------------------------------------------------------------------
AHEAD = {"time_s": [0.0], "one_rev_s": [4.0], "two_command": [0.5], "three_N": [1.0]}


def read(block: Vehicle, channel: str, **effects: Mapping[str, object]) -> tuple[np.ndarray, np.ndarray]:
    run = fly_vehicle(block, AHEAD, 3.0, seed=1, effects=placed(block, **effects))
    return run.samples(f"imu.{channel}")


SENSOR_CASES = [
    ("sensor_scale__imu", {"s": 0.1}, {"surge_m_s": lambda z: 1.1 * z, "depth_m": lambda z: 1.1 * z}),
    ("sensor_scale__imu", {"s": 0.1, "channel": "depth_m"}, {"depth_m": lambda z: 1.1 * z}),
    ("wrong_unit__imu", {"factor": 3.28, "channel": "surge_m_s"}, {"surge_m_s": lambda z: 3.28 * z}),
    ("wrong_sign__imu", {"channel": "yaw_rate_rad_s"}, {"yaw_rate_rad_s": lambda z: -z}),
    ("gyro_bias__imu", {"yaw_rad_s": 0.05}, {"yaw_rate_rad_s": lambda z: z + 0.05}),
    ("accelerometer_bias__imu", {"x_m_s2": 0.2}, {"accel_x_m_s2": lambda z: z + 0.2}),
    ("magnetometer_bias__imu", {"b_rad": 0.1}, {"heading_rad": lambda z: (z + 0.1 + np.pi) % (2 * np.pi) - np.pi}),
    ("depth_offset__imu", {"o_m": 0.3}, {"depth_m": lambda z: z + 0.3}),
]


@pytest.mark.parametrize(("key", "values", "changed"), SENSOR_CASES)
def test_an_effect_of_a_sensor_changes_what_it_reads_alone(block: Vehicle, key, values, changed) -> None:
    one, other = (
        fly_vehicle(block, AHEAD, 2.0, seed=1, effects=effects) for effects in ((), placed(block, **{key: values}))
    )
    every = len(changed) > 1
    for channel in block.sensors[0].channels:
        true, found = one.samples(f"imu.{channel}")[1], other.samples(f"imu.{channel}")[1]
        if channel in changed or every and channel not in ("heading_rad",):
            assert found == pytest.approx(
                next(iter(changed.values()))(true) if every else changed[channel](true), abs=1e-12
            )
        elif not every:
            assert np.array_equal(found, true), channel


def test_a_sonar_that_is_off_hears_the_wall_elsewhere(block: Vehicle) -> None:
    walls = {"walls": models_dir() / "basin.xml", "depth_m": 1.0}
    effects = placed(block, sonar_offset__ping={"o_m": 0.2})
    one, other = (
        fly_vehicle(block, {"time_s": [0.0]}, 1.0, effects=e, **walls).samples("ping.range_m")[1] for e in ((), effects)
    )
    assert other - one == pytest.approx(np.full(11, 0.2), abs=1e-12)


def test_outliers_of_a_sonar_and_of_a_tachometer(block: Vehicle) -> None:
    """As many as their probability says, of their size, and nothing else moves."""
    walls = {"walls": models_dir() / "basin.xml", "depth_m": 1.0}
    asked = {"time_s": np.arange(0.0, 20.0, 0.1), "two_command": np.full(200, 0.01)}
    effects = placed(
        block, sonar_multipath__ping={"p": 0.1, "extra_m": 0.5}, tachometer_spikes__two={"p": 0.2, "size": 0.3}
    )
    one, other = (fly_vehicle(block, asked, 19.9, effects=e, **walls) for e in ((), effects))
    long = other.samples("ping.range_m")[1] - one.samples("ping.range_m")[1]
    spikes = other.samples("two_command")[1] - 0.01
    for off, size, share in ((long, 0.5, 0.1), (spikes, 0.3, 0.2)):
        far = np.abs(off) > 1e-9
        assert np.abs(off[far]) == pytest.approx(size) and far.mean() == pytest.approx(share, abs=0.07)
    assert np.array_equal(one.samples("imu.surge_m_s")[1], other.samples("imu.surge_m_s")[1])


def test_a_late_sensor_and_two_clocks(block: Vehicle) -> None:
    time_s, true = read(block, "surge_m_s")
    for effects, instant in (
        ({"sensor_latency__imu": {"d_s": 0.25}}, lambda t: t - 0.25),
        ({"clock_skew__imu": {"s": 0.02}}, lambda t: 1.02 * t),
        ({"clock_offset__imu": {"o_s": 0.2}}, lambda t: t - 0.2),
        ({"clock_offset__imu": {"o_s": -0.2}}, lambda t: t + 0.2),
    ):
        at_s, found = read(block, "surge_m_s", **effects)
        assert found.size > 250
        assert found == pytest.approx(np.interp(instant(at_s), time_s, true), abs=1e-9)
        assert instant(at_s).min() >= -1e-9 and instant(at_s).max() <= 3.0 + 1e-9


def test_a_turned_and_a_displaced_sensor(block: Vehicle) -> None:
    names = ("surge_m_s", "sway_m_s", "heave_m_s")
    true, turned, moved = (
        np.array([read(block, name, **effects)[1] for name in names])
        for effects in (
            {},
            {"sensor_rotated__imu": {"yaw_rad": 0.3, "pitch_rad": 0.1}},
            {"sensor_displaced__imu": {"x_m": 0.4}},
        )
    )
    c, s = np.cos([0.3, 0.1]), np.sin([0.3, 0.1])
    yaw = np.array([[c[0], s[0], 0.0], [-s[0], c[0], 0.0], [0.0, 0.0, 1.0]])
    pitch = np.array([[c[1], 0.0, -s[1]], [0.0, 1.0, 0.0], [s[1], 0.0, c[1]]])
    assert turned == pytest.approx(pitch @ yaw @ true, abs=1e-9)
    rate = read(block, "yaw_rate_rad_s")[1]
    assert (moved - true)[1] == pytest.approx(0.4 * rate, abs=1e-9)


def test_velocity_in_earth_axes(block: Vehicle) -> None:
    """Whatever way the sensor itself is turned: north, east and down."""
    names, pose = ("surge_m_s", "sway_m_s", "heave_m_s"), ("north_m", "east_m", "depth_m")
    sensors = (Sensor("imu", names, rotation_deg=(10.0, 20.0, 30.0)), Sensor("mocap", pose))
    turned = replace(block, sensors=sensors)
    whole = load_whole(turned, effects=placed(turned, earth_axes__imu={}))
    motion = whole.fly(np.zeros((300, whole.model.nu)), tuple(NU))
    velocity = np.array([motion.channels["imu"][name] for name in names])
    place = np.array([motion.channels["mocap"][name] for name in pose])
    assert velocity[:, 1:-1] == pytest.approx((place[:, 2:] - place[:, :-2]) / 0.02, abs=1e-4)


def test_a_wall_ahead_drags_and_keeps_the_energy_that_its_mass_takes(block: Vehicle) -> None:
    """Half (m + m_A + dm(x)) u^2 stays as it is where nothing drags, and the drag is a share of the hull's."""
    (wall,) = placed(block, wall_proximity__surge={"mass": 0.3})
    (rough,) = placed(block, wall_proximity__surge={"drag": 0.5})
    kg = block.mass_kg + block.added_mass[0, 0]

    def near(gap_m: float, speed: float) -> SimpleNamespace:
        velocity = np.array([speed, 0.0, 0.0, 0.0, 0.0, 0.0])
        return SimpleNamespace(gap_m=gap_m, nu=velocity, through=velocity, vehicle=block)

    def moving(_: float, y: np.ndarray) -> list[float]:
        s = near(4.0 - y[0], y[1])
        return [y[1], wall.effect.wrench(s, "surge", wall.values)[0] / (kg + wall.effect.heavier(s, wall.values))]

    start, end = (solve_ivp(moving, (0.0, 6.0), [0.0, 0.4], rtol=1e-10, atol=1e-12).y[:, k] for k in (0, -1))
    energy = [(kg + wall.effect.heavier(near(4.0 - x, u), wall.values)) * u * u for x, u in (start, end)]
    assert end[0] > 1.5 and end[1] < 0.36 and energy[1] == pytest.approx(energy[0], rel=1e-8)
    assert rough.effect.wrench(near(1.5, -0.4), "surge", rough.values) == pytest.approx(
        along("surge", 0.5 * 8.0 * block.quadratic_drag[0] * 0.16)
    )


# --- the catalogue and the file ---------------------------------------------------------------------------------------
def test_every_effect_has_a_test_here() -> None:
    text = Path(__file__).read_text(encoding="utf-8")
    assert not [e.name for e in CATALOGUE if f"{e.name}__" not in text and f'"{e.name}", ' not in text]


def test_the_table_of_the_scenarios_is_current() -> None:
    assert table() in (scenarios_dir() / "README.md").read_text(encoding="utf-8")


def test_an_effect_does_something_and_its_law_has_its_numbers() -> None:
    for effect in CATALOGUE:
        acts = (
            effect.changes,
            effect.rigid,
            effect.input,
            effect.delay,
            effect.thrust,
            effect.wrench,
            effect.recorded,
            effect.drifts,
        )
        assert any(acts) or effect.text == "other", effect.name
        assert effect.law


def test_each_effect_has_a_file_of_its_name_in_the_folder_of_its_kind() -> None:
    folder = Path(places.__file__).parent
    files = {path.relative_to(folder) for path in folder.glob("*/*.py") if "EFFECT = " in path.read_text("utf-8")}
    assert files == {Path(effect.kind) / f"{effect.name}.py" for effect in CATALOGUE} and len(files) == len(CATALOGUE)


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ({"linear_dragg__surge": {"c_N_s_per_m": 1.0}}, "no effect 'linear_dragg'; did you mean 'linear_drag'?"),
        ({"linear_drag__surg": {"c_N_s_per_m": 1.0}}, "found the place 'surg'; did you mean 'surge'?"),
        (
            {"linear_drag__yaw": {"c_N_s_per_m": 1.0}},
            "wrong unit: expected 'c_N_m_s_per_rad' [N m s/rad], found 'c_N_s_per_m' [N s/m]",
        ),
        ({"linear_drag": {"c_N_s_per_m": 1.0}}, "expected linear_drag@PLACE"),
        ({"thrust_deadband__thre": {"n0": 1.0}}, "did you mean 'three'? there are: one, two, three"),
        ({"thrust_deadband__one": {"n0": 1.0}}, "thrust_deadband@one.n0: wrong unit: expected 'n0_rev_s' [rev/s]"),
        (
            {"wrong_allocation__one": {"other": "two"}},
            "wrong_allocation@one: block has no other thruster that takes rev_s",
        ),
        ({"depth_offset__ping": {"o_m": 1.0}}, "'ping' measures none of depth_m"),
        ({"sensor_scale__imu": {"s": 0.1, "channel": "roll_rad"}}, "expected one of , surge_m_s"),
        ({"gyro_bias__imu": {"roll_rad_s": 0.1}}, "gyro_bias@imu.roll_rad_s: 'imu' does not measure roll_rate_rad_s"),
        ({"gyro_bias__imu": {}}, "does nothing so; expected one of roll_rad_s"),
        ({"seiche__yaw": {"amplitude_m_s": 1.0}}, "found the place 'yaw'"),
    ],
)
def test_an_effect_that_cannot_be_is_refused(block: Vehicle, entries: dict, said: str) -> None:
    with pytest.raises(InputError) as caught:
        placed(block, **entries)
    assert said in str(caught.value) and "mine.toml: effects." in str(caught.value)
