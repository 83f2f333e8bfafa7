"""Whole vehicles diagnosed: the effect, its place and its size, from recordings of a tank that has it."""

from __future__ import annotations

import importlib
import json
from dataclasses import replace

import numpy as np
import pytest
from test_rigid_motion import multisine

import vtank as vt
from vtank.errors import InputError
from vtank.experiment.whole import fly_vehicle
from vtank.experiment.whole_scenario import fly_scenarios

NOMINAL = vt.load_vehicle("bluerov2")
SOME = ("linear_drag", "coulomb_friction", "thruster_dead", "thrust_deadband", "gyro_bias", "magnetometer_bias",
        "sensor_latency", "current", "sensor_rotated")  # fmt: skip
WEAK = replace(NOMINAL, thrusters=tuple(
    replace(t, curve=tuple((n, 0.5 * f) for n, f in t.curve)) if t.site == "thruster_4" else t
    for t in NOMINAL.thrusters))  # fmt: skip
SENSORS = tuple(s for s in NOMINAL.sensors if s.name in ("imu", "ahrs", "dvl", "depth"))


def flight(vehicle, seed: int) -> vt.Run:
    """What four instruments record of 60 s in the tank."""
    told = multisine(NOMINAL, 60.0, seed)
    return fly_vehicle(replace(vehicle, sensors=SENSORS), told, 60.0, seed)


@pytest.fixture(scope="module")
def dragging() -> vt.WholeDiagnosis:
    """A vehicle whose yaw drags with its rate, which the vehicle file has not."""
    drag = NOMINAL.linear_drag + [0.0, 0.0, 0.0, 0.0, 0.0, 0.6]
    return vt.diagnose([flight(replace(NOMINAL, linear_drag=drag), 3)], nominal=NOMINAL, effects=SOME)


def test_an_effect_is_named_with_its_axis_and_its_size(dragging):
    verdict = dragging.verdict
    assert (verdict.kind, verdict.effects, verdict.places) == ("effect", ("linear_drag",), ("yaw",))
    assert verdict.probability > 0.95
    value, sd = dragging.selection.best.values(dragging.selection.best.effects[0])["c"]
    assert abs(value - 0.6) < 4.0 * sd
    assert 0.0 < sd < 0.06


def test_the_budget_adds_up_and_lays_the_gap_to_the_effect(dragging):
    lines = dragging.document["budget"]
    assert sum(line["share"] for line in lines) == pytest.approx(1.0)
    assert [line["kind"] for line in lines][:2] == ["parameters", "effect"]
    shares = {line["name"]: line["share"] for line in lines}
    assert shares["linear_drag@yaw"] > 0.05  # quadratic drag, refitted first, imitates most of it
    assert shares["own parameters"] + shares["linear_drag@yaw"] > 0.8
    rms = dragging.document["channels"]["imu.yaw_rate_rad_s"]["rms"]
    assert rms["diagnosed"] < 0.3 * rms["nominal"]


def test_a_simulation_that_runs_away_is_far_off(dragging, monkeypatch):
    budget = importlib.import_module("vtank.diagnose.whole.budget")
    model = dragging.selection.best
    before, _ = budget.free_errors(model)
    monkeypatch.setattr(budget, "innovations", lambda run, *_, **__: np.full(run.time_s.size, np.nan))
    lost, count = budget.free_errors(model)
    assert np.isfinite(lost).all()
    assert np.all(lost[count > 0] > before[count > 0])


@pytest.mark.slow
def test_a_dead_thruster_is_told_from_the_other_seven():
    dead = replace(NOMINAL, thrusters=tuple(
        replace(t, curve=tuple((n, 1e-9 * f) for n, f in t.curve)) if t.site == "thruster_6" else t
        for t in NOMINAL.thrusters))  # fmt: skip
    found = vt.diagnose([flight(dead, 4)], nominal=NOMINAL, effects=SOME)
    alike = ("thruster_dead@thruster_6", "thrust_deadband@thruster_6")  # a dead band that no input crosses
    assert f"{found.verdict.effects[0]}@{found.verdict.places[0]}" in alike and len(found.verdict.effects) == 1
    assert set(found.verdict.rivals) == set(alike), "told together"
    assert sum(found.probabilities.get(name, 0.0) for name in alike) > 0.95


@pytest.mark.slow
def test_places_that_act_alike_are_told_together():
    """In a turn two thrusters push in opposite ways with the same force: about yaw alone either may be the weak one.

    Were it weak by 30 %, the four that turn the vehicle might as well be off by 7 % each: about yaw they are one force.
    """
    settings = ("vehicle=bluerov2", "duration_s=60", 'effects."thruster_dead@thruster_1".share=0.6')
    _, (flown,) = fly_scenarios(["whole/zigzag"], settings)
    found = vt.diagnose([flown.run], nominal=NOMINAL, axes=("yaw",), effects=("thruster_dead",))
    alike = {"thruster_dead@thruster_1", "thruster_dead@thruster_3"}
    assert {name for name, chance in found.probabilities.items() if chance > 0.1} == alike
    assert alike <= set(found.document["verdict"]["class"])


@pytest.mark.slow
@pytest.mark.parametrize(("more", "kind"), [(1.0, "none"), (1.004, "none"), (1.12, "parameters")])
def test_a_vehicle_as_its_file_has_it_has_no_gap(more, kind):
    """Nor one whose drag is off by what honest programs of one file differ by; what is off by more has its name."""
    verdict = vt.diagnose(
        [flight(replace(NOMINAL, quadratic_drag=more * NOMINAL.quadratic_drag), 5)], nominal=NOMINAL, effects=SOME
    ).verdict
    assert (verdict.kind, verdict.effects) == (kind, ())


@pytest.mark.slow
def test_a_drag_far_beyond_what_the_file_has_is_an_effect():
    """Though own drag could take it up, at a size that is hardly the file's: a score test has to see that."""
    known, drag = (replace(NOMINAL, linear_drag=NOMINAL.linear_drag + [0.0, 0.0, 0.0, 0.0, 0.0, c]) for c in (0.2, 1.0))
    verdict = vt.diagnose([flight(drag, 3)], nominal=known, effects=SOME).verdict
    assert (verdict.effects, verdict.places) == (("linear_drag",), ("yaw",))


@pytest.mark.slow
@pytest.mark.parametrize("axes", ["surge,sway,yaw", "yaw", "surge"])
def test_errors_of_instruments_that_tell_of_known_motion_are_no_gap(axes):
    """A pitch that is read 5 mrad off would seem to be 50 mm/s2 of an accelerometer if it were taken at its word."""
    _, (flown,) = fly_scenarios(["whole/turns-and-steps"], ("vehicle=bluerov2", "duration_s=40"))
    found = vt.diagnose([flown.run], nominal=NOMINAL, axes=axes.split(","), effects=SOME)
    assert found.verdict.kind == "none"
    assert not found.verdict.unexplained
    judged = {column.rpartition(".")[2] for column in found.document["channels"]}
    assert "pitch_rad" not in judged and "roll_rate_rad_s" not in judged


def test_every_outlet_shows_the_same(dragging, tmp_path):
    dragging.write_json(tmp_path / "d.json")
    dragging.report(tmp_path / "d.html")
    document = json.loads((tmp_path / "d.json").read_text(encoding="utf-8"))
    assert document["schema"] == "vtank.diagnosis/2"
    assert document["verdict"]["places"] == ["yaw"]
    page, text = (tmp_path / "d.html").read_text(encoding="utf-8"), str(dragging)
    size = f"{document['effects'][0]['values']['c']['value']:.4g}"
    assert size in page
    assert size in text
    assert "linear_drag@yaw" in page
    assert "<svg" in page


def test_a_saved_model_foretells_a_flight_that_it_has_not_seen(dragging, tmp_path):
    dragging.save(tmp_path / "model.toml")
    drag = NOMINAL.linear_drag + [0.0, 0.0, 0.0, 0.0, 0.0, 0.6]
    found = vt.predict(tmp_path / "model.toml", flight(replace(NOMINAL, linear_drag=drag), 6))
    rate = found["columns"]["imu.yaw_rate_rad_s"]
    assert rate["diagnosed"] < 0.3 * rate["nominal"]
    assert rate["diagnosed"] == pytest.approx(rate["noise"], rel=0.5)


@pytest.mark.slow
def test_own_parameters_are_identified_with_honest_deviations():
    """Drag of surge 25 % and added mass of yaw 20 % above the file's, within four deviations."""
    drag, added = NOMINAL.quadratic_drag.copy(), NOMINAL.added_mass.copy()
    drag[0] *= 1.25
    added[5, 5] *= 1.2
    found = vt.identify([flight(replace(NOMINAL, quadratic_drag=drag, added_mass=added), 7)], nominal=NOMINAL)
    for name, true in (("quadratic_drag@surge", drag[0]), ("added_mass@yaw", added[5, 5])):
        assert abs(found.values[name] - true) < 4.0 * found.sd[name], name
        assert found.sd[name] < 0.1 * true, name
    assert "quadratic_drag@surge" in str(found)


def test_a_whole_recording_without_a_vehicle_names_what_is_missing():
    run = flight(NOMINAL, 5)
    with pytest.raises(InputError, match="--nominal vehicle.toml"):
        vt.diagnose([run])
    with pytest.raises(InputError, match="found bluerov; did you mean 'bluerov2'. there are: bluerov2, "):
        vt.diagnose([run], nominal="bluerov")
    with pytest.raises(InputError, match="no axis 'yaww'; did you mean 'yaw'. there are: surge"):
        vt.diagnose([run], nominal=NOMINAL, axes=("surge", "yaww"))
    with pytest.raises(InputError, match="axis 'sideways'"):
        vt.diagnose([run], nominal=NOMINAL, axes=("sideways",))
    at_stop = {name: 0.0 * values if "command" in name else values for name, values in run.columns.items()}
    with pytest.raises(InputError, match="motors at stop"):
        vt.diagnose([vt.Run("moored", run.time_s, at_stop)], nominal=NOMINAL)
    driven = {name: values for name, values in run.columns.items() if "command" not in name}
    with pytest.raises(InputError, match="no actuator channel"):
        vt.diagnose([vt.Run("silent", run.time_s, driven)], nominal=NOMINAL)
    still = {name: np.full(run.time_s.size, np.nan) if "." in name else v for name, v in run.columns.items()}
    with pytest.raises(InputError, match="no measurement"):
        vt.diagnose([vt.Run("blind", run.time_s, still)], nominal=NOMINAL)


def test_a_simulator_that_is_far_off_does_not_lose_its_errors_as_spikes(tmp_path):
    """Readings are lone by the diagnosed model: those that the nominal misses by many deviations are its errors."""
    (tmp_path / "model.toml").write_text(
        'schema = "vtank.whole/2"\nvehicle = "bluerov2"\naxes = ["surge", "sway", "yaw"]\n'
        '[noise]\nsigma = [1e-4, 1e-4, 0, 0, 0, 1e-4]\n[refit]\n[diagnosed]\n"lost@thruster_4" = 0.5\n'
    )
    columns = vt.predict(tmp_path / "model.toml", flight(WEAK, 6))["columns"]
    turns = {name: columns[name] for name in ("ahrs.heading_rad", "imu.yaw_rate_rad_s")}
    assert all(found["nominal"] > 4.0 * found["diagnosed"] for found in turns.values()), turns


@pytest.mark.slow
def test_a_gap_of_many_deviations_is_laid_to_its_law_and_not_to_what_has_no_name():
    """Free-form forces and laws are weighed by the same filter: far from the optimum one of their own is worth more."""
    weak = ("duration_s=40", 'effects."thruster_dead@thruster_2".share=0.485')
    runs = vt.run("whole/bluerov2-multisine", seed=1, settings=weak)
    verdict = vt.diagnose(runs, nominal=NOMINAL, axes=("surge", "sway", "yaw"), effects=SOME).verdict
    assert (verdict.kind, verdict.effects, verdict.places) == ("effect", ("thruster_dead",), ("thruster_2",))
