"""Model files there and back, `vtank predict`, and the diagnosed effect switched on in the tank."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from recorded import NOISE_M, NOMINAL, record, recordings, sine

import vtank as vt
from vtank.cli import main
from vtank.diagnose.diagnosis import Diagnosis, diagnose
from vtank.diagnose.holdout import Model, model_of
from vtank.diagnose.model_file import _effects, model_text, predict_gaps, read_model
from vtank.errors import InputError
from vtank.estimate.observed import observe
from vtank.experiment import simulate_tank
from vtank.experiment.fly import plan_all
from vtank.plant.parameters import slot, vector
from vtank.plant.truth import load_truth
from vtank.record import Run, write_run, write_text

DRAG = {"linear_drag.c": 0.2}
OPEN_LOOP = ("open-loop-sine", "step-coast")
STILL = ("tachometer.governor_per_s=0", "tachometer.noise_rev_s=0", "duration_s=60")


@pytest.fixture(scope="module")
def diagnosis() -> Diagnosis:
    return diagnose(recordings(DRAG)[:3], NOMINAL, names=("linear_drag", "thrust_deadband"))


@pytest.fixture(scope="module")
def model(diagnosis: Diagnosis, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("predict") / "model.toml"
    write_text(path, model_text(diagnosis))
    return path


def unseen(folder: Path) -> Path:
    """A run that the model has never seen."""
    seen = record("unseen", sine(0.3, 10.0, 60.0), vector(DRAG, NOMINAL), NOISE_M, 77)
    path = folder / "unseen.csv"
    write_run(path, Run("unseen", seen.time_s, {"n_rev_s": seen.input, "range_m": seen.value}))
    return path


def test_a_model_file_holds_the_three_simulators(diagnosis: Diagnosis, model: Path) -> None:
    read = read_model(model)
    setting, verdict = diagnosis.selection.setting, diagnosis.verdict
    for found, meant in ((read.nominal.p, setting.nominal), (read.refit.p, model_of(diagnosis.selection.refit).p),
                         (read.diagnosed.p, model_of(verdict.fit).p)):  # fmt: skip
        same = np.isfinite(meant)
        same[slot("standoff")] = False  # each run's own
        np.testing.assert_allclose(found[same], meant[same], rtol=1e-10)
    assert verdict.effects == ("linear_drag",) and read.verdict["effects"] == ["linear_drag"]
    assert read.verdict["probability"] == pytest.approx(verdict.probability, abs=1e-4)
    assert read.noise.variance[0] == pytest.approx(setting.noise.variance[0], rel=1e-4)
    assert read.noise.sigma == pytest.approx(setting.noise.sigma, rel=1e-4)


OWN_UNITS = {  # input -> (largest input, what is in its unit, whether it is a force)
    "n_rev_s": (12.0, {"thrust_deadband.n0": 4.0}, 0.0),
    "command": (0.8, {"thrust_saturation.n_max": 0.5}, 0.0),
    "thrust_N": (40.0, {"force_offset": -6.0}, 1.0),
}


@pytest.mark.parametrize("input_name", OWN_UNITS)
def test_a_model_file_is_read_back_whatever_the_input(input_name: str, tmp_path: Path) -> None:
    top, effect, linear = OWN_UNITS[input_name]
    p = vector({**effect, "beta": 0.07 / top ** (2.0 - linear), "linear_input": linear}, NOMINAL)
    drives = ((0.5, 1.0), (0.8, 0.7))
    runs = [record(f"run_{k}", sine(w, a * top, 60.0), p, NOISE_M, k) for k, (w, a) in enumerate(drives)]
    offset = effect.get("force_offset", 0.0)  # which the reading has, and the hull does not feel
    runs = [replace(run, input_name=input_name, input=run.input + offset) for run in runs]
    nominal = vector({"beta": p[slot("beta")], "linear_input": linear}, NOMINAL)
    name = next(iter(effect))
    found = diagnose(runs, nominal, names=() if linear else (name.split(".")[0],))
    write_text(tmp_path / "model.toml", model_text(found))
    read = read_model(tmp_path / "model.toml")
    assert read.diagnosed.p[slot(name)] == pytest.approx(effect[name], rel=0.1)
    assert set(predict_gaps(read, runs[0])["rms"]) == {"nominal", "refit", "diagnosed"}


def test_a_phase_that_went_round_is_written_within_a_turn() -> None:
    p = vector({"seiche.amplitude": 0.01, "seiche.phase": 9.0}, NOMINAL)
    lines = _effects(Model(p), "n_rev_s", "")
    assert f"phase_rad = {9.0 - 2.0 * np.pi:.12g} # of the first run; every run has its own" in lines


def test_a_model_file_is_a_truth_preset(diagnosis: Diagnosis, model: Path) -> None:
    truth = load_truth(model)
    assert truth.effects["linear_drag.c"] == pytest.approx(diagnosis.verdict.fit.values["linear_drag.c"])
    np.testing.assert_array_equal(truth.vector(), read_model(model).diagnosed.p)


def test_the_effect_is_written_with_the_keys_of_a_scenario(model: Path) -> None:
    text = model.read_text()
    assert "\n[effects.linear_drag]\nc_per_s = " in text and "\n[refit]\nalpha_per_m = " in text
    assert text.isascii() and max(map(len, text.splitlines())) < 130


def test_predict_prints_gaps_of_a_run_never_seen(
    model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "gaps.json"
    assert main(["predict", str(model), str(unseen(tmp_path)), "--json", "-"]) == 0
    gaps = json.loads(capsys.readouterr().out)
    assert main(["predict", str(model), str(unseen(tmp_path)), "--json", str(out)]) == 0
    header, row, note = capsys.readouterr().out.splitlines()
    assert gaps == json.loads(out.read_text())
    assert re.split("  +", header) == ["error on unseen", "as it is", "refitted", "diagnosed", "noise"]
    assert row.startswith("position") and row.endswith(f"{1e3 * gaps['floor']:.3g} mm") and "measured" in note
    assert set(gaps) == {"unit", "rms", "floor"} and gaps["unit"] == "m"
    assert gaps["rms"]["diagnosed"] == pytest.approx(NOISE_M, rel=0.25)
    assert gaps["floor"] == pytest.approx(NOISE_M, rel=0.25)
    assert gaps["rms"]["diagnosed"] < 0.8 * gaps["rms"]["refit"] < gaps["rms"]["nominal"]


def test_a_whole_vehicles_model_predicts_from_the_shell(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A row for each instrument's channel, in words, with its unit; angles in degrees."""
    (tmp_path / "gap.toml").write_text(
        'schema = "vtank.whole/2"\nvehicle = "bluerov2"\naxes = ["surge", "sway", "yaw"]\n'
        '[noise]\nsigma = [1e-4, 1e-4, 0, 0, 0, 1e-4]\n[refit]\n[diagnosed]\n"lost@thruster_4" = 0.5\n'
    )
    weak = ("duration_s=15", "vehicle=bluerov2", 'effects."thruster_dead@thruster_4".share=0.5')
    vt.run("whole/zigzag", seed=1, settings=weak, out=tmp_path / "zigzag")
    command = ["predict", str(tmp_path / "gap.toml"), str(tmp_path / "zigzag" / "zigzag.csv")]
    assert main(command) == 0
    table = [re.split("  +", line) for line in capsys.readouterr().out.splitlines()]
    rows = {row[0]: row[1:] for row in table}
    assert rows["error on zigzag"] == ["as it is", "refitted", "diagnosed", "noise"]
    assert rows["rate of turn, imu"][0].endswith(" °/s") and rows["heading, ahrs"][0].endswith("°")
    assert rows["speed ahead, dvl"][0].endswith("m/s")
    assert main([*command, "--json", "-"]) == 0
    assert len(json.loads(capsys.readouterr().out)["columns"]) == len(rows) - 2


def test_what_cannot_be_predicted_is_told(model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    time = 0.1 * np.arange(300)
    other = unseen(tmp_path)
    assert main(["predict", str(other), str(other)]) == 2
    assert "not valid TOML" in capsys.readouterr().err
    run = Run("force", time, {"thrust_N": np.sin(time), "range_m": 3.0 + 0.0 * time})
    with pytest.raises(InputError, match="input thrust_N, but the model was found with n_rev_s"):
        predict_gaps(read_model(model), observe(run))
    short = Run("short", time[:2], {"n_rev_s": np.ones(2), "range_m": 3.0 * np.ones(2)})
    with pytest.raises(InputError, match="expected at least 10 measurements after"):
        predict_gaps(read_model(model), observe(short))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('schema = "vtank.model/1"', 'schema = "other"', "vtank.model/1"),
        ("c_per_s", "c_per_min", "c_per_min: unknown key; did you mean 'c_per_s'?"),
        ("[effects.linear_drag]", "[effects.linear_drug]", "effects.linear_drug: unknown key"),
        ("c_per_s = 0", "c_per_s = 90", "expected a number from 0 to 5"),
        ('input = "n_rev_s"', 'input = "rpm"', "expected one of n_rev_s, command, thrust_N"),
        ("range_m", "range_ft", "noise.range_ft: wrong unit: expected 'range_m' [m]"),
    ],
)
def test_a_broken_model_file_is_told(model: Path, tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "broken.toml"
    path.write_text(model.read_text().replace(old, new))
    with pytest.raises(InputError, match="broken.toml") as told:
        read_model(path)
    assert message in str(told.value)


def test_models_of_other_inputs_do_not_drive_the_tank(diagnosis: Diagnosis, tmp_path: Path) -> None:
    path = tmp_path / "boat.toml"
    text = model_text(diagnosis).replace('"n_rev_s"', '"command"').replace("beta_m_per_rev2", "beta_m_s2")
    text = text.replace("gamma_per_rev = 0", "gamma_per_s = 0\nlinear_share = 0")
    path.write_text(text)
    assert read_model(path).input_name == "command"
    with pytest.raises(InputError, match="driven by propeller speed"):
        load_truth(path)


def test_the_gap_of_the_tank_shrinks_when_the_diagnosed_effect_is_switched_on(tmp_path: Path) -> None:
    """Recorded in the tank with linear drag, open loop; the same propeller speeds again in the tank as diagnosed."""
    settings = (*STILL, "effects.linear_drag.c_per_s=0.2")
    real = simulate_tank(plan_all(OPEN_LOOP, settings, 3))
    names = ("linear_drag", "thrust_deadband")
    found = diagnose([observe(r.run) for r in real], load_truth("paper-ii").vector(), names=names)
    assert found.verdict.effects == ("linear_drag",)
    path = tmp_path / "model.toml"
    write_text(path, model_text(found))

    def gap(truth: str) -> float:
        again = simulate_tank(plan_all(OPEN_LOOP, STILL, 3, truth))
        errors = [a.true["position_m"] - r.true["position_m"] for a, r in zip(again, real, strict=True)]
        return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))

    assert gap(str(path)) < 0.1 * gap("paper-ii")


def test_a_truth_preset_is_no_model(tmp_path: Path) -> None:
    path = tmp_path / "truth.toml"
    path.write_text('name = "mine"\n')
    with pytest.raises(InputError, match='expected "vtank.model/1", a model written by vtank diagnose'):
        read_model(path)


def test_what_cannot_be_written_is_told_before_anything_is_printed(
    model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["predict", str(model), str(unseen(tmp_path)), "--json", str(model / "gaps.json")]) == 2
    told = capsys.readouterr()
    assert told.out == "" and "cannot be written" in told.err


def test_what_cannot_be_told_is_null(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A recording of mere noise has no expected error; NaN is no JSON."""
    from vtank.diagnose import model_file

    monkeypatch.setattr(model_file, "read_model", lambda path: None)
    monkeypatch.setattr(
        model_file, "predict_gaps", lambda *given: {"unit": "m", "rms": {"refit": 0.5}, "floor": np.nan}
    )
    assert main(["predict", "model.toml", str(unseen(tmp_path)), "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out, parse_constant=pytest.fail) == {
        "unit": "m",
        "rms": {"refit": 0.5},
        "floor": None,
    }


def test_a_recording_that_no_model_follows_is_told(
    model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Mere noise: the gaps are what simulations that have run away are held at, which is no prediction."""
    random, time = np.random.default_rng(0), 0.1 * np.arange(300)
    speeds, ranges = random.uniform(-180.0, 180.0, 300), random.uniform(0.0, 300.0, 300)
    write_run(tmp_path / "noise.csv", Run("noise", time, {"n_rev_s": speeds, "range_m": ranges}))
    assert main(["predict", str(model), str(tmp_path / "noise.csv")]) == 0
    assert capsys.readouterr().out.count("runs away") == 3
    assert main(["predict", str(model), str(tmp_path / "noise.csv"), "--json", "-"]) == 0
    told = capsys.readouterr()
    assert "noise.csv: runs away from it: nominal, refit, diagnosed; is it another vehicle" in told.err
    assert json.loads(told.out, parse_constant=pytest.fail)["rms"]["refit"] == 1e6


@pytest.mark.parametrize("effect", [{"clock_skew.s": 0.02}, {"seiche.amplitude": 0.02, "seiche.frequency": 0.6}])
def test_where_a_recorders_clock_begins_tells_nothing(effect: dict[str, float], model: Path) -> None:
    """Laws and effects in time count from a run's first row, be it 0, a minute to the hour or an epoch."""
    read, seen = read_model(model), record("unseen", sine(0.3, 10.0, 60.0), vector(effect, NOMINAL), NOISE_M, 77)
    read = replace(read, diagnosed=Model(vector(effect, NOMINAL)))
    columns = {"n_rev_s": seen.input, "range_m": seen.value}
    gaps = []
    for begin_s in (0.0, 1000.0, -1000.0, 1.7e9):
        seen_then = observe(Run("unseen", seen.time_s + begin_s, columns))
        gaps.append(predict_gaps(read, seen_then)["rms"]["diagnosed"])
    assert gaps[1:] == pytest.approx(3 * gaps[:1], rel=1e-4)
