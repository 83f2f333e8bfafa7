"""Vehicles made at random, afloat and below: what the tank flies is what the estimators' equations foretell."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vtank.experiment.whole import fly_vehicle
from vtank.plant.actuators import Fin, Thruster
from vtank.plant.sensor import Sensor
from vtank.plant.vehicle import Vehicle
from vtank.record import Run
from vtank.rigid import recorded
from vtank.rigid.filtered import Noise, free, innovations
from vtank.rigid.fit import Fit
from vtank.rigid.layout import G
from vtank.rigid.recordings import record

NOISE = 1e-6  # [m, rad, m/s, rad/s]: what is left is the steps of two integrators
MOTION = ("north_m", "east_m", "depth_m", "roll_rad", "pitch_rad", "heading_rad", "surge_m_s", "sway_m_s", "heave_m_s",
          "roll_rate_rad_s", "pitch_rate_rad_s", "yaw_rate_rad_s")  # fmt: skip
MJCF = """<mujoco><option timestep="0.005" integrator="RK4"/><worldbody><body name="made" pos="0 0 {z}" quat="0 1 0 0">
<freejoint/><inertial mass="{m}" pos="{centre}" diaginertia="{inertia}"/>{sites}</body></worldbody></mujoco>"""
MOST = {"command": 0.6, "rev_s": 15.0, "N": 7.0}


def made(path: Path, seed: int, afloat: bool) -> Vehicle:
    """A vehicle whose centres, added mass, thrusters, fins and instruments stand anywhere."""
    rng = np.random.default_rng(seed)

    def some(low, high, size=None):
        return rng.uniform(low, high, size)

    def place(along, across, down):
        return tuple(map(float, some(-1.0, 1.0, 3) * (along, across, down)))

    m, centre = float(some(20, 100)), np.array(place(0.05, 0.02, 0.03))
    inertia = np.array([some(0.5, 2.0), some(3.0, 4.0), some(3.6, 4.4)]) * m / 30.0
    added = np.diag(np.r_[some(0.1, 1.0, 3) * m, some(0.2, 1.0, 3) * inertia])
    added[1, 5] = added[5, 1] = some(-0.05, 0.05) * m
    added[2, 4] = added[4, 2] = some(-0.05, 0.05) * m
    sites, thrusters, fins = {}, [], []
    unit = str(rng.choice([*MOST]))
    gain = {"command": 30.0, "rev_s": 0.03, "N": float("nan")}[unit]
    for k in range(int(rng.integers(3, 6))):
        sites[f"thruster_{k}"] = place(0.6, 0.3, 0.1)
        along = np.array([1.0, 0.0, 0.0]) if k < 2 else rng.normal(size=3)
        towards = tuple(map(float, along / np.linalg.norm(along)))
        own = {} if unit == "N" else {"gain": gain * float(some(0.8, 1.2))}
        thrusters.append(Thruster(f"thruster_{k}", towards, 40.0, input=unit, lag_s=float(some(0.05, 0.5)), **own))
    for k in range(int(rng.integers(0, 3))):
        sites[f"fin_{k}"], turn = (-0.6, *place(0.2, 0.1, 0.1)[:2]), float(some(0.0, 6.0))
        axis = (0.0, float(np.cos(turn)), float(np.sin(turn)))
        fins.append(Fin(f"fin_{k}", f"fin_{k}", axis, 0.02, float(some(2, 4)), 0.5, float(some(0, 1.5)), 0.5, 1025.0))
    path.write_text(MJCF.format(
        z=0 if afloat else -3, m=m, centre="{} {} {}".format(*centre), inertia="{} {} {}".format(*inertia),
        sites="".join('<site name="{}" pos="{} {} {}"/>'.format(name, *at) for name, at in sites.items()),
    ), encoding="utf-8")  # fmt: skip
    return Vehicle(
        name="made", mjcf=path, mass_kg=m, added_mass=added, buoyancy_N=m * G * (some(0.97, 1.03) if afloat else 1.0),
        quadratic_drag=np.r_[some(20, 100, 3), some(1, 5, 3) * inertia],
        linear_drag=np.r_[some(2, 20, 3), some(0.2, 1.0, 3) * inertia],
        centre_of_buoyancy_m=centre + [*place(0.02, 0.01, 0.0)[:2], -some(0.05, 0.4)],
        heave_N_per_m=float(some(500, 3000)) if afloat else 0.0, propeller_sites=(), propeller_diameter_m=0.1,
        thrusters=tuple(thrusters), fins=tuple(fins), sites=sites, centre_m=tuple(centre), inertia=tuple(inertia),
        sensors=(Sensor("motion", MOTION, place(0.3, 0.3, 0.3), rate_hz=10.0, noise=(NOISE,) * 12, latency_s=0.1),
                 Sensor("log", MOTION[6:9], place(0.3, 0.3, 0.3), place(60.0, 60.0, 60.0), 5.0, (NOISE,) * 3)),
    )  # fmt: skip


def flown(vehicle: Vehicle, duration_s: float, seed: int, until_s: float = np.inf) -> Run:
    """A sine of its own for every thruster and fin, until some time."""
    rng, asked = np.random.default_rng(seed), {"time_s": np.arange(0.0, duration_s, 0.2)}
    for device in (*vehicle.thrusters, *vehicle.fins):
        most = MOST[device.input] if isinstance(device, Thruster) else 0.2
        asked[device.column] = most * np.sin(rng.uniform(0.5, 2.0) * asked["time_s"] + rng.uniform(0.0, 7.0))
        asked[device.column][asked["time_s"] > until_s] = 0.0
    return fly_vehicle(vehicle, asked, duration_s, seed)


@pytest.mark.parametrize("seed, afloat", [(1, False), (2, True), (3, False), (4, True), (5, False), (6, True)])
def test_the_tank_and_the_equations_of_the_estimators_move_a_vehicle_alike(tmp_path, monkeypatch, seed, afloat):
    monkeypatch.setattr(recorded, "STEPS_S", (0.001, 0.02))  # [s] steps as short as the tank's, nearly
    vehicle = made(tmp_path / "made.xml", seed, afloat)
    layout, (run,), _ = record([flown(vehicle, 6.0, seed)], vehicle)
    start = np.zeros(run.start.size)
    start[2] = 0.0 if afloat else 3.0
    run = replace(run, start=start, resting=True)
    e = innovations(run, layout.null, free(run))
    for c, column in enumerate(layout.columns):
        mine = run.column == c
        assert np.sqrt(np.mean(e[mine] ** 2)) < 3e-4 * np.sqrt(np.mean(run.value[mine] ** 2)) + 3.0 * NOISE, column


def test_a_craft_afloat_need_not_begin_at_its_waterline(tmp_path):
    """Nothing tells of how deep it sits but the speed at which that changes."""
    motion = Sensor("motion", MOTION[3:], rate_hz=10.0, noise=(5e-4,) * 9)
    vehicle = replace(made(tmp_path / "made.xml", 4, afloat=True), sensors=(motion,))
    whole = flown(vehicle, 8.0, 4, until_s=2.0)
    later = whole.time_s >= 4.0
    columns = {name: values[later] for name, values in whole.columns.items()}
    layout, (run,), _ = record([Run("cut", whole.time_s[later], columns)], vehicle)
    noise = Noise(np.full(9, 2.5e-7), np.full(6, 1e-4)).even
    (f,) = Fit((run,), noise).filter(layout.null)
    assert np.mean(f.z**2) < 1.5
