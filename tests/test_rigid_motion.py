"""The rigid body in six degrees of freedom: against equations written out once more, and against MuJoCo's tank."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vtank.experiment.whole import fly_vehicle
from vtank.plant.vehicle import load_vehicle
from vtank.rigid.filtered import free, innovations
from vtank.rigid.layout import G
from vtank.rigid.motion import rates
from vtank.rigid.recorded import Recorded
from vtank.rigid.recordings import record

AHEAD = {"bluerov2": 8.0, "remus100": 20.0, "kingfisher": 0.5}


def skew(v):
    x, y, z = v
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def coriolis_matrix(M, nu):
    """Fossen (2011), theorem 3.2: C(nu) from any symmetric M."""
    v, w = nu[:3], nu[3:]
    a, b = M[:3, :3] @ v + M[:3, 3:] @ w, M[3:, :3] @ v + M[3:, 3:] @ w
    return np.block([[np.zeros((3, 3)), -skew(a)], [-skew(a), -skew(b)]])


def turn(roll, pitch, heading):
    cx, sx, cy, sy, cz, sz = (f(a) for a in (roll, pitch, heading) for f in (np.cos, np.sin))
    Rx = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    Ry = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    Rz = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return Rz @ Ry @ Rx


def multisine(vehicle, duration_s: float, seed: int) -> dict[str, np.ndarray]:
    """Commands at 5 Hz that excite every axis and keep the vehicle upright: thrusters that lift work nearly alike."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, duration_s, 0.2)
    table = {"time_s": time}
    most = {"command": 0.5, "rev_s": 20.0, "N": 10.0}

    def some() -> np.ndarray:
        return sum(np.sin(w * time + rng.uniform(0, 7)) for w in rng.uniform(0.3, 2.0, 3))

    lift = some()
    for thruster in vehicle.thrusters:
        waves = 0.8 * lift + 0.05 * some() if thruster.direction[2] else some()
        table[thruster.column] = most[thruster.input] / 3.0 * waves
    for fin in vehicle.fins:
        if fin.limit_rad:
            table[fin.column] = 0.1 * np.sin(0.7 * time + rng.uniform(0, 7))
    return table


def flown(name: str, duration_s: float = 20.0, seed: int = 1, vehicle=None) -> Recorded:
    """A run of the tank as the estimators see it."""
    nominal = load_vehicle(name)
    run = fly_vehicle(vehicle or nominal, multisine(nominal, duration_s, seed), duration_s, seed)
    return record([run], nominal)[1][0]


@pytest.fixture(scope="module")
def rov() -> Recorded:
    return flown("bluerov2")


def test_rates_are_those_of_the_matrix_equations_on_random_states(rov):
    rng, p, vehicle = np.random.default_rng(2), rov.layout.null.copy(), rov.layout.vehicle
    current = np.array([0.2, -0.1, 0.05])
    p[rov.layout.at(["current_north@hull", "current_east@hull", "current_down@hull"])] = current
    p[rov.layout.at(["waterline@heave"])] = k = 70.0  # [N/m]
    hull, out, worst = rov.hull(p), np.empty(18), 0.0
    m, centre = vehicle.mass_kg, np.array(vehicle.centre_m)
    M_RB = np.block([[m * np.eye(3), -m * skew(centre)],
                     [m * skew(centre), np.diag(vehicle.inertia) - m * skew(centre) @ skew(centre)]])  # fmt: skip
    for _ in range(200):
        x = np.concatenate([rng.normal(size=3), rng.uniform(-1.2, 1.2, 2), rng.uniform(-3, 3, 1), rng.normal(size=6),
                            np.zeros(6)])  # fmt: skip
        thrust = 5.0 * rng.normal(size=6)
        rates(0.0, x, thrust, np.zeros(8), np.zeros(0), np.zeros(6), np.zeros(6), hull, out)
        R, nu = turn(*x[3:6]), x[6:12]
        U = np.r_[R.T @ current, np.zeros(3)]
        nu_r, down = nu - U, R.T @ [0.0, 0.0, 1.0]
        drag = -(vehicle.linear_drag + vehicle.quadratic_drag * np.abs(nu_r)) * nu_r
        W, B, r_B = m * G, vehicle.buoyancy_N, vehicle.centre_of_buoyancy_m
        held = np.r_[(W - B - k * x[2]) * down, W * np.cross(centre, down) - B * np.cross(r_B, down)]
        dU = np.r_[-np.cross(nu[3:], U[:3]), np.zeros(3)]
        right = thrust + drag + held - coriolis_matrix(M_RB, nu) @ nu
        right += -coriolis_matrix(vehicle.added_mass, nu_r) @ nu_r + vehicle.added_mass @ dU
        expected = np.linalg.solve(M_RB + vehicle.added_mass, right)
        worst = max(worst, float(np.abs(out[6:12] - expected).max() / np.abs(expected).max()))
        np.testing.assert_allclose(out[:3], R @ nu[:3], atol=1e-12)
    assert worst < 1e-11


def heavy(name: str):
    """A craft that sits deeper than its waterline and is not trimmed, so that its waterline lifts and pitches it."""
    vehicle = load_vehicle(name)
    return replace(vehicle, buoyancy_N=0.9 * vehicle.buoyancy_N, centre_of_buoyancy_m=np.array([0.1, 0.0, -0.5]))


@pytest.mark.parametrize("name, made", [("bluerov2", load_vehicle), ("remus100", load_vehicle),
                                        ("kingfisher", load_vehicle), ("kingfisher", heavy)])  # fmt: skip
def test_what_the_tank_flies_is_foretold_within_the_noise_of_its_instruments(name, made):
    """MuJoCo with its own quaternions, actuators and sensors, and these equations, over 6 s from the first samples."""
    vehicle = made(name)
    run = record([fly_vehicle(vehicle, multisine(vehicle, 6.0, 1), 6.0, 1)], vehicle)[1][0]
    start = np.zeros(12)
    start[2] = run.start[2]
    quiet = Recorded(
        **{**{key: getattr(run, key) for key in run.__dataclass_fields__ if key[0] != "_"}, "start": start}
    )
    e = innovations(quiet, run.layout.null, free(run))
    noise = {f"{s.name}.{c}": sd for s in vehicle.sensors for c, sd in zip(s.channels, s.noise, strict=True)}
    for c, column in enumerate(run.layout.columns):
        mine = run.column == c
        off = e[mine] - e[mine].mean() if "depth" in column else e[mine]  # where it begins, one sample tells
        assert np.sqrt(np.mean(off**2)) < 1.25 * noise[column], column


def test_known_motion_of_an_axis_is_taken_from_its_recording(rov):
    vehicle = rov.layout.vehicle
    run = fly_vehicle(vehicle, multisine(vehicle, 20.0, 1), 20.0, 1)
    layout, (alone,), notes = record([run], vehicle, ["surge"])
    assert alone.asked.tolist() == [True] + [False] * 5
    assert {*layout.columns} - layout.followed == {"dvl.surge_m_s", "imu.accel_x_m_s2"}
    assert "dvl.sway_m_s" in layout.followed and "depth.depth_m" not in layout.columns
    assert any("sway" in note and "known" in note for note in notes)
    e = innovations(alone.as_measured(), layout.null, free(alone))
    speed = alone.column == layout.columns.index("dvl.surge_m_s")
    assert np.sqrt(np.mean(e[speed] ** 2)) < 0.01  # [m/s] of 0.005 of noise and a speed of 0.3


def test_a_run_starts_where_the_origin_is_whatever_sits_elsewhere_tells_of_it():
    """A depth cell 0.7 m below the origin of a hull at a roll of 0.5 rad, and a speed log 2 m ahead of it, turning."""
    vehicle = load_vehicle("bluerov2")
    seats = {"depth": (0.0, 0.0, 0.7), "dvl": (2.0, 0.0, 0.0)}
    off = tuple(replace(s, position_m=seats.get(s.name, s.position_m)) for s in vehicle.sensors)
    run = fly_vehicle(vehicle, multisine(vehicle, 5.0, 1), 5.0, 1)
    told = {"ahrs.roll_rad": 0.5, "ahrs.pitch_rad": 0.0, "ahrs.heading_rad": 1.0, "depth.depth_m": 3.0,
            "imu.yaw_rate_rad_s": 0.2, "dvl.sway_m_s": 0.5}  # fmt: skip
    columns = {name: x for name, x in run.columns.items() if "." not in name}
    columns |= {name: np.full(run.time_s.size, value) for name, value in told.items()}
    _, (recorded,), _ = record([replace(run, columns=columns)], replace(vehicle, sensors=off))
    assert recorded.start[2] == pytest.approx(3.0 - 0.7 * np.cos(0.5), abs=1e-6)
    assert recorded.start[7] == pytest.approx(0.5 - 0.2 * 2.0, abs=1e-6)
    _, (known,), _ = record([replace(run, columns=columns)], replace(vehicle, sensors=off), ("heave",))
    assert known.start[7] == pytest.approx(0.5 - 0.2 * 2.0, abs=1e-6), "known motion is the origin's already"
