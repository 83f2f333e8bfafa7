"""Recordings as others write them: columns without their instrument's name, a start that is not square to the wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_rigid_motion import multisine

import vtank as vt
from vtank.diagnose.whole.own import own_unknowns
from vtank.experiment import fly_vehicle
from vtank.plant.vehicle import load_vehicle
from vtank.resources import models_dir
from vtank.rigid import thinned
from vtank.rigid.fit import Fit
from vtank.rigid.layout import BEARING, HULL, SENSOR, THRUSTER
from vtank.rigid.noise import first_noise
from vtank.rigid.readings import RANGE, read
from vtank.rigid.recordings import record

ROV = load_vehicle("bluerov2")
FEW = replace(ROV, sensors=tuple(s for s in ROV.sensors if s.name in ("imu", "ahrs", "dvl", "depth")))


def test_a_column_belongs_to_the_only_instrument_that_has_its_channel():
    run = fly_vehicle(FEW, multisine(FEW, 15.0, 1), 15.0, 1)
    plain = replace(run, columns={name.rpartition(".")[2]: values for name, values in run.columns.items()})
    assert plain.columns.keys() != run.columns.keys()
    found = []
    for some in (run, plain):
        layout, seen, _ = record([some], FEW)
        assert set(layout.sensors) == {"imu", "ahrs", "dvl", "depth"}
        (f,) = Fit(seen, first_noise(seen)).filter(layout.null)
        found.append(np.sort(np.abs(f.innovation)))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6, atol=1e-12)


def test_what_a_late_instrument_tells_of_before_the_recording_is_left_out():
    """Nobody recorded what drove the vehicle then; simulated instruments tell of the start, as if nothing had."""
    late = replace(FEW, sensors=tuple(replace(s, latency_s=0.5) if s.name == "dvl" else s for s in FEW.sensors))
    run = fly_vehicle(late, multisine(FEW, 15.0, 1), 15.0, 1)
    told, before = run.columns["dvl.surge_m_s"].copy(), run.time_s - run.time_s[0] < 0.5 - 1e-6
    told[before & np.isfinite(told)] = 9.0
    found = []
    for columns in (run.columns, {**run.columns, "dvl.surge_m_s": told}):
        _, (seen,), _ = record([replace(run, columns=columns)], late)
        assert (seen.time_s - seen.late).min() >= run.time_s[0] - 1e-6
        found.append((seen.start, seen.value))
    for there, left_out in zip(*found, strict=True):
        np.testing.assert_array_equal(there, left_out)


def test_of_several_instruments_none_is_guessed():
    assert ROV.instrument("dvl.surge_m_s") == ROV.instrument("surge_m_s") == "dvl"
    assert ROV.instrument("depth_m") == "", "depth cell or motion capture"
    assert ROV.instrument("gps.surge_m_s") == "gps"


@pytest.mark.parametrize("off", [-0.15, 0.0, 0.2])
def test_a_range_knows_how_the_wall_stands(off: float):
    """10 m square to a wall; the vehicle starts `off` from square, and comes 2 m nearer at the same heading."""
    columns = {f"{t.column}": np.zeros(40) for t in ROV.thrusters}
    columns |= {"range_m": np.full(40, 10.0 / np.cos(off)), "heading_rad": np.full(40, off)}
    time = 0.1 * np.arange(40)
    still = replace(fly_vehicle(FEW, multisine(FEW, 4.0, 1), 4.0, 1), columns=columns, time_s=time)
    ahead = replace(ROV, sensors=tuple(replace(s, position_m=(0.0, 0.0, 0.0)) for s in ROV.sensors))
    layout, (seen,), _ = record([still], ahead)
    p, sonar = layout.null.copy(), layout.sensors.index("ping")
    p[layout.slot("wall_bearing@ping")] = -off
    assert layout.slot("wall_bearing@ping") == HULL + THRUSTER * len(layout.pushes) + SENSOR * sonar + BEARING
    x = np.zeros(18)
    x[0], x[5] = 2.0, off
    at = sonar, layout.columns.index("range_m")
    told = read(RANGE, *at, x, np.zeros(18), p, layout.counts, np.zeros(2), seen.wall, off)
    assert told == pytest.approx(8.0 / np.cos(off), abs=1e-9)
    bearing = next(u for u in own_unknowns(layout, [seen]) if u.name == "wall_bearing@ping")
    assert not bearing.stated


@pytest.mark.parametrize("north", [0.0, 4.0])
def test_runs_that_start_before_one_wall_have_one(north: float):
    """The first headings differ by their noise; wherever a run starts, its ranges tell of the same wall."""
    runs = []
    for heading, first in ((0.02, 0.013), (0.3, 0.31)):
        columns = {f"{t.column}": np.zeros(40) for t in ROV.thrusters}
        told = np.full(40, heading)
        told[0] = first
        columns |= {"range_m": np.full(40, 10.0 / np.cos(heading)), "heading_rad": told}
        columns |= {"north_m": np.full(40, north), "east_m": np.zeros(40)}
        time = 0.1 * np.arange(40)
        runs.append(replace(fly_vehicle(FEW, multisine(FEW, 4.0, 1), 4.0, 1), columns=columns, time_s=time))
    layout, seen, _ = record(runs, replace(ROV, sensors=tuple(replace(s, position_m=(0.0,) * 3) for s in ROV.sensors)))
    assert seen[0].facing == seen[1].facing == 0.013
    for run, heading in zip(seen, (0.02, 0.3), strict=True):
        x, p = np.zeros(18), layout.null.copy()
        x[0], x[5] = north + 2.0, heading
        p[layout.slot("wall_bearing@ping")] = -0.013  # square to north
        at = layout.sensors.index("ping"), layout.columns.index("range_m")
        told = read(RANGE, *at, x, np.zeros(18), p, layout.counts, run.start[:2], run.wall, run.facing)
        assert told == pytest.approx(8.0 / np.cos(heading), abs=0.05)


def test_thrusters_of_a_kind_are_wrong_alike():
    phoenix = load_vehicle("phoenix")
    run = fly_vehicle(phoenix, multisine(phoenix, 4.0, 1), 4.0, 1)
    layout, (seen,), _ = record([run], phoenix)
    gains = {u.name: u.slots.size for u in own_unknowns(layout, [seen]) if u.name.startswith("gain@")}
    assert gains["gain@propeller_port/propeller_starboard"] == 2 and sorted(gains.values()) == [2, 2, 2]
    assert gains["gain@tunnel_bow_vertical/tunnel_stern_vertical"] == 2, "and none of the lateral ones"
    rov, (seen,), _ = record([fly_vehicle(ROV, multisine(ROV, 4.0, 1), 4.0, 1)], ROV)
    own = {u.name: u.slots.size for u in own_unknowns(rov, [seen])}
    remus = load_vehicle("remus100")
    torpedo, (run,), _ = record([fly_vehicle(remus, multisine(remus, 4.0, 1), 4.0, 1)], remus)
    slots = {u.name: set(u.slots.tolist()) for u in own_unknowns(torpedo, [run])}
    assert slots["path@thrusters"].isdisjoint(slots["path@fins"]), "angles may be measured, commands held"
    screw = replace(ROV, thrusters=(*ROV.thrusters[:-1], replace(ROV.thrusters[-1], lag_s=0.4)))
    mixed, (run,), _ = record([fly_vehicle(screw, multisine(screw, 4.0, 1), 4.0, 1)], screw)
    rotors = [u.slots.size for u in own_unknowns(mixed, [run]) if u.name.startswith("rotor@")]
    assert sorted(rotors) == [1, 7], "the rotor of one may lag, and the force of others"
    assert own["lag@thrusters"] == 8 and sorted(n for name, n in own.items() if name.startswith("gain@")) == [4, 4]


def test_how_a_wall_stands_is_no_parameter_of_the_simulator():
    """It is free in the nominal, too, which is none the worse for it; as is what lags of a propeller."""
    run = fly_vehicle("phoenix", multisine(load_vehicle("phoenix"), 15.0, 1), 15.0, 4, walls=models_dir() / "basin.xml")
    found = vt.diagnose([run], nominal="phoenix", effects=("sonar_offset",))
    free = ["rotor@thrusters", "delay@thrusters", "path@thrusters", "wall_bearing@sonar"]
    assert [u.name for u in found.selection.nominal.unknowns] == free


def test_of_a_long_recording_stretches_are_looked_at_by_its_own_clock(monkeypatch: pytest.MonkeyPatch):
    """Spread from its beginning to its end, with what drove the vehicle before each; never averaged over more."""
    monkeypatch.setattr(thinned, "MOST", 3500)  # of 10,000
    time = 0.1 * np.arange(10_000)
    turn = 0.1 * np.sin(0.5 * time)
    commands = {t.column: np.sin(0.5 * time) if k < 4 else np.full(time.size, 0.1) for k, t in enumerate(ROV.thrusters)}
    columns = commands | {"imu.yaw_rate_rad_s": turn}
    layout, seen, notes = record([vt.Run("run", time, columns)], FEW, ["yaw"])
    spans = [(run.time_s.min(), run.time_s.max()) for run in seen]
    assert len(seen) == 5 and spans[0][0] == 0.0 and spans[-1][1] == pytest.approx(time[-1])
    assert sum(end - start for start, end in spans) == pytest.approx(350.0, abs=1.0)
    assert all(np.median(np.diff(np.unique(run.time_s))) == pytest.approx(0.1) for run in seen)
    for run, (start, _) in zip(seen[1:], spans[1:], strict=True):
        assert start - 31.0 < run.stamps[0] <= start - 30.0
        k = int(np.searchsorted(time, run.stamps[5] - 1e-6))
        assert run.inputs[5, 0] == pytest.approx(commands[layout.pushes[0].column][k])
    assert "a long recording: 5 stretches of it, 350 s in all, are looked at" in notes


@pytest.mark.parametrize(
    ("steep", "begins", "ends"),
    [
        ((), 0.0, 100.0),
        ((40.0,), 0.0, 100.0),  # a sample that stands alone is an instrument's
        ((70.0, 70.1, 70.2), 0.0, 70.0),
        ((20.0, 20.1, 20.2, 30.0, 30.1), 30.2, 100.0),
    ],
)
def test_of_a_run_that_stands_on_its_nose_what_is_not_is_looked_at(steep, begins, ends):
    """Where roll and heading are one, attitude angles have no rate, and a filter of them loses its way."""
    time = 0.1 * np.arange(1001)
    pitch = np.where(np.min(np.abs(np.subtract.outer(time, [*steep, -1.0])), axis=1) < 0.01, 1.5, 0.2 * np.sin(time))
    columns = {t.column: np.sin(0.5 * time) for t in ROV.thrusters} | {"ahrs.pitch_rad": pitch}
    run = vt.Run("run", time, columns | {"imu.yaw_rate_rad_s": 0.1 * np.sin(time)})
    _, (seen,), notes = record([run], FEW)
    assert (seen.time_s.min(), seen.time_s.max()) == pytest.approx((begins, ends), abs=0.11)
    assert any("run run pitches beyond 74 deg" in note for note in notes) == (ends - begins < 99.0)
    degrees = {name: 57.3 * x if name == "ahrs.pitch_rad" else x for name, x in run.columns.items()}
    assert not record([vt.Run("run", time, degrees)], FEW)[2]  # is an error of its own


def test_fixes_tell_of_a_boat_whose_motion_in_the_plane_is_asked_about_and_beside_known_motion_do_not():
    """A heading that is off turns a path under the fixes, and nothing else tells of it."""
    time = 0.1 * np.arange(300)
    columns = {t.column: np.sin(0.5 * time) for t in load_vehicle("kingfisher").thrusters}
    told = ("north_m", "east_m", "heading_rad", "surge_m_s", "sway_m_s")
    run = vt.Run("run", time, columns | {name: 0.1 * np.sin((k + 1) * time) for k, name in enumerate(told)})
    judged = {}
    for axes in (None, ("surge", "sway", "yaw"), ("surge",)):
        layout, *_ = record([run], load_vehicle("kingfisher"), axes)
        judged[axes] = {name for name, is_judged in zip(layout.columns, layout.judged, strict=True) if is_judged}
    assert judged[None] == judged["surge", "sway", "yaw"] == set(told)
    assert judged["surge",] == {"surge_m_s"}
