"""Diagnosis against simulators of others, of which there is nothing but the runs that they have flown."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from simulators import boat, surge
from test_rigid_motion import multisine

import vtank as vt
from vtank.cli import main
from vtank.diagnose.hypothesis import candidates
from vtank.diagnose.whole.against import plant_of
from vtank.estimate.observed import observe
from vtank.experiment import fly_vehicle
from vtank.plant.parameters import vector
from vtank.plant.vehicle import load_vehicle
from vtank.record.run import TIME

SOME = ("linear_drag", "coulomb_friction", "thruster_dead", "thrust_deadband", "gyro_bias", "sensor_latency", "current")
ONE_AXIS = ("linear_drag", "coulomb_friction", "thrust_deadband", "thrust_asymmetry", "sonar_latency")


def written(folder: Path, runs: list[vt.Run]) -> Path:
    """A folder of CSV files, as any simulator may write them."""
    folder.mkdir()
    for run in runs:
        table = np.column_stack([run.time_s, *run.columns.values()])
        lines = [",".join((TIME, *run.columns)), *(",".join(f"{x:.6g}" for x in row) for row in table)]
        (folder / f"{run.name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def tugs(tmp_path_factory) -> tuple[Path, Path]:
    """A tug's simulator, and a tug that rubs besides."""
    folder = tmp_path_factory.mktemp("tugs")
    rubbing = replace(surge(60.0, 3, 2.0, np.random.default_rng(1)), name="rubbing")
    return written(folder / "simulator", [surge(40.0, k) for k in (1, 2)]), written(folder / "tug", [rubbing])


@pytest.fixture(scope="module")
def one_axis(tugs) -> vt.Diagnosis:
    """The tug diagnosed against its simulator."""
    return vt.diagnose(vt.load(tugs[1]), against=tugs[0], effects=ONE_AXIS)


@pytest.fixture(scope="module")
def whole() -> vt.WholeDiagnosis:
    """A boat whose port thruster makes two thirds of its force, against its simulator."""
    real = boat(60.0, 5, 0.65, np.random.default_rng(2))
    return vt.diagnose([real], nominal="kingfisher", against=[boat(60.0, k) for k in (5, 6)], effects=SOME,
                       axes=("surge", "sway", "yaw"))  # fmt: skip


def test_the_cause_on_one_axis_is_what_the_simulator_lacks(one_axis):
    assert (one_axis.verdict.kind, one_axis.verdict.effects) == ("effect", ("coulomb_friction",))
    friction = one_axis.verdict.fit.values["coulomb_friction.f"]
    assert friction * 20.0 == pytest.approx(2.0, rel=0.15)  # N, of 20 kg


def test_the_plant_of_one_axis_has_what_the_simulator_has(one_axis):
    found = {name: value for name, _, value in one_axis.against.parameters}
    assert found["linear_drag.c"] == pytest.approx(6.0 / 20.0, rel=0.1)
    assert found["thrust_lag.tau"] == pytest.approx(0.3, abs=0.05)
    assert one_axis.against.share < 0.02
    assert one_axis.against.of_gap < 0.1


@pytest.mark.slow
def test_the_place_on_a_vehicle_is_named_with_its_size(whole):
    assert (whole.verdict.kind, whole.verdict.effects, whole.verdict.places) == (
        "effect",
        ("thruster_dead",),
        ("port",),
    )
    size, sd = whole.selection.best.values(whole.selection.best.effects[0])["share"]
    assert size == pytest.approx(0.35, abs=max(3.0 * sd, 0.03))


@pytest.mark.slow
def test_every_outlet_tells_what_stands_for_the_simulator(one_axis, whole, tmp_path):
    for found, column in ((one_axis, "surge_m_s"), (whole, "yaw_rate_rad_s")):
        found.write(json=tmp_path / "d.json", report=tmp_path / "d.html")
        told = json.loads((tmp_path / "d.json").read_text(encoding="utf-8"))["against"]
        assert told["columns"][column]["error"] < 0.1 * told["columns"][column]["moves"]
        assert told["refused"] == []
        assert {"name", "before", "fitted"} == told["parameters"][0].keys()
        page = (tmp_path / "d.html").read_text(encoding="utf-8")
        assert told["parameters"][0]["name"] in page
        assert "stands for the simulator" in page and "stands for the simulator" in " ".join(str(found).split())


@pytest.mark.slow
def test_a_saved_model_corrects_the_simulator(whole, tmp_path):
    whole.save(tmp_path / "model.toml")
    rate = vt.predict(tmp_path / "model.toml", boat(60.0, 9, 0.65, np.random.default_rng(4)))["columns"]
    rate = rate["compass.yaw_rate_rad_s"]
    assert rate["diagnosed"] < 0.1 * rate["nominal"]
    missed = whole.against.document["columns"]["yaw_rate_rad_s"]["error"]  # by the plant, of the simulator itself
    assert rate["diagnosed"] < 1.2 * np.hypot(rate["noise"], missed)  # which on another flight is not the very same


@pytest.mark.slow
def test_the_simulator_itself_has_no_gap():
    real = boat(60.0, 8, 1.0, np.random.default_rng(3))
    verdict = vt.diagnose([real], nominal="kingfisher", against=[boat(60.0, k) for k in (5, 6)], effects=SOME,
                          axes=("surge", "sway", "yaw")).verdict  # fmt: skip
    assert verdict.kind in ("none", "parameters")


def test_a_simulator_that_nothing_is_like_is_refused(tugs, tmp_path, capsys):
    strange = surge(40.0, 1)
    backwards = replace(strange, columns=strange.columns | {"surge_m_s": strange.columns["surge_m_s"][::-1]})
    folder = written(tmp_path / "strange", [backwards])
    assert main(["diagnose", str(tugs[1]), "--against", str(folder)]) == 2
    said = capsys.readouterr().err
    assert f"the simulator's runs in {folder}" in said
    assert "up to 50 % is borne" in said


@pytest.mark.slow
def test_a_vehicle_s_simulator_that_nothing_is_like_is_refused():
    real, other = boat(60.0, 5, 1.0, np.random.default_rng(2)), boat(60.0, 5)
    backwards = {name: values if "command" in name else values[::-1] for name, values in other.columns.items()}
    with pytest.raises(vt.InputError, match="Nothing can be said of a gap|diverges"):
        vt.diagnose([real], nominal="kingfisher", against=[replace(other, columns=backwards)], axes=("surge", "yaw"))


@pytest.mark.parametrize(
    ("runs", "said"),
    [
        (Path("nowhere"), "nowhere"),
        ([], "no runs of a simulator"),
        ([vt.Run("a", 0.1 * np.arange(400.0), {"n_rev_s": np.ones(400), "surge_m_s": np.ones(400)})], "the same input"),
    ],
)
def test_runs_that_are_not_a_simulator_s_are_named(tugs, runs, said):
    with pytest.raises(vt.InputError, match=said):
        vt.diagnose(vt.load(tugs[1]), against=runs)


def test_one_simulator_is_enough(tugs):
    with pytest.raises(vt.InputError, match="expected none beside it"):
        vt.diagnose(vt.load(tugs[1]), nominal="paper-ii", against=tugs[0])


def test_a_simulator_that_tells_of_another_axis_is_named():
    real, other = boat(60.0, 5, 1.0, np.random.default_rng(2)), boat(60.0, 5)
    heave = {name: v for name, v in other.columns.items() if "command" in name} | {
        "heave_m_s": other.columns["sway_m_s"]
    }
    with pytest.raises(vt.InputError, match="no axis that the recordings tell of"):
        vt.diagnose([real], nominal="kingfisher", against=[replace(other, columns=heave)])


def test_an_effect_that_the_nominal_has_may_be_of_another_size():
    """But for what is a drag or lag of its own, which is refitted."""
    run = observe(surge(40.0, 1))
    has = {"linear_drag.c": 0.3, "thrust_lag.tau": 0.3, "coulomb_friction.f": 0.01}
    there = {e.name for e in candidates(vector(has), [run])}
    assert "coulomb_friction" in there and not {"linear_drag", "thrust_lag"} & there
    assert "linear_drag" in {e.name for e in candidates(vector({"thrust_lag.tau": 0.3}), [run])}


@pytest.mark.slow
@pytest.mark.parametrize("at_origin", [False, True])
def test_a_simulator_s_own_columns_are_read_where_they_are(at_origin: bool):
    """As an instrument of the recordings would read them, or as the hull's: whichever the equations bear out."""
    rov, inputs = load_vehicle("bluerov2"), multisine(load_vehicle("bluerov2"), 60.0, 3)
    recorded, flown = (fly_vehicle(rov, inputs, 60.0, seed) for seed in (1, 2))
    speeds, names = [f"dvl.{axis}_m_s" for axis in ("surge", "sway", "heave")], ("roll", "pitch", "yaw")
    rates = np.stack([flown.columns[f"imu.{name}_rate_rad_s"] for name in names], axis=1)
    (log,) = (sensor for sensor in rov.sensors if sensor.name == "dvl")
    lever = np.cross(rates, log.position_m) * at_origin
    bare = {name.split(".")[1]: flown.columns[name] - lever[:, i] for i, name in enumerate(speeds)}
    told = [*(f"ahrs.{name}_rad" for name in ("roll", "pitch", "heading")), "depth.depth_m",
            *(f"imu.{name}_rate_rad_s" for name in names)]  # fmt: skip
    bare |= {name.split(".")[1]: flown.columns[name] for name in told}
    driven = {name: values for name, values in flown.columns.items() if name.endswith("_command")}
    mine = vt.Run("run_1", flown.time_s, driven | bare)
    plant, like = plant_of([mine], [recorded], rov, None, "mine", lambda text: None)
    assert like.share < 0.2
    assert ("latency@dvl" in plant.fitted, "latency@simulated dvl" in plant.fitted) == (not at_origin, at_origin)
