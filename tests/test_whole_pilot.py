"""Closed loop from readings: gains that place poles, one scenario for every vehicle, walls and clocks."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vtank as vt
from vtank.cli import main
from vtank.errors import InputError
from vtank.experiment import fly_vehicle
from vtank.experiment.allocation import Allocation
from vtank.experiment.loops import Loop
from vtank.experiment.whole import fly
from vtank.experiment.whole_scenario import WholeScenario, fly_whole, load_whole_scenario, summary
from vtank.plant import Sensor, load_vehicle
from vtank.plant.vehicle import AXES
from vtank.record import read_dataset, read_truth
from vtank.resources import models_dir, scenarios_dir
from vtank.tank import load_whole

VEHICLES = ("bluerov2", "kingfisher", "phoenix", "remus100")
HOLD = """
vehicle = "bluerov2"
duration_s = 20.0
[[hold]]
axis = "heave"
"""
EXCITE = HOLD.replace("[[hold]]", "[[excite]]\n{}")


def written(folder: Path, text: str = HOLD, **settings: object) -> WholeScenario:
    (folder / "mine.toml").write_text(text, encoding="utf-8")
    return load_whole_scenario(folder / "mine.toml", [f"{key}={value}" for key, value in settings.items()])


# --- gains and allocation ---------------------------------------------------------------------------------------------
def test_gains_place_the_poles_where_the_bandwidth_says() -> None:
    """With the vehicle's own drag and stiffness in the equation, all poles of a place lie at w, and INTEGRAL w."""
    loop = Loop(mass=12.0, linear=3.0, quadratic=0.0, rights=2.0, per_square=-1.5, bandwidth_rad_s=0.8, of_speed=False)
    stiffness = 2.0 - 1.5 * 0.5**2
    kp = -loop.force(1.0, 0.0, 0.5)
    kd = -loop.force(0.0, 1.0, 0.5)
    loop.integral = 1.0
    ki = -loop.force(0.0, 0.0, 0.5)
    poles = np.roots([12.0, 3.0 + kd, stiffness + kp, ki])
    assert np.sort(poles.real) == pytest.approx([-0.8, -0.8, -0.16], rel=1e-4)
    speed = replace(loop, of_speed=True, integral=0.0)
    kp = -speed.force(1.0, 0.0, 0.0)
    speed.integral = 1.0
    assert np.roots([12.0, 3.0 + kp, -speed.force(0.0, 0.0, 0.0)]) == pytest.approx([-0.8, -0.8], rel=1e-4)


def test_an_unmeasured_rate_is_observed() -> None:
    loop = Loop(mass=10.0, linear=2.0, quadratic=5.0, rights=0.0, per_square=0.0, bandwidth_rad_s=1.0, of_speed=False)
    place = speed = 0.0
    for _ in range(2000):
        seen = loop.observe(place, 4.0, 0.005)
        speed += 0.005 * (4.0 - 2.0 * speed - 5.0 * abs(speed) * speed) / 10.0
        place += 0.005 * speed
    assert seen == pytest.approx(speed, rel=0.01) and speed > 0.5


@pytest.mark.parametrize(
    ("vehicle", "axes"),
    [("bluerov2", AXES), ("bluerov2", ("surge", "yaw")), ("kingfisher", ("surge", "yaw")),
     ("phoenix", ("surge", "sway", "heave", "pitch", "yaw")), ("remus100", ("surge", "pitch", "yaw"))],
)  # fmt: skip
def test_allocation_makes_what_is_ordered(vehicle: str, axes: tuple[str, ...]) -> None:
    craft = load_vehicle(vehicle)
    model = load_whole(craft).model
    allocation = Allocation(craft, model, axes)
    wanted = np.array([0.7, -0.4, 0.5, 0.1, 0.2, -0.3]) * [axis in axes for axis in AXES]
    speed = 1.2
    efforts = allocation.matrix(speed) @ wanted
    made = model.actuator_gear[: len(craft.thrusters)].T @ efforts[: len(craft.thrusters)]
    for number, angle in zip(
        [i for i, f in enumerate(craft.fins) if f.limit_rad], efforts[len(craft.thrusters) :], strict=True
    ):
        fin = craft.fins[number]
        lift = 0.5 * fin.density_kg_per_m3 * fin.area_m2 * speed**2 * fin.lift_per_rad * angle
        made[3:] += lift * model.actuator_gear[len(craft.thrusters) + 2 * number + 1, 3:]
    ordered = [AXES.index(axis) for axis in axes]
    assert made[ordered] == pytest.approx(wanted[ordered], abs=1e-9)
    if vehicle == "bluerov2":
        assert made == pytest.approx(wanted, abs=1e-9)
    assert all(allocation.able(axis) for axis in axes)


def test_what_a_vehicle_cannot_push_is_known() -> None:
    for vehicle, axis in (("kingfisher", "sway"), ("remus100", "sway"), ("remus100", "heave"), ("phoenix", "roll")):
        craft = load_vehicle(vehicle)
        assert not Allocation(craft, load_whole(craft).model, [axis]).able(axis)


def test_the_largest_moment_is_what_all_thrusters_make() -> None:
    craft = load_vehicle("kingfisher")
    allocation = Allocation(craft, load_whole(craft).model, ["surge", "yaw"])
    astern = min(t.most_N(-1.0) for t in craft.thrusters)
    assert allocation.largest("yaw", 0.0) == pytest.approx(2 * 0.39 * astern, rel=1e-6)


# --- one scenario, every vehicle --------------------------------------------------------------------------------------
@pytest.mark.parametrize("vehicle", VEHICLES)
def test_one_scenario_is_flown_by_every_vehicle(vehicle: str) -> None:
    """Heading follows its order and depth stays, by thrusters, by tunnel thrusters, by fins, by two propellers."""
    scenario = load_whole_scenario("whole/turns-and-steps", [f"vehicle={vehicle}", "duration_s=70"])
    flown = fly_whole(scenario)
    column = next(name for name in flown.run.columns if name.endswith("heading_rad"))
    time_s, heading = flown.run.samples(column)
    ordered = next(o for o in scenario.orders if o.target == "yaw").signal.command(time_s, scenario.duration_s)[0]
    late = time_s > 20.0
    assert np.sqrt(np.mean((heading - ordered)[late] ** 2)) < 0.15 < 0.3 * np.ptp(ordered)
    if vehicle != "kingfisher":
        depth = flown.run.samples("depth.depth_m")[1]
        assert np.abs(depth - np.median(depth)).max() < 0.12
    speeds = [
        flown.run.samples(name)[1][-50:].mean()
        for name in ("dvl.surge_m_s", "gps.surge_m_s")
        if name in flown.run.columns
    ]
    assert speeds == pytest.approx([0.5] * len(speeds), abs=0.03) and len(speeds) == (vehicle != "phoenix")
    assert "heading_rad" in summary(scenario, flown) and ("not held: kingfisher" in summary(scenario, flown)) == (
        vehicle == "kingfisher"
    )


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_a_zigzag_goes_over_when_the_heading_passes_its_limit(vehicle: str) -> None:
    """The sign of the moment that is ordered, by the sign of what turns, changes just beyond 10 deg."""
    craft = load_vehicle(vehicle)
    craft = replace(craft, sensors=(*craft.sensors, Sensor("true", ("heading_rad", "yaw_rate_rad_s"), rate_hz=10.0)))
    scenario = replace(load_whole_scenario("whole/zigzag", [f"vehicle={vehicle}", "duration_s=40"]), vehicle=craft)
    pilot = scenario.pilot()
    signs = []

    def watched(time_s: float, readings):
        found = pilot(time_s, readings)
        signs.append((readings["true.heading_rad"], np.sign(pilot._wanted[5])))
        return found

    fly(craft, watched, 40.0, seed=1)
    heading, sign = np.array(signs).T
    over = np.flatnonzero(np.diff(sign))
    assert over.size >= (1 if vehicle == "phoenix" else 2)
    for k in over[
        np.abs(heading[over]) < 1.0
    ]:  # at the tick before, or at this one, the heading was read to be beyond the limit, on the side left
        assert np.sign(heading[k + 1]) == sign[k] and abs(heading[k + 1]) > 0.1745 - 5.0 * 0.03


def test_a_zigzag_by_a_rudder_knows_which_way_it_turns(tmp_path: Path) -> None:
    """A positive rudder turns to port."""
    text = """
vehicle = "remus100"
duration_s = 60.0
[[excite]]
kind = "step_coast"
input = "propeller_rev_s"
amplitude = 25.0
push_s = 61.0
coast_s = 0.0
[[excite]]
kind = "zigzag"
input = "rudder_rad"
amplitude = 0.1
heading_rad = 0.35
"""
    flown = fly_whole(written(tmp_path, text))
    rudder = flown.run.samples("rudder_rad")[1]
    assert set(np.unique(np.round(rudder, 6))) == {-0.1, 0.1} and np.count_nonzero(np.diff(rudder)) >= 3
    heading = flown.run.samples("compass.heading_rad")[1]
    assert 0.35 < heading.max() < 0.9 and -0.9 < heading.min() < -0.35


def test_the_library_flies_whole_vehicles_and_effects_by_name() -> None:
    run = vt.run("whole/bluerov2-multisine", settings=["duration_s=3"])[0]
    assert run.name == "bluerov2-multisine" and "dvl.surge_m_s" in run.columns
    still = {"time_s": [0.0]}
    carried = fly_vehicle("bluerov2", still, 20.0, effects={"current@vehicle": {"north_m_s": 0.2}})
    assert carried.samples("dvl.surge_m_s")[1][-1] > 0.1
    with pytest.raises(InputError, match="effects: tether@surge.k_N_per_m: missing"):
        fly_vehicle("bluerov2", still, 1.0, effects={"tether@surge": {}})
    with pytest.raises(InputError, match="neither for a whole vehicle"):
        vt.run("whole/zigzag", truth="physical")


def test_a_spiral_goes_from_side_to_side_and_back(tmp_path: Path) -> None:
    scenario = load_whole_scenario("whole/spiral")
    value = next(o for o in scenario.orders if o.target == "yaw").signal.command(np.arange(0.0, 261.0, 20.0), 260.0)[0]
    assert value == pytest.approx(0.5 * np.array([3, 2, 1, 0, -1, -2, -3, -2, -1, 0, 1, 2, 3, 0]) / 3)
    rate = fly_whole(scenario).run.samples("imu.yaw_rate_rad_s")
    at = np.array([rate[1][(rate[0] > end - 5.0) & (rate[0] < end)].mean() for end in 20.0 * np.arange(1, 14)])
    assert (np.diff(at[:7]) < 0.0).all() and at[0] > 0.3 > -0.3 > at.min()
    assert at[3] > 0.3  # this hull is unstable: it goes on turning without a moment, which is what a spiral is for


def test_station_is_kept_in_waves() -> None:
    scenario = load_whole_scenario("whole/station-in-waves", ["duration_s=60"])
    held = fly_whole(scenario).run
    drifting = fly(
        "bluerov2", {"time_s": [0.0]}, 60.0, waves=scenario.waves, depth_m=4.0, current_m_s=scenario.current_m_s
    ).run

    def moved(run):
        return np.hypot(np.ptp(run.samples("mocap.north_m")[1]), np.ptp(run.samples("mocap.east_m")[1]))

    assert moved(held) < 1.0 < 5.0 < moved(drifting)
    assert held.samples("depth.depth_m")[1][0] == pytest.approx(4.0, abs=0.05)


def test_a_hold_works_on_what_the_instrument_reads(tmp_path: Path) -> None:
    """A depth sensor that is off by 0.3 m makes the vehicle hold another depth, and its own record hides it."""
    text = HOLD + '[effects]\n"depth_offset@depth" = { o_m = 0.3 }\n'
    run = fly_whole(written(tmp_path, text, duration_s=60.0)).run
    assert run.samples("depth.depth_m")[1][-100:].mean() == pytest.approx(0.9144, abs=0.02)
    assert run.samples("mocap.depth_m")[1][-100:].mean() == pytest.approx(0.6144, abs=0.02)


def test_a_pilot_reads_the_very_samples_that_are_recorded() -> None:
    """Latest stamps, noise included; nothing before the first has arrived."""
    seen = []

    def pilot(time_s, readings):
        seen.append((time_s, readings.get("dvl.surge_m_s"), readings.get("depth.depth_m")))
        return {"thruster_1_command": 0.3}

    run = fly_vehicle("bluerov2", pilot, 5.0, seed=4)
    dvl, depth = run.samples("dvl.surge_m_s"), run.samples("depth.depth_m")
    assert seen[0][1] is None  # its latency is 0.1 s
    for time_s, speed, down in seen[2:]:
        assert speed == dvl[1][dvl[0] <= time_s + 1e-6][-1]
        assert down == depth[1][depth[0] <= time_s + 1e-6][-1]


def test_the_time_step_is_shortened_to_a_tick_that_is_not_a_multiple_of_it(tmp_path: Path) -> None:
    """As along one axis: commands come every 0.033 s though the vehicle's file has steps of 0.01 s, or of 0.5 s."""
    run = fly_whole(written(tmp_path, duration_s=3.0, period_s=0.033)).run
    assert np.diff(run.samples("thruster_5_command")[0]) == pytest.approx(0.033)
    bluerov2 = load_vehicle("bluerov2")
    slow = bluerov2.mjcf.read_text(encoding="utf-8").replace('timestep="0.01"', 'timestep="0.5"')
    (tmp_path / "slow.xml").write_text(slow, encoding="utf-8")
    coarse = fly(replace(bluerov2, mjcf=tmp_path / "slow.xml"), lambda time_s, readings: {}, 3.0)
    assert coarse.run.duration_s == pytest.approx(3.0)
    with pytest.raises(InputError, match="period_s: expected a number above 0 s, found 0"):
        fly("bluerov2", lambda time_s, readings: {}, 3.0, period_s=0.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HOLD.replace("bluerov2", "kingfisher"), "hold[0].axis: the thrusters of kingfisher cannot push along heave"),
        (HOLD.replace("heave", "sway").replace("bluerov2", "phoenix"), "sway needs north_m, which no sensor of"),
        (HOLD + "bandwidth_rad_s = 5.0\n", "hold[0].bandwidth_rad_s: latency, lag and tick of bluerov2 are 0.2 s"),
        (HOLD + 'otherwise = "skip"\n', "hold[0].otherwise: expected one of refuse, leave"),
        (HOLD + "at_rad = 1.0\n", "hold[0].at_rad: wrong unit: expected 'at_m' [m]"),
        (HOLD + '[[hold]]\naxis = "heave"\n', "hold[1].axis: heave is held or moved in closed loop already"),
        (HOLD.replace("heave", "yaw") + "speed_m_s = 1.0\n", "hold[0].speed_m_s: unknown key; there are: at_rad"),
        (HOLD + "[waves]\nkind = \"regular\"\n", "depth_m: missing; expected with [waves]"),
        (HOLD.replace("heave", "yaw").replace("bluerov2", "kingfisher") + '[waves]\nkind = "regular"\n',
         "kingfisher floats, and is held at a waterline that stands still"),
        ('vehicle = "bluerov2"\n', "excite: expected one excitation or more"),
        (HOLD.replace("[[hold]]", "[[excite]]\nkind = \"zigzag\"\namplitude_share = 0.5").replace("heave", "yaw"),
         "excite[0].heading_rad: missing"),
        (HOLD.replace("[[hold]]", "[[excite]]\nkind = \"zigzag\"\namplitude_share = 0.5\nheadin_rad = 0.1")
         .replace("heave", "yaw"), "expected a value [rad]; is 'headin_rad' meant to be it?"),
        (HOLD.replace("[[hold]]", "[[excite]]\nkind = \"zigzag\"\namplitude_share = 1.5\nheading_rad = 0.1"),
         "excite[0].amplitude_share: expected a number above 0 and up to 1"),
        (HOLD.replace("[[hold]]", "[[excite]]\nkind = \"zigzag\"\namplitude_share = 0.5\nheading_rad = 0.1")
         .replace("heave", "surge"), "excite[0].axis: a zig-zag goes over at a heading, and surge has none"),
        (HOLD + "at_m = -20.0\n", "hold[0].at_m: -20 m from a depth of 0.9144 m is above the surface"),
        (HOLD.replace("[[hold]]", "[[excite]]\nkind = \"square\"\namplitude_m = 1.5\nfrequency_rad_s = 0.2"),
         "excite[0].amplitude_m: -1.5 m from a depth of 0.9144 m is above the surface"),
        (EXCITE.format('kind = "multisine"\namplitudes_share = [0.1, 0.1]\nfrequencies_rad_s = [0.5, 100.0]'),
         "excite[0].frequencies_rad_s: expected less than 31.42 rad/s, found 100: a command every 0.1 s (period_s)"),
        (EXCITE.format('kind = "chirp"\namplitude_share = 0.1\nfrom_rad_s = 0.1\nto_rad_s = 40.0'),
         "excite[0].to_rad_s: expected less than 31.42 rad/s, found 40"),
        ("current_m_s = [50.0, 0.0, 0.0]\n" + HOLD, "current_m_s: expected a number from -5 to 5 [m/s], found 50"),
        (HOLD + "[sensor.dvl]\nlatency_s = 100.0\n",
         "sensor.dvl.latency_s: expected less than the run's 20 s, found 100: nothing that dvl measures would"),
    ],
)  # fmt: skip
def test_orders_that_cannot_be_are_refused(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        written(tmp_path, text).pilot()
    assert said in str(caught.value) and "mine.toml" in str(caught.value)


# --- walls ------------------------------------------------------------------------------------------------------------
def test_a_wall_ends_a_flight_and_it_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The record stops where the bow reaches the wall, 4.1148 m ahead; data, summary and truth say so."""
    out = tmp_path / "out"
    assert main(["run", "whole/turns-and-steps", "--set", "walls=basin", "--out", str(out)]) == 0
    told = capsys.readouterr().out
    found = re.search(r"strikes 'wall_ahead' after ([\d.]+) s, the last good time", told)
    run = read_dataset(out).runs[0]
    assert found and float(found[1]) == pytest.approx(run.time_s[-1], abs=0.06)
    bow = run.samples("mocap.north_m")[1][-1] + 0.2285
    assert bow == pytest.approx(4.1148, abs=0.06)
    assert "wall_ahead" in read_truth(out)["scenarios"][0]["ended"]


def test_a_flight_in_a_basin_without_a_touch_goes_on() -> None:
    flown = fly("bluerov2", {"time_s": [0.0]}, 5.0, walls=models_dir() / "basin.xml")
    assert not flown.ended and flown.run.time_s[-1] == pytest.approx(5.0)
    with pytest.warns(UserWarning, match="strikes 'floor'"):
        fly_vehicle("bluerov2", {"time_s": [0.0]} | {f"thruster_{k}_command": [0.5] for k in (5, 6, 7, 8)}, 20.0,
                    walls=models_dir() / "basin.xml")  # fmt: skip


def test_a_start_within_a_wall_is_refused() -> None:
    with pytest.raises(InputError, match="strikes 'floor' where it starts"):
        fly("remus100", {"time_s": [0.0]}, 5.0, walls=models_dir() / "basin.xml", depth_m=2.1)


# --- sensors ----------------------------------------------------------------------------------------------------------
def test_bias_resolution_and_clock_of_a_vehicle_file() -> None:
    vehicle = load_vehicle("bluerov2")
    plain = Sensor("log", ("surge_m_s", "depth_m"), rate_hz=20.0)
    marred = replace(plain, bias=(0.1, -0.2), resolution=(0.0, 0.05), clock_skew=0.01, clock_offset_s=0.4)
    ahead = {"time_s": [0.0]} | {f"thruster_{k}_command": [0.5 if k < 3 else -0.5] for k in (1, 2, 3, 4)}
    one, other = (
        fly_vehicle(replace(vehicle, sensors=(s,)), ahead, 10.0) for s in (replace(plain, rate_hz=100.0), marred)
    )
    time_s, true = one.samples("log.surge_m_s")
    stamps, speed = other.samples("log.surge_m_s")
    assert speed == pytest.approx(np.interp(stamps * 1.01 - 0.4, time_s, true) + 0.1, abs=1e-4)
    assert stamps[0] == pytest.approx(0.4, abs=0.05) and stamps[-1] == pytest.approx(10.4 / 1.01, abs=0.05)
    depth = other.samples("log.depth_m")[1] / 0.05
    assert depth == pytest.approx(np.round(depth), abs=1e-9)
    assert depth[0] * 0.05 == pytest.approx(one.samples("log.depth_m")[1][0] - 0.2, abs=0.026)


def test_what_may_be_left_is_left_and_told(tmp_path: Path) -> None:
    """A torpedo holds its depth by its pitch, whichever stands first; what cannot be held beside the rest is told."""
    both = '[[hold]]\naxis = "{}"\notherwise = "leave"\n'
    ahead = '[[hold]]\naxis = "surge"\nspeed_m_s = 1.0\nbandwidth_rad_s = 0.3\n'
    for first, second in (("pitch", "heave"), ("heave", "pitch")):
        text = 'vehicle = "remus100"\n' + ahead + both.format(first) + both.format(second) + both.format("sway")
        pilot = written(tmp_path, text).pilot()
        assert [(o.target, o.through) for o in pilot.orders] == [("surge", ""), ("heave", "pitch")]
        assert pilot.left == ("sway",)
    with pytest.raises(InputError, match=r"hold\[2\].axis: the thrusters of remus100 cannot push along pitch beside"):
        written(tmp_path, f'vehicle = "remus100"\n{ahead}[[hold]]\naxis = "heave"\n[[hold]]\naxis = "pitch"\n').pilot()


@pytest.mark.parametrize("axis", ["heave", "yaw"])
def test_fins_hold_nothing_where_no_speed_is_ordered(tmp_path: Path, axis: str) -> None:
    """Nobody is told that a torpedo at rest keeps its depth or its heading."""
    still = f'vehicle = "remus100"\n[[hold]]\naxis = "{axis}"\n'
    assert written(tmp_path, still + 'otherwise = "leave"\n').pilot().left == (axis,)
    with pytest.raises(InputError, match="its fins turn it under way only"):
        written(tmp_path, still).pilot()
    driven = (
        '[[excite]]\nkind = "step_coast"\ninput = "propeller_rev_s"\namplitude = 20.0\npush_s = 9.0\ncoast_s = 1.0\n'
    )
    assert written(tmp_path, still + driven).pilot().left == ()


def test_heading_comes_before_speed(tmp_path: Path) -> None:
    """What is asked for in vain ahead takes nothing from what is held, and is told; all cut alike it swung by 2 rad."""
    text = (scenarios_dir() / "whole/turns-and-steps.toml").read_text().replace("s = 0.5\n", "s = 1.5\n")
    scenario = written(tmp_path, text.replace("bluerov2", "kingfisher"))
    flown = fly_whole(scenario)
    assert np.abs(flown.run.samples("compass.heading_rad")[1]).max() < 0.6
    assert flown.cut["surge"] > 0.5 > 0.01 > flown.cut.get("yaw", 0.0)
    assert "more asked than thrusters and fins make: surge" in summary(scenario, flown)


@pytest.mark.slow
def test_a_hull_that_turns_over_by_itself_is_held(tmp_path: Path) -> None:
    """At 0.7 of the 0.85 m/s that a BlueROV2 makes the Munk moment is six times what rights its pitch."""
    path = tmp_path / "fast.toml"
    path.write_text((scenarios_dir() / "whole/turns-and-steps.toml").read_text().replace("s = 0.5\n", "s = 0.7\n"))
    run = fly_whole(load_whole_scenario(path)).run
    assert np.abs(run.samples("ahrs.pitch_rad")[1]).max() < 0.1 and np.ptp(run.samples("depth.depth_m")[1]) < 0.1


def test_a_share_of_the_largest_force_is_at_most_all_of_it(tmp_path: Path) -> None:
    more = (
        '[[excite]]\nkind = "multisine"\naxis = "sway"\nfrequencies_rad_s = [0.3, 0.7]\namplitudes_share = [0.7, 0.7]\n'
    )
    with pytest.raises(InputError, match=r"mine.toml: excite\[0\].amplitudes_share: sway is asked for 1.34"):
        written(tmp_path, 'vehicle = "bluerov2"\n' + more).pilot()


def test_a_thruster_that_pushes_one_way_only_brakes_by_doing_nothing() -> None:
    """The others still do their part."""
    craft = load_vehicle("remus100")
    bench = ((0.0, 0.0), (25.0, 9.0))
    craft = replace(craft, thrusters=(replace(craft.thrusters[0], curve=bench),))
    allocation = Allocation(craft, load_whole(craft).model, ["surge", "yaw"])
    back = allocation.matrix(1.0) @ np.array([-5.0, 0.0, 0.0, 0.0, 0.0, 0.2])
    asked = allocation.inputs(back[None])
    assert asked["propeller_rev_s"] == 0.0 and abs(asked["rudder_rad"][0]) > 0.01
    assert allocation.overload(back) == pytest.approx(abs(asked["rudder_rad"][0]) / craft.fins[1].limit_rad)


def test_a_scenario_states_a_sensor_otherwise(tmp_path: Path) -> None:
    scenario = written(tmp_path, HOLD + "[sensor.depth]\nresolution = [0.1]\nrate_hz = 4.0\n")
    depth, plain = (
        next(s for s in v.sensors if s.name == "depth") for v in (scenario.vehicle, load_vehicle("bluerov2"))
    )
    assert replace(depth, resolution=plain.resolution, rate_hz=plain.rate_hz) == plain
    time_s, read = fly_whole(scenario).run.samples("depth.depth_m")
    assert np.allclose(np.diff(time_s), 0.25) and np.allclose(read * 10.0, np.round(read * 10.0))
    for text, said in (
        ("[sensor.dept]\nrate_hz = 4.0\n", "sensor.dept: no such sensor; did you mean 'depth'?"),
        ("[sensor.depth]\nrate = 4.0\n", "sensor.depth.rate: "),
        ("[sensor.depth]\nnoise = [0.1, 0.2]\n", "sensor.depth.noise: expected 1 numbers, one for each channel"),
    ):
        with pytest.raises(InputError, match=re.escape(said)):
            written(tmp_path, HOLD + text)
