"""The BlueROV2 and the other axes: the same files, the same simulation, the same identification."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from documents import blocks

from vtank.cli import main
from vtank.errors import InputError
from vtank.estimate.maximum_likelihood import identify
from vtank.estimate.observed import observe
from vtank.experiment import Plan, Result, plan_run, simulate_surge, simulate_tank
from vtank.experiment.scenario import load_scenario
from vtank.plant.parameters import vector
from vtank.plant.truth import load_truth
from vtank.plant.vehicle import AXES, load_vehicle
from vtank.record import read_dataset
from vtank.resources import models_dir
from vtank.tank import load_world
from vtank.tank.model import rigid_mass, vehicle_body

MODELS = models_dir()
NUMBERS = tomllib.loads((MODELS / "bluerov2.toml").read_text(encoding="utf-8"))
SHARP = ("sonar.noise_m=0", "sonar.resolution_m=0", "tachometer.noise_rev_s=0")


def plan(name: str, *settings: str) -> Plan:
    return plan_run(load_scenario(name, settings))


def fly(name: str, *settings: str) -> Result:
    return simulate_tank([plan(name, *settings)])[0]


def inertia(vehicle: str, axis: str) -> float:
    """Mass or moment of inertia along an axis, with added mass [kg or kg m2]."""
    model, row = load_world(load_vehicle(vehicle), MODELS / "basin.xml"), AXES.index(axis)
    return float((rigid_mass(model, vehicle_body(model)) + load_vehicle(vehicle).added_mass)[row, row])


def origins(content: object) -> list[dict]:
    """Every number of a vehicle file that states an origin."""
    if isinstance(content, dict):
        return [content] if "value" in content else [e for part in content.values() for e in origins(part)]
    return [e for part in content for e in origins(part)] if isinstance(content, list) else []


def test_every_number_has_source_and_confidence() -> None:
    found = origins(NUMBERS) + origins(tomllib.loads((MODELS / "truths" / "bluerov2.toml").read_text(encoding="utf-8")))
    assert len(found) > 40
    for entry in found:
        assert re.fullmatch(r"(B\d|-)", entry["source"]) and entry["confidence"] in ("H", "M", "L", "U", "guess")


def test_the_rigid_body_is_the_one_of_the_vehicle_file() -> None:
    vehicle, model = load_vehicle("bluerov2"), load_world(load_vehicle("bluerov2"), MODELS / "basin.xml")
    body = model.body("bluerov2")
    assert body.mass[0] == vehicle.mass_kg and model.body_mass.sum() == vehicle.mass_kg
    assert body.inertia == pytest.approx(NUMBERS["body"]["inertia_kg_m2"]["value"])
    assert body.ipos == pytest.approx(NUMBERS["body"]["centre_of_gravity_m"]["value"])
    assert vehicle.buoyancy_N == pytest.approx(-model.opt.gravity[2] * vehicle.mass_kg, rel=1e-12)
    for name, place in vehicle.sites.items():
        assert model.site(name).pos == pytest.approx(place, abs=1e-12), name


def test_the_thrusters_make_the_published_allocation() -> None:
    """Moments of the four vectored thrusters about z: 0.1888 m each; of the vertical ones about x and y."""
    vehicle = load_vehicle("bluerov2")
    wrench = np.array(
        [np.append(t.direction, np.cross(vehicle.sites[t.site], t.direction)) for t in vehicle.steering]
    ).T
    assert wrench[:2, :4] == pytest.approx(np.array([[1, 1, -1, -1], [-1, 1, -1, 1]]) / np.sqrt(2.0))
    assert wrench[5, :4] == pytest.approx(0.1888 * np.array([-1, 1, 1, -1]), abs=1e-4)
    assert np.abs(wrench[3, 4:]) == pytest.approx(0.218) and np.abs(wrench[4, 4:]) == pytest.approx(0.12)


def test_the_truth_preset_is_the_published_surge() -> None:
    truth, vehicle = load_truth("bluerov2"), load_vehicle("bluerov2")
    assert truth.alpha_per_m * vehicle.moving_mass_kg == pytest.approx(-141.0)
    assert truth.effects["linear_drag.c"] * vehicle.moving_mass_kg == pytest.approx(13.7, rel=1e-3)
    bollard = truth.beta_m_per_rev2 * vehicle.moving_mass_kg * truth.n_limit_rev_s**2
    assert bollard == pytest.approx(4.0 * 40.0 / np.sqrt(2.0), rel=5e-3)


def test_the_second_vehicle_surges_in_the_tank_as_on_the_surge_model() -> None:
    both = plan("bluerov2-surge", "hold=rigid", "duration_s=60")
    tank, surge = simulate_tank([both])[0], simulate_surge([both])[0]
    np.testing.assert_allclose(tank.true["position_m"], surge.true["position_m"], rtol=0, atol=2e-5)
    assert np.ptp(tank.true["position_m"]) > 0.2


CASES = [
    ("sway", "phoenix"),
    ("heave", "phoenix"),
    ("yaw", "phoenix"),
    ("bluerov2-sway", "bluerov2"),
    ("bluerov2-heave", "bluerov2"),
    ("bluerov2-yaw", "bluerov2"),
]


@pytest.mark.parametrize(("name", "vehicle"), CASES)
def test_what_is_identified_along_an_axis_is_what_the_vehicle_file_says(name: str, vehicle: str) -> None:
    """Quadratic drag and inertia from thrust_N and position_m, by the identification of surge as it stands.

    The Phoenix turns with sway held rigid: its coupling through N_vdot would add 2 % to the inertia of yaw.
    """
    result = fly(name, f"hold={'rigid' if name == 'yaw' else 'thrusters'}")
    result.check_clearance()
    assert set(result.run.columns) == {"thrust_N", "position_m"}
    axis = result.plan.scenario.excitation.axis
    mass, row = inertia(vehicle, axis), AXES.index(axis)
    drag = load_vehicle(vehicle)
    known = vector({"linear_input": 1.0, "linear_drag.c": drag.linear_drag[row] / mass})
    estimate = identify([observe(result.run)], model="I", base=known)
    assert 1.0 / estimate.values["beta"] == pytest.approx(mass, rel=0.01)
    assert -estimate.values["alpha"] * mass == pytest.approx(drag.quadratic_drag[row], rel=0.04)


@pytest.mark.parametrize("axis", ["sway", "heave", "yaw"])
def test_a_steady_push_ends_at_the_speed_that_drag_balances(axis: str, tmp_path: Path) -> None:
    """M dv/dt = F - c v - D v^2 from rest, the other axes held rigid."""
    vehicle, row = load_vehicle(), AXES.index(axis)
    unit, force = ("N_m", 1.0) if axis == "yaw" else ("N", 2.0)
    step = ("excitation.kind=step_coast", f"excitation.amplitude_{unit}={force}", "excitation.push_s=1000")
    settings = [*step, "excitation.coast_s=0", f"excitation.axis={axis}", "hold=rigid", "duration_s=60", *SHARP]
    (tmp_path / "push.toml").write_text("[excitation]\n")
    result = simulate_tank([plan_run(load_scenario(tmp_path / "push.toml", settings))])[0]
    drag, linear, mass = vehicle.quadratic_drag[row], vehicle.linear_drag[row], inertia("phoenix", axis)
    t, place = result.run.time_s, result.run.columns["position_m"]
    np.testing.assert_allclose(result.run.columns["thrust_N"], force, rtol=1e-12)
    root = np.sqrt(linear**2 + 4.0 * drag * force)
    fast, slow = (root - linear) / (2.0 * drag), -(root + linear) / (2.0 * drag)
    ratio = -fast / slow * np.exp(-root / mass * t)  # m dv/dt = -D (v - fast) (v - slow), by partial fractions
    speed = fast * (1.0 - np.exp(-root / mass * t)) / (1.0 + ratio)
    moved = np.concatenate([[0.0], np.cumsum(0.05 * (speed[1:] + speed[:-1]))])
    np.testing.assert_allclose(place, moved, rtol=0, atol=2e-3 * moved[-1])


def test_the_how_to_is_current(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The vehicle of HOWTO.md flies as it stands there, and its sway is identified: held rigid, since it would roll."""
    for block in blocks(MODELS / "HOWTO.md"):
        if block.file.startswith("mine"):
            (tmp_path / block.file).write_text(block.text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["run", "mine-sway.toml", "--out", "free"]) == 0
    assert main(["run", "mine-sway.toml", "--out", "sway", "--set", "hold=rigid"]) == 0
    assert main(["check-data", "sway"]) == 0 and "thrust_N" in capsys.readouterr().out
    (run,) = read_dataset(tmp_path / "sway")
    estimate = identify([observe(run)], model="I")
    assert 1.0 / estimate.values["beta"] == pytest.approx(75.0, rel=0.02)
    assert -75.0 * estimate.values["alpha"] == pytest.approx(90.0, rel=0.1)
    surge = ["--set", "excitation={kind='position_sine',amplitude_m=0.3,frequency_rad_s=0.5}", "--set", "duration_s=20"]
    assert main(["run", "mine-sway.toml", "--out", "surge", *surge]) == 0


def test_other_axes_stay_while_one_is_moved() -> None:
    for name in ("sway", "heave"):
        true = fly(name, "duration_s=60").true
        other = {"sway": "depth_m", "heave": "sway_m"}[name]
        assert np.ptp(true[other]) < 0.02 and np.abs(true["position_m"]).max() < 0.05


def test_a_motion_that_leaves_the_room_is_told() -> None:
    for name, settings in (("sway", "excitation.offset_m=2.6"), ("heave", "excitation.offset_m=1.2")):
        with pytest.raises(InputError, match=f"{name}.toml.*simulated {name} moved .* room is"):
            fly(name, settings, "hold=rigid", "excitation.ramp_s=40", "duration_s=80").check_clearance()


def test_the_surge_model_refuses_other_axes() -> None:
    with pytest.raises(InputError, match="sway.toml: excitation.axis: the surge model has no sway"):
        simulate_surge([plan("sway")])


def test_what_does_not_fit_together_is_told(tmp_path: Path) -> None:
    heavy = (MODELS / "bluerov2.toml").read_text().replace("value = 13.5", "value = 14.5", 1)
    (tmp_path / "heavy.toml").write_text(heavy)
    (tmp_path / "bluerov2.xml").write_text((MODELS / "bluerov2.xml").read_text())
    with pytest.raises(InputError, match="mass 13.5 kg, but the vehicle file says mass_kg 14.5"):
        fly("bluerov2-sway", f"vehicle={tmp_path / 'heavy.toml'}")
    (tmp_path / "deaf.xml").write_text((MODELS / "bluerov2.xml").read_text().replace("sonar_ping", "ping"))
    (tmp_path / "deaf.toml").write_text((MODELS / "bluerov2.toml").read_text().replace("bluerov2.xml", "deaf.xml"))
    with pytest.raises(InputError, match="deaf.xml: no sonar"):
        fly("bluerov2-sway", f"vehicle={tmp_path / 'deaf.toml'}", "duration_s=3")
    with pytest.raises(InputError, match="bluerov2-sway.toml: walls: no walls named 'harbour'; there are: basin, sea"):
        fly("bluerov2-sway", "walls=harbour")
    for setting, said in (
        ("excitation.axis=roll", "expected one of surge, sway, heave, pitch, yaw"),
        ("excitation.kind=speed_sine", "surge has a propeller speed"),
    ):
        with pytest.raises(InputError, match=said):
            fly("bluerov2-sway", setting)
