"""A user's own MJCF in the tank: it need not know of it, and what cannot work is refused by file and reason."""

from __future__ import annotations

import os
import time
import warnings
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from bodies import MJCF, afloat, without_drag

from vtank.errors import InputError
from vtank.experiment import Result, plan_run, simulate_tank
from vtank.experiment.scenario import load_scenario
from vtank.plant.truth import load_truth
from vtank.plant.vehicle import load_vehicle
from vtank.resources import models_dir
from vtank.tank import Tank, load_world
from vtank.tank.mjcf import mujoco_says, read
from vtank.tank.model import centre_of_gravity, rigid_mass, site, sonars, vehicle_body
from vtank.tank.whole import load_whole

XML = MJCF.format(timestep=0.01, gravity=-9.81)
BASIN = models_dir() / "basin.xml"

# Made for another purpose: own solver, step, fluid, contacts, names of the basin's, a crane with its motor, a floor.
FOREIGN = """
<mujoco model="foreign">
  <compiler angle="degree" alignfree="true" inertiagrouprange="3 3"/>
  <option integrator="implicitfast" timestep="0.003" solver="CG" cone="elliptic" density="1000" viscosity="0.001"/>
  <size memory="2M"/>
  <visual><global offwidth="700"/><map zfar="99"/></visual>
  <asset>
    <texture name="tiles" type="2d" builtin="checker" width="32" height="32"/>
    <material name="tiles" texture="tiles"/>
    <material name="water" rgba="0 0 1 1"/>
  </asset>
  <default><default class="echo"><geom group="3" rgba="1 0 0 1"/></default></default>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1" material="tiles" group="3" pos="0 0 -1.2"/>
    <body name="crane" pos="5 5 0">
      <joint name="lift" type="slide" range="0 1"/>
      <geom class="echo" size="0.1"/>
    </body>
    <frame pos="2 3 0">
      <body name="box" pos="0 0 {z}" {pose}>
        <freejoint/>
        <geom class="echo" type="box" size="0.3 0.2 0.1" mass="39" material="water"/>
        <camera name="overview" pos="0.3 0 0"/>
        <site name="propeller" pos="-0.3 0 0"/>
        <site name="bow" pos="0.2 0 0"/>
        <site name="stern" pos="-0.2 0 0"/>
        <body name="keel" pos="0 0 {down}">
          <geom class="echo" size="0.03" mass="1"/>
          <site name="sonar" pos="0.35 0 {up}"/>
        </body>
      </body>
    </frame>
  </worldbody>
  <actuator><motor name="winch" joint="lift"/></actuator>
  <sensor><accelerometer name="imu" site="sonar"/></sensor>
  <keyframe><key name="up" qpos="0 0 0 0 1 0 0 0"/></keyframe>
</mujoco>
"""
FORWARD_RIGHT_DOWN = {"z": -1, "pose": 'euler="180 0 0"', "down": 0.08, "up": -0.04}
FORWARD_LEFT_UP = {"z": 4, "pose": "", "down": -0.08, "up": 0.04}
NUMBERS = """
name = "foreign"
mjcf = "foreign.xml"
body = { mass_kg = 40.0, centre_of_buoyancy_m = [0.0, 0.0, 0.0], buoyancy_N = 392.4 }
added_mass = { surge_kg = 4.0, sway_kg = 35.0, heave_kg = 35.0, roll_kg_m2 = 0.1, pitch_kg_m2 = 3.0, yaw_kg_m2 = 3.0 }
propeller = { sites = ["propeller"], diameter_m = 0.15 }
thruster = [
  { site = "bow", direction = [0.0, 0.0, 1.0], limit_N = 20.0 },
  { site = "stern", direction = [0.0, 0.0, 1.0], limit_N = 20.0 },
  { site = "bow", direction = [0.0, 1.0, 0.0], limit_N = 20.0 },
  { site = "stern", direction = [0.0, 1.0, 0.0], limit_N = 20.0 },
]
[quadratic_drag]
surge_N_s2_per_m2 = 12.0
sway_N_s2_per_m2 = 90.0
heave_N_s2_per_m2 = 90.0
roll_N_m_s2_per_rad2 = 1.0
pitch_N_m_s2_per_rad2 = 15.0
yaw_N_m_s2_per_rad2 = 15.0
"""


def vehicle_file(folder: Path, xml: str) -> Path:
    """A vehicle of one's own in two files; returns the path of its numbers."""
    (folder / "foreign.xml").write_text(xml)
    (folder / "foreign.toml").write_text(NUMBERS)
    return folder / "foreign.toml"


def fly(vehicle: Path, *settings: str) -> Result:
    """20 s of the paper's first experiment with another vehicle."""
    quiet = ("sonar.noise_m=0", "sonar.resolution_m=0", "tachometer.noise_rev_s=0")
    return simulate_tank(
        [plan_run(load_scenario("paper-ds1", [f"vehicle={vehicle}", "duration_s=20", *quiet, *settings]))]
    )[0]


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Result:
    """The foreign vehicle, its axes as vtank has them."""
    return fly(vehicle_file(tmp_path_factory.mktemp("down"), FOREIGN.format(**FORWARD_RIGHT_DOWN)))


def test_a_foreign_mjcf_flies_as_it_is(flown: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Held to its course by its thrusters, before the wall that the scenario names; nothing is left in the folder."""
    monkeypatch.chdir(tmp_path)
    held = fly(vehicle_file(tmp_path, FOREIGN.format(**FORWARD_RIGHT_DOWN)), "hold=rigid").true
    assert sorted(path.name for path in tmp_path.iterdir()) == ["foreign.toml", "foreign.xml"]
    assert held["range_m"] == pytest.approx(3.048 - held["position_m"], abs=1e-9)
    true = flown.true
    assert np.ptp(true["position_m"]) > 0.1
    assert true["position_m"] == pytest.approx(held["position_m"], abs=0.05)
    assert np.abs(true["depth_m"] - 0.9144).max() < 0.02 and np.abs(true["pitch_rad"]).max() < 0.1
    assert max(np.abs(true[name]).max() for name in ("sway_m", "roll_rad", "heading_rad")) < 1e-9


def test_the_axes_of_the_mjcf_are_its_own(flown: Result, tmp_path: Path) -> None:
    """The same body drawn x forward, y to port, z up, and high in the air, makes the same run."""
    other = fly(vehicle_file(tmp_path, FOREIGN.format(**FORWARD_LEFT_UP)))
    for name, values in flown.true.items():
        assert other.true[name] == pytest.approx(values, abs=1e-7), name


def test_everything_fixed_to_the_body_counts_in_axes_x_forward_z_down(tmp_path: Path) -> None:
    for form in (FORWARD_RIGHT_DOWN, FORWARD_LEFT_UP):
        model = load_world(load_vehicle(vehicle_file(tmp_path, FOREIGN.format(**form))), BASIN, 0.1)
        body = vehicle_body(model)
        assert site(model, "sonar") == pytest.approx([0.35, 0.0, 0.04], abs=1e-12) and sonars(model) == ["sonar"]
        assert centre_of_gravity(model, body) == pytest.approx([0.0, 0.0, 0.08 / 40.0], abs=1e-12)
        assert rigid_mass(model, body)[4, 0] == pytest.approx(40.0 * 0.08 / 40.0)
        assert model.qpos0[:2] == pytest.approx(0.0) and (model.nu, model.nq) == (5, 7)
        assert model.opt.timestep == pytest.approx(0.1 / 34) and model.opt.density == 0.0


def test_an_mjcf_made_for_earlier_versions_still_does(tmp_path: Path) -> None:
    """With room in userdata and two actuators that push nothing."""
    states = "".join(
        f'<general name="{name}" site="propeller" dyntype="integrator" gainprm="0"/>' for name in ("thrust_lag", "wake")
    )
    old = XML.replace("<worldbody>", '<size nuserdata="400"/><worldbody>')
    model = afloat(old.replace("</worldbody>", f"</worldbody><actuator>{states}</actuator>"))
    assert (model.nu, model.nuserdata) == (4, 0)  # of its own two none is left


@pytest.mark.parametrize(
    ("found", "instead", "message"),
    [
        ('gravity="0 0 -9.81"', 'gravity="0 1 -9.81"', "gravity must act"),
        ("<freejoint/>", '<joint type="free" armature="1"/>', "armature and frictionloss 0"),
        ("<freejoint/>", '<joint type="free" frictionloss="1"/>', "armature and frictionloss 0"),
        ("<freejoint/>", "", "0 bodies with a free joint"),
        ("<worldbody>", '<worldbody><body><freejoint/><geom size="1"/></body>', "2 bodies with a free joint"),
        ('<site name="side"', '<body><joint/><geom size="1"/></body><site name="side"', "one rigid body"),
        ("</mujoco>", '<actuator><motor name="t1" site="side"/></actuator></mujoco>', "the actuator 't1' acts on the"),
        (
            "</mujoco>",
            '<equality><weld body1="awkward"/></equality></mujoco>',
            "the equality constraint 'number 0' acts",
        ),
        (
            "</mujoco>",
            '<tendon><spatial name="tow"><site site="pole"/><site site="side"/></spatial></tendon></mujoco>',
            "the tendon 'tow' acts on the vehicle 'awkward'",
        ),
    ],
)
def test_a_vehicle_that_more_than_the_water_moves_is_refused(found: str, instead: str, message: str) -> None:
    xml = XML.replace("<worldbody>", '<worldbody><site name="pole"/>')
    assert found in xml
    with pytest.raises(InputError, match=message):
        afloat(xml.replace(found, instead, 1))


def walls(geoms: str) -> str:
    return f"<mujoco><worldbody>{geoms}</worldbody></mujoco>"


AHEAD = '<geom type="plane" pos="2 0 0" xyaxes="0 -1 0 0 0 1" size="9 9 1" {}/>'
PANE = '<geom type="plane" pos="1 0 0" xyaxes="0 -1 0 0 0 1" size="9 9 1" contype="0" conaffinity="0" {}/>'


@pytest.mark.parametrize(
    ("tank", "heard"),
    [
        (AHEAD.format('group="0"') + PANE.format('group="3"'), 2.0),
        (AHEAD.format('group="5"'), 2.0),
        (PANE.format('group="3"') + PANE.replace("1 0 0", "0.5 0 0").format('group="2"'), 1.0),
    ],
)
@pytest.mark.parametrize("look", [True, False])
def test_the_sonar_hears_what_would_stop_a_hull(tank: str, heard: float, look: bool, tmp_path: Path) -> None:
    """In whichever group it stands, and never the vehicle's own shape or the scenery of its file."""
    (tmp_path / "walls.xml").write_text(walls(tank))
    vehicle = load_vehicle(vehicle_file(tmp_path, FOREIGN.format(**FORWARD_RIGHT_DOWN)))
    with Tank(load_world(vehicle, tmp_path / "walls.xml", look=look), vehicle, without_drag()) as basin:
        away = np.array([[-0.9, 0.0, -1.0], [0.0, 0.0, -1.0]])
        distances = basin.ray(away, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]))
    assert distances[0] == pytest.approx([heard + 0.9, np.inf])


def test_without_its_look_a_model_moves_as_with_it() -> None:
    """Shapes, cameras and lights for the eye are left out, mass and inertia stay, and so does every byte of motion."""
    vehicle, truth = load_vehicle(), load_truth("paper-ii").vector()
    seen, plain = (load_world(vehicle, BASIN, look=look) for look in (True, False))
    assert (plain.ngeom, plain.ncam, plain.nlight) == (5, 0, 0) and seen.ngeom > 10 and seen.ncam > 0
    poses = []
    for model in (seen, plain):
        with Tank(model, vehicle, truth) as tank:
            tank.propeller_rev_s[:] = 8.0
            tank.step(500)
            poses.append(tank.qpos.tobytes())
    assert poses[0] == poses[1]


def test_files_that_are_no_tank_are_refused_by_name(tmp_path: Path) -> None:
    phoenix, broken = load_vehicle(), tmp_path / "broken.xml"
    with pytest.raises(InputError, match="nowhere.xml: no such MJCF file"):
        load_world(phoenix, tmp_path / "nowhere.xml")
    broken.write_text("<mujoco><worldbody>")
    with pytest.raises(InputError, match="broken.xml: MuJoCo cannot read it") as caught:
        load_world(phoenix, broken)
    assert "\n" not in str(caught.value)
    broken.write_text(walls(""))
    with pytest.raises(InputError, match="broken.xml: no walls"):
        load_world(phoenix, broken)
    broken.write_text(walls('<body name="gate"><joint/><geom size="1"/></body>'))
    with pytest.raises(InputError, match="broken.xml: the body 'gate' has a joint"):
        load_world(phoenix, broken)
    broken.write_text(walls('<geom size="1"/><body name="phoenix"/>'))
    with pytest.raises(InputError, match="phoenix.xml: MuJoCo cannot put it between the walls: .*repeated name"):
        load_world(phoenix, broken)
    broken.write_text(XML.replace('timestep="0.01"', 'timestep="0"').replace('mass="20"', f'mass="{phoenix.mass_kg}"'))
    with pytest.raises(
        InputError, match="broken.xml: the MJCF has no site 'propeller_port'; did you mean 'propeller'. there are: prop"
    ):
        load_world(replace(phoenix, mjcf=broken), BASIN)
    with pytest.raises(InputError, match="broken.xml: timestep 0 s; expected 1e-05 s or more"):
        load_world(replace(phoenix, mjcf=broken, propeller_sites=("propeller",)), BASIN)
    broken.write_text("<mujoco/>")
    with pytest.raises(InputError, match="broken.xml: 0 bodies with a free joint"):
        load_world(replace(phoenix, mjcf=broken), BASIN)


@pytest.mark.parametrize(
    "many",
    [
        '<replicate count="1000000"><geom size="1"/></replicate>',
        '<replicate count="1000"><replicate count="1000"><geom size="1"/></replicate></replicate>',
        '<flexcomp name="f" count="900 900 9" spacing="1 1 1"/>',
    ],
)
def test_more_than_a_tank_can_hold_is_refused_at_once(many: str, tmp_path: Path) -> None:
    (tmp_path / "part.xml").write_text(walls(many))
    (tmp_path / "walls.xml").write_text('<mujoco><include file="part.xml"/></mujoco>')
    start = time.monotonic()
    with pytest.raises(InputError, match="walls.xml: more than 5000 elements"):
        load_world(load_vehicle(), tmp_path / "walls.xml")
    assert time.monotonic() - start < 2.0


BOMBS = {
    "replicate": '<worldbody><replicate count="1000000"><geom size="1"/></replicate></worldbody>',
    "texture": '<asset><texture name="t" type="2d" builtin="flat" width="40000" height="40000"/></asset>',
    "hfield": '<asset><hfield name="h" nrow="20000" ncol="20000" size="1 1 1 1"/></asset>',
    "size": '<size nkey="100000000"/>',
    "nuser": '<size nuser_body="2000000000"/>',
    "itself": '<include file="bomb.xml"/>',
    "pipe": '<include file="pipe.xml"/>',
    "mesh": '<compiler meshdir="parts"/><asset><mesh name="m" file="pipe.stl"/></asset>',
    "device": '<asset><mesh name="m" file="/dev/zero" content_type="model/stl"/></asset>',
    "sparse": '<asset><mesh name="m" file="sparse.stl"/></asset>',
    "bytes": '<worldbody><geom name="\x90" size="1"/></worldbody>',
}


@pytest.mark.parametrize("bomb", BOMBS)
def test_a_small_file_that_asks_for_much_is_refused_at_once(bomb: str, tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    for pipe in ("pipe.xml", "parts/pipe.stl"):
        os.mkfifo(tmp_path / pipe)
    with (tmp_path / "sparse.stl").open("wb") as file:
        file.truncate(10 * 2**30)
    path = tmp_path / "bomb.xml"
    path.write_bytes(f"<mujoco>{BOMBS[bomb]}</mujoco>".encode("latin-1"))
    start = time.monotonic()
    with pytest.raises(InputError, match=r"bomb\.xml"):
        read(path)
    assert time.monotonic() - start < 5.0


def test_what_mujoco_warns_of_is_seen(tmp_path: Path) -> None:
    stone = "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(stone)
    data = mujoco.MjData(model)
    data.qvel[0] = np.nan
    with pytest.warns(UserWarning, match="MuJoCo warns: Nan, Inf or huge value"), mujoco_says("cannot step it"):
        mujoco.mj_step(model, data)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # nothing is said of the vehicles that come with vtank
        for name in ("phoenix", "bluerov2", "kingfisher", "remus100"):
            load_whole(load_vehicle(name))
