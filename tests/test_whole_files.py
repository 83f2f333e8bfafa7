"""The vehicles that come with vtank, and what is said of vehicle files that are wrong."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vtank.cli import main
from vtank.errors import InputError
from vtank.experiment import fly_vehicle
from vtank.plant import Sensor, load_vehicle
from vtank.resources import models_dir
from vtank.tank import load_whole
from vtank.tank.model import centre_of_gravity, rigid_mass, vehicle_body
from vtank.units import G_M_S2

VEHICLES = ("bluerov2", "kingfisher", "phoenix", "remus100")
# What each is asked for at full ahead, and the speed that its sources give for that [m/s], and how near it must come.
FULL_AHEAD = {
    "phoenix": ({"propeller_port_rev_s": 11.6667, "propeller_starboard_rev_s": 11.6667}, 2.0 * 0.3048, 0.02),  # S1
    "remus100": ({"propeller_rev_s": 25.0}, 1.54, 0.02),  # R1; surge drag is derived from it
    "kingfisher": ({"port_command": 1.0, "starboard_command": 1.0}, 1.51, 0.05),  # K1: three runs at full command
    # the drag of B1 balances four thrusters at 40 N; the maker gives 1.5 m/s, for which that drag is too large
    "bluerov2": ({f"thruster_{k}_command": 1.0 if k < 3 else -1.0 for k in (1, 2, 3, 4)}, 0.85, 0.02),
}
BLOCK = """
name = "block"
mjcf = "block.xml"
added_mass = { surge_kg = 1.0, sway_kg = 2.0, heave_kg = 2.0, roll_kg_m2 = 0.1, pitch_kg_m2 = 0.1, yaw_kg_m2 = 0.1 }
[body]
mass_kg = 10.0
buoyancy_N = 98.0665
centre_of_buoyancy_m = [0.0, 0.0, -0.01]
[quadratic_drag]
surge_N_s2_per_m2 = 12.0
sway_N_s2_per_m2 = 90.0
heave_N_s2_per_m2 = 90.0
roll_N_m_s2_per_rad2 = 1.0
pitch_N_m_s2_per_rad2 = 15.0
yaw_N_m_s2_per_rad2 = 15.0
[propeller]
sites = ["stern"]
diameter_m = 0.1
[[thruster]]
name = "main"
site = "stern"
direction = [1.0, 0.0, 0.0]
input = "command"
gain_N = 20.0
lag_s = 0.1
dead_band = 0.05
[[fin]]
name = "rudder"
site = "stern"
axis = [0.0, 0.0, 1.0]
area_m2 = 0.01
lift_per_rad = 3.0
stall_rad = 0.35
[sensor.dvl]
channels = ["surge_m_s", "sway_m_s"]
rate_hz = 5.0
noise = [0.01, 0.01]
[sites]
stern_m = [-0.5, 0.0, 0.1]
"""
XML = """
<mujoco><option gravity="0 0 -9.80665"/><worldbody><body name="block" quat="0 1 0 0"><freejoint/>
<inertial mass="10" pos="0 0 0" diaginertia="0.4 0.5 0.6"/><site name="stern" pos="-0.5 0 0.1"/>
</body></worldbody></mujoco>
"""


def written(folder: Path, toml: str = BLOCK, xml: str = XML) -> Path:
    (folder / "block.xml").write_text(xml, encoding="utf-8")
    (folder / "block.toml").write_text(toml, encoding="utf-8")
    return folder / "block.toml"


def origins(content: object) -> list[dict]:
    """Every number of a vehicle file that states an origin."""
    if isinstance(content, dict):
        return [content] if "value" in content else [e for part in content.values() for e in origins(part)]
    return [e for part in content for e in origins(part)] if isinstance(content, list) else []


def bare(content: object, key: str = "") -> list[str]:
    """Keys of numbers that state none."""
    if isinstance(content, dict):
        return [] if "value" in content else [k for name, part in content.items() for k in bare(part, name)]
    if isinstance(content, list) and content and not isinstance(content[0], int | float):
        return [name for part in content for name in bare(part, key)]
    return [key] if isinstance(content, int | float) or isinstance(content, list) and key != "channels" else []


@pytest.mark.parametrize("name", VEHICLES)
def test_every_number_has_source_and_confidence(name: str) -> None:
    numbers = tomllib.loads((models_dir() / f"{name}.toml").read_text(encoding="utf-8"))
    for entry in origins(numbers):
        assert re.fullmatch(r"([SBRK]\d(, [SBRK]\d)*|-)", entry["source"]), entry
        assert entry["confidence"] in ("H", "M", "L", "U", "guess"), entry
    assert not bare(numbers)


@pytest.mark.parametrize("name", VEHICLES)
def test_the_two_files_of_a_vehicle_agree_and_its_wet_mass_is_positive_definite(name: str) -> None:
    vehicle = load_vehicle(name)
    whole = load_whole(vehicle)
    body = tomllib.loads((models_dir() / f"{name}.toml").read_text(encoding="utf-8"))["body"]
    index = vehicle_body(whole.model)
    assert whole.model.body_inertia[index] == pytest.approx(body["inertia_kg_m2"]["value"])
    centre = centre_of_gravity(whole.model, index)
    assert centre == pytest.approx(body["centre_of_gravity_m"]["value"], abs=1e-9)
    # MuJoCo's mass matrix without the callback is the dry one
    assert np.linalg.eigvalsh(rigid_mass(whole.model, index) + vehicle.added_mass)[0] > 0.0


@pytest.mark.parametrize("name", VEHICLES)
def test_at_rest_a_vehicle_stays_where_it_is(name: str) -> None:
    run = fly_vehicle(name, {"time_s": [0.0]}, 30.0)
    for column, values in run.columns.items():
        channel, values = column.rpartition(".")[2], values[~np.isnan(values)]
        if channel in ("depth_m", "roll_rad", "pitch_rad", "surge_m_s", "yaw_rate_rad_s"):
            sensor = next(s for s in load_vehicle(name).sensors if s.name == column.partition(".")[0])
            noise = sensor.noise[sensor.channels.index(channel)]
            assert np.abs(values - values.mean()).max() < 5.0 * noise, column
            assert abs(values[-20:].mean() - values[:20].mean()) < 2.0 * noise, column


@pytest.mark.parametrize("name", VEHICLES)
def test_full_ahead_is_the_speed_of_the_sources(name: str) -> None:
    asked, speed, near = FULL_AHEAD[name]
    whole = load_whole(replace(load_vehicle(name), sensors=(Sensor("log", ("surge_m_s",)),)))
    steps = round(60.0 / whole.model.opt.timestep)
    motion = whole.fly(whole.control({column: np.full(steps, value) for column, value in asked.items()}))
    assert motion.channels["log"]["surge_m_s"][-1] == pytest.approx(speed, rel=near)


def test_the_propellers_of_the_phoenix_are_thrusters_and_the_tank_steers_with_the_others() -> None:
    vehicle = load_vehicle("phoenix")
    assert [t.column for t in vehicle.thrusters][-2:] == ["propeller_port_rev_s", "propeller_starboard_rev_s"]
    assert [t.site for t in vehicle.steering] == [t.site for t in vehicle.thrusters][:4]
    assert len(load_vehicle("bluerov2").steering) == 8


def test_the_t200_pushes_as_on_the_bench() -> None:
    """At 16 V: 5.25 kgf ahead and 4.07 kgf astern, nothing within 0.07."""
    thruster = load_vehicle("bluerov2").thrusters[0]
    assert [force for _, force in (thruster.curve[0], thruster.curve[-1])] == pytest.approx([-39.9, 51.5], abs=0.1)
    assert thruster.force_N(np.array([-0.06, 0.06])).tolist() == [0.0, 0.0]


def test_the_remus_turns_and_dives_by_its_fins() -> None:
    """A positive rudder turns to port, a positive plane puts the bow down."""
    ahead = {"time_s": [0.0, 20.0], "propeller_rev_s": [25.0, 25.0]}
    turned = fly_vehicle("remus100", ahead | {"rudder_rad": [0.0, 0.1]}, 24.0)
    assert turned.samples("imu.yaw_rate_rad_s")[1][-1] < -0.05
    dived = fly_vehicle("remus100", ahead | {"plane_rad": [0.0, 0.1]}, 22.0)
    straight = fly_vehicle("remus100", ahead, 22.0)
    assert dived.samples("compass.pitch_rad")[1][-1] < straight.samples("compass.pitch_rad")[1][-1] - 0.05


def test_the_catamaran_turns_to_port_by_the_starboard_thruster() -> None:
    run = fly_vehicle("kingfisher", {"time_s": [0.0], "starboard_command": [0.6]}, 5.0)
    assert run.samples("compass.yaw_rate_rad_s")[1][-1] < -0.05
    assert abs(run.samples("compass.heading_rad")[1][0]) < 0.2


@pytest.mark.parametrize(
    ("find", "replacement", "said"),
    [
        ("lag_s = 0.1", "lag_s = 0.0005", "thruster[0].lag_s: 0.0005 s is too short for the time step of 0.002 s"),
        ("lag_s = 0.1", "lagg_s = 0.1", "thruster[0].lagg_s: unknown key; did you mean 'lag_s'?"),
        ("gain_N = 20.0\n", "", "thruster[0].input: 'command' makes no force without gain_N, or a curve"),
        ("gain_N = 20.0", "gain_N_s2_per_rev2 = 0.1", "gain_N_s2_per_rev2: does not go with input = 'command'"),
        ('input = "command"', 'input = "rpm"', "thruster[0].input: expected one of rev_s, command, N; found 'rpm'"),
        ("dead_band = 0.05", "dead_band_rev_s = 0.5", "dead_band_rev_s: does not go with input = 'command'"),
        ("gain_N = 20.0", 'curve = "t20"', "no bench table 't20'; did you mean 't200'?"),
        ("gain_N = 20.0", 'curve = "none.csv"', "block.toml: thruster[0].curve: no file "),
        ("gain_N = 20.0", 'curve = "benhc.csv"', "benhc.csv; did you mean 'bench.csv'? there are: bench.csv"),
        ('mjcf = "block.xml"', 'mjcf = "blok.xml"', "block.toml: mjcf: no file "),
        ('mjcf = "block.xml"', 'mjcf = "blok.xml"', "blok.xml; did you mean 'block.xml'? there are: block.xml"),
        ('input = "command"', 'input = "N"', "thruster[0].gain_N: does not go with input = 'N'; expected limit_N"),
        (
            "gain_N = 20.0",
            'curve = "block.xml"',
            "thruster[0].curve: no bench table 'block.xml'; there are: bench, kingfisher_thrust, t200",
        ),
        ('input = "command"\n', "", "thruster[0].input: missing: 'command' or 'rev_s' with a gain or a curve"),
        ('input = "command"', "limit_N = 9.0", "thruster[0].gain_N: does not go with no input, which is then 'N'"),
        ("area_m2 = 0.01", "area_cm2 = 100.0", "fin[0].area_cm2: unknown key; did you mean 'area_m2'?"),
        ("axis = [0.0, 0.0, 1.0]", "axis = [1.0, 0.0, 0.0]", "fin[0].axis: expected a direction across the hull"),
        ('"sway_m_s"]', '"sway_ms"]', "sensor.dvl.channels: unknown channel 'sway_ms'; did you mean 'sway_m_s'?"),
        ("noise = [0.01, 0.01]", "noise = [0.01]", "sensor.dvl.noise: expected 2 numbers, one for each channel"),
        ("rate_hz = 5.0", "rate = 5.0", "sensor.dvl.rate: "),
        ("[[fin]]", '[[thruster]]\nname = "main"\nsite = "stern"\ndirection = [0,1,0]\nlimit_N = 1\n[[fin]]', "taken"),
        ('name = "rudder"', 'name = "main"', "fin[0].name: 'main' is taken, by thruster[0]; expected"),
        ('site = "stern"\ndirection', 'site = "sternn"\ndirection', "thruster[0].site: the MJCF has no site 'sternn'"),
        ("mass_kg = 10.0", "mass_kg = 11.0", "kg; is one of them without payload or ballast?"),
        ("stern_m = [-0.5, 0.0, 0.1]", "stern_m = [-0.5, 0.0, -0.1]", "the z axis of one of them points up"),
        ("stern_m = [-0.5, 0.0, 0.1]", "stern_m = [-0.6, 0.0, 0.1]", "sites.stern_m: found [-0.6, 0, 0.1] m, but"),
        (
            "mass_kg = 10.0",
            "mass_kg = 10.0\ninertia_kg_m2 = [4.0, 5.0, 6.0]",
            "body.inertia_kg_m2: found [4, 5, 6], but",
        ),
        (
            "mass_kg = 10.0",
            "mass_kg = 10.0\ncentre_of_gravity_m = [0.1, 0.0, 0.0]",
            "body.centre_of_gravity_m: found [0.1, 0, 0], but",
        ),
        ('"sway_m_s"]', '"surge_m_s"]', "sensor.dvl.channels: 'surge_m_s' is given twice"),
        ('name = "main"', 'name = "main, aft"', "thruster[0].name: expected a name without blank, comma"),
        ('name = "rudder"', 'name = "a.b"', "fin[0].name: expected a name without blank, comma"),
        ("[sensor.dvl]", '[sensor."d,vl"]', "expected a name without blank, comma"),
        ("m = [0.0, 0.0, -0.01]", "m = [0.0, 0.0, 0.01]", "centre_of_buoyancy_m: z = 0.01 m is below the centre of"),
    ],
)
def test_a_bad_vehicle_file_names_file_key_and_cause(tmp_path: Path, find: str, replacement: str, said: str) -> None:
    assert find in BLOCK
    path = written(tmp_path, BLOCK.replace(find, replacement, 1))
    (tmp_path / "bench.csv").write_text("command,force_N\n-1,-20\n1,20\n", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_whole(load_vehicle(path)).flight(2)
    assert said in str(caught.value)
    assert str(tmp_path) in str(caught.value)


def test_a_bench_table_out_of_order_names_its_line(tmp_path: Path) -> None:
    path = written(tmp_path, BLOCK.replace("gain_N = 20.0", 'curve = "bench.csv"'))
    for text, said in (
        ("command,force_N\n0,0\n0,1\n", "line 3: expected finite numbers, command increasing"),
        ("command,force_N\n0,zero\n", "line 2: expected two numbers"),
        ("rev_s,force_N\n0,0\n1,1\n", "line 1: expected the header 'command,force_N'"),
        ("command,force_N\n0,0\n", "expected two points or more"),
        ("command,force_N\n-100,-30\n100,40\n", "line 2: expected command from -1 to 1 .* is it in percent"),
        ("command,force_N\n0,0\n1,1e300\n", "line 3: .* a force within 1e.08 N"),
    ):
        (tmp_path / "bench.csv").write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match=f"bench.csv.*{said}"):
            load_vehicle(path)


def test_a_z_axis_that_points_up_in_the_mjcf_is_seen_by_the_sites(tmp_path: Path) -> None:
    """The vehicle file is in axes z down; an MJCF whose numbers are so, but whose body stands z up, is turned over."""
    path = written(tmp_path, xml=XML.replace('quat="0 1 0 0"', ""))
    with pytest.raises(InputError, match="points up; it must point down, y to starboard"):
        load_whole(load_vehicle(path))


def test_gravity_is_the_same_for_the_tank_and_all_who_estimate(tmp_path: Path) -> None:
    """Where the MJCF says nothing, MuJoCo takes 9.81: 0.03 N more on 10 kg, which a diagnosis would find and name."""
    for gravity in ("", 'gravity="0 0 -9.81"'):
        option = f"<option {gravity}/>" if gravity else ""
        path = written(tmp_path, xml=XML.replace("<worldbody>", f"{option}<worldbody>"))
        assert load_whole(load_vehicle(path)).model.opt.gravity == pytest.approx([0.0, 0.0, -G_M_S2])


def test_a_time_step_that_no_flight_can_end_with_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, xml=XML.replace("<worldbody>", '<option timestep="1e-9"/><worldbody>'))
    with pytest.raises(InputError, match="5e.09 steps; expected at most"):
        fly_vehicle(path, {"time_s": [0.0], "main_command": [0.5]}, 5.0)


def test_what_is_not_in_the_water_or_in_a_torrent_is_not_flown(tmp_path: Path) -> None:
    """A body above the surface is refused as a depth above it is; the current has the bound that its effect has."""
    path, drive = written(tmp_path, xml=XML.replace('name="block"', 'name="block" pos="0 0 2"')), {"time_s": [0.0]}
    for settings, said in (
        ({}, r"block.xml: <body pos>: block would start 2 m above the surface"),
        ({"depth_m": -3.0}, "^depth_m: block would start 3 m above the surface"),
        ({"depth_m": 3.0, "current_m_s": (50.0, 0.0, 0.0)}, "current_m_s: expected three numbers, .* from -5 to 5 m/s"),
        ({"depth_m": 3.0, "current_m_s": (0.1, 0.0)}, "current_m_s: expected three numbers"),
    ):
        with pytest.raises(InputError, match=said):
            fly_vehicle(path, drive, 1.0, **settings)
    assert fly_vehicle(path, drive, 1.0, depth_m=3.0, current_m_s=(5.0, 0.0, 0.0)).duration_s > 0.0


def test_a_sound_file_flies(tmp_path: Path) -> None:
    run = fly_vehicle(written(tmp_path), {"time_s": [0.0], "main_command": [0.5], "rudder_rad": [0.05]}, 5.0)
    assert run.samples("dvl.surge_m_s")[1][-1] > 0.3


def test_the_command_line_refuses_a_bad_vehicle_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Exit code 2 and one line, from a scenario that names it."""
    path = written(tmp_path, BLOCK.replace("lag_s = 0.1", "lagg_s = 0.1"))
    settings = ["--set", f"vehicle={path}", "--out", str(tmp_path / "out")]
    assert main(["run", "sway", *settings]) == 2
    assert "thruster[0].lagg_s: unknown key" in capsys.readouterr().err


def test_sensors_and_actuators_of_a_users_own_change_nothing(tmp_path: Path) -> None:
    """Instruments are read by their names, and controls are the vehicle's: not by the order in the MJCF."""
    drive, basin = (
        {"time_s": [0.0], "main_command": [0.3], "rudder_rad": [0.05]},
        (models_dir() / "basin.xml").read_text(),
    )
    flown = []
    for own, others in (
        ("", ""),
        ("<sensor><clock/><framepos objtype='body' objname='block'/></sensor>", "<sensor><clock/></sensor>"),
        ("<sensor><clock/></sensor>", "<actuator><adhesion body='post' ctrlrange='0 1'/></actuator>"),
    ):
        walls, post = (
            tmp_path / "walls.xml",
            "<worldbody><body name='post'><geom size='0.01' pos='0 2 -2'/></body></worldbody>",
        )
        walls.write_text(basin.replace("</mujoco>", f"{post}{others}</mujoco>"), encoding="utf-8")
        path = written(tmp_path, xml=XML.replace("</mujoco>", f"{own}</mujoco>"))
        flown.append(fly_vehicle(path, drive, 2.0, walls=walls, depth_m=1.0))
    for run in flown[1:]:
        for name, values in flown[0].columns.items():
            assert np.array_equal(run.columns[name], values, equal_nan=True), name
