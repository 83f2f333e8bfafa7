"""`vtank identify` from data set to tables, on simulated and on real recordings."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from synthetic import observed, sine

import vtank.cli as cli
from vtank.estimate.comparison import coherence_peak, compare
from vtank.estimate.maximum_likelihood import identify
from vtank.estimate.observed import POSITION, SPEED, observe
from vtank.plant.lumped import Lumped
from vtank.plant.parameters import vector
from vtank.present.identification import parameters, sheets
from vtank.present.identification_json import identification
from vtank.record import Manifest, Run, read_dataset, write_dataset

TRUTH = Lumped(-2.5, 5e-4, 0.0, 0.7)
P = vector({"alpha": -2.5, "beta": 5e-4, "thrust_lag.tau": 0.7})


def as_run(name, input_name="n_rev_s", p=P, n=None, channel="range_m", seed=0, duration_s=40.0):
    kind = {"range_m": 0, "position_m": 1, "surge_m_s": 2}[channel]
    o = observed(p, n or sine(15.0, 0.5), {kind: 0.1}, seed, input_name, duration_s=duration_s)
    return Run.from_channels(name, {input_name: (o.input_time_s, o.input), channel: (o.time_s, o.value)})


@pytest.fixture(scope="module")
def runs():
    return [as_run(f"run_{i}", n=sine(15.0, w), seed=i) for i, w in enumerate((0.5, 0.8))]


@pytest.fixture(scope="module")
def data(runs, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("identify") / "data"
    known = {"parameters": {"alpha": -2.5, "beta": 5e-4, "thrust_lag.tau": 0.7, "thrust_loss.gamma": 0.0}}
    write_dataset(folder, runs, Manifest(seed=1), {"runs": [known]})
    return folder


@pytest.fixture(scope="module")
def found(runs):
    return compare(runs, "II")


# --- what is compared ------------------------------------------------------------------------------------------------


def test_every_method_takes_every_run(found):
    assert found.single.keys() == found.linear.keys() == found.on_speed.keys() == {"run_0", "run_1"}
    assert {method: set(by_run) for method, by_run in found.paper.items()} == {
        method: {"run_0", "run_1"} for method in ("kalman", "two_stage", "least_squares")
    }
    for run in found.single.values():
        assert abs(run.values["thrust_lag.tau"] - 0.7) < 4.5 * run.sd["thrust_lag.tau"]
        assert run.sd["thrust_lag.tau"] > found.joint.sd["thrust_lag.tau"]


def test_residuals_of_the_right_model_are_the_sonars_noise(found):
    for r in found.residuals:
        assert r.innovation_rms == pytest.approx(0.006, rel=0.15) and r.free_run.rms == pytest.approx(0.006, rel=0.15)
        assert r.whiteness_p > 1e-4 and r.coherence < 0.98


def test_residuals_of_the_wrong_model_go_with_the_speed():
    runs = [as_run(f"run_{w}", n=sine(15.0, w), duration_s=160.0) for w in (0.5, 0.8)]
    wrong = compare(runs, "I", (), process_noise=False)
    assert all(r.free_run.rms > 0.008 and r.whiteness_p < 1e-6 for r in wrong.residuals)
    for r, w in zip(wrong.residuals, (0.5, 0.8), strict=True):
        assert r.coherence > 0.9 and r.coherence_rad_s == pytest.approx(w, abs=0.3)


def test_validation_is_best_at_home(found):
    own, cross = found.validation[:2].diagonal(), found.validation[[0, 1], [1, 0]]
    assert np.all(own <= cross + 1e-9) and np.all(found.validation[-1] < 1.1 * own) and np.all(own > 0.004)


def test_coherence_is_looked_for_where_there_is_motion():
    t = 0.1 * np.arange(2000)
    rng = np.random.default_rng(0)
    tremble = 1e-4 * rng.standard_normal(t.size)
    speed, residual = np.sin(0.6 * t) + tremble, 0.01 * rng.standard_normal(t.size) + 10 * tremble
    assert coherence_peak(speed, residual, 0.1)[1] < 1.5
    peak, where = coherence_peak(speed, residual + 0.05 * np.sin(0.6 * t + 1.0), 0.1)
    assert peak > 0.95 and where == pytest.approx(0.6, abs=0.15)


def test_what_a_method_cannot_do_is_said(runs):
    short = [as_run("short", duration_s=4.0)]
    found = compare(short, "III")
    reasons = {by_run["short"] for by_run in found.paper.values()}
    assert all(isinstance(reason, str) and "model III needs at least" in reason for reason in reasons)
    notes = next(sheet.notes for sheet in sheets(found) if sheet.name == "model_III_methods")
    assert any("model III needs at least" in note for note in notes)
    content = identification("short", [found])
    assert "model III needs" in content["models"]["III"]["runs"]["short"]["kalman"]["skipped"]


# --- tables ----------------------------------------------------------------------------------------------------------


def test_the_table_of_parameters_in_both_units_beside_the_truth(found):
    sheet = parameters(found, {"alpha": -2.5, "beta": 5e-4, "thrust_lag.tau": 0.7})
    assert sheet.header == (
        "parameter",
        "value",
        "sd",
        "95 % interval",
        "unit",
        "value",
        "sd",
        "unit",
        "truth",
        "error/sd",
    )
    alpha, beta, tau = sheet.rows
    assert (alpha[4], alpha[7], beta[4], beta[7], tau[4]) == ("1/m", "1/ft", "m/rev2", "ft/rev2", "s")
    assert float(alpha[5]) == pytest.approx(0.3048 * float(alpha[1]), rel=1e-3)
    assert float(beta[5]) == pytest.approx(float(beta[1]) / 0.3048, rel=1e-3)
    assert abs(float(tau[9])) < 4.5 and tau[8] == "0.7"
    low, high = map(float, tau[3].split(" to "))
    assert low < float(tau[1]) < high
    assert any(note.startswith("Correlation: alpha-beta") for note in sheet.notes)
    assert any("on range" in note for note in sheet.notes)


@pytest.mark.parametrize(("input_name", "unit"), [("command", "m/s2"), ("thrust_N", "1/kg")])
def test_units_follow_the_input(input_name, unit):
    gain, size = (0.5, 0.8) if input_name == "command" else (1 / 120.0, 20.0)
    p = vector({"alpha": -0.7, "beta": gain, "linear_input": float(input_name == "thrust_N")})
    run = as_run("boat", input_name, p, sine(size, 0.4), "surge_m_s")
    found = compare([run], "I")
    sheet = parameters(found)
    assert sheet.rows[1][4] == unit and "ft" not in " ".join(sheet.header)
    mass = [note for note in sheet.notes if "Moving mass" in note]
    content = identification("boat", [found])["models"]["I"]["likelihood"]
    if input_name == "thrust_N":
        assert float(mass[0].split()[3]) == pytest.approx(120.0, rel=0.05)
        assert content["moving_mass_kg"]["value"] == pytest.approx(120.0, rel=0.05)
    else:
        assert not mass and "moving_mass_kg" not in content


# --- the command -----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_command_prints_and_writes_everything(data, tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["identify", str(data), "--model", "II", "--truth", str(data / "truth.json"), "--out", str(out)]
    assert cli.main([*arguments, "--json", str(tmp_path / "all.json")]) == 0
    page = capsys.readouterr().out
    assert "Model II: maximum likelihood, 2 runs" in page and "--verbose" in page and page.count("\n") < 25
    assert cli.main([*arguments, "--verbose"]) == 0
    shown = capsys.readouterr().out
    for words in (
        "Model II: maximum likelihood, 2 runs",
        "two-stage",
        "least squares",
        "Linear model (23)",
        "validation",
    ):
        assert words in shown
    content = json.loads((tmp_path / "all.json").read_text())
    tau = content["models"]["II"]["likelihood"]["parameters"]["tau"]
    assert tau["interval95"][0] < tau["value"] < tau["interval95"][1] and content["truth"]["tau"] == 0.7
    assert {path.name for path in out.iterdir()} >= {"identification.md", "run_0.png", "model_II_methods.csv"}
    assert "![run_0" in (out / "identification.md").read_text()
    assert cli.main(arguments) == 0  # an earlier one of its own is replaced
    (out / "mine.txt").write_text("keep")
    assert cli.main(arguments) == 2
    assert "holds mine.txt" in capsys.readouterr().err and (out / "mine.txt").exists()


@pytest.mark.parametrize(
    ("method", "there", "absent"), [("ml", "maximum likelihood", "Kalman"), ("paper", "Kalman", "validation")]
)
def test_one_method_alone(data, capsys, method, there, absent):
    assert cli.main(["identify", str(data), "--model", "I", "--method", method]) == 0
    shown = capsys.readouterr().out
    assert there in shown and absent not in shown


def test_a_thrust_input_skips_model_iii(tmp_path, capsys):
    p = vector({"alpha": -0.7, "beta": 1 / 120.0, "linear_input": 1.0})
    runs = [as_run("drive", "thrust_N", p, sine(20.0, 0.4), "position_m")]
    write_dataset(tmp_path / "drive", runs, Manifest())
    assert cli.main(["identify", str(tmp_path / "drive"), "--method", "ml"]) == 0
    shown = capsys.readouterr().out
    assert "Moving mass 1/beta: 1" in shown and "Model III skipped: Model III needs a propeller speed" in shown
    assert cli.main(["identify", str(tmp_path / "drive"), "--model", "III"]) == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], "nowhere"),
        ([], "expected a data set, or --monte-carlo N"),
        (["--monte-carlo", "1"], "--monte-carlo 1: expected a whole number of at least 2"),
        (["DATA", "--truth", "no-such"], "no truth preset named 'no-such'"),
        (["DATA", "--truth", "manifest.json"], "manifest.json"),
        (["DATA", "--out", "file.txt"], "is a file, expected a folder"),
    ],
)
def test_bad_arguments_give_one_message(data, tmp_path, capsys, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file.txt").write_text("")
    assert cli.main(["identify", *[str(data) if a == "DATA" else a for a in arguments], "--model", "I"]) == 2
    error = capsys.readouterr().err
    assert message in error and "Traceback" not in error


# --- real recordings -------------------------------------------------------------------------------------------------


def test_catamaran_on_a_lake(recordings):
    """Quadratic drag with c|c| leaves about 0.18 m/s: the thrusters' dead-band and saturation are missing."""
    runs = [observe(run) for run in read_dataset(recordings / "kingfisher_2017")]
    simulated = identify(runs, "I", process_noise=False)
    assert simulated.converged and 0.165 < simulated.rms(SPEED) < 0.18
    lagged = identify(runs, "II", process_noise=False)
    assert 0.155 < lagged.rms(SPEED) < simulated.rms(SPEED)  # a lag imitates the saturation


def test_drive_with_dry_friction(recordings):
    """Moving mass near 95 kg though the model knows no dry friction; free simulation cannot do it."""
    runs = [observe(run) for run in read_dataset(recordings / "emps_estimation")]
    estimate = identify(runs, "I")
    assert 1 / estimate.values["beta"] == pytest.approx(95.1, rel=0.1)
    assert estimate.problem.noise.sigma > 0.0 and estimate.rms(POSITION) < 1e-4


def test_real_recordings_go_through_the_command(recordings, capsys):
    assert cli.main(["identify", str(recordings / "emps_estimation"), "--model", "I", "--verbose"]) == 0
    shown = capsys.readouterr().out
    assert "Moving mass 1/beta:" in shown and "1/kg" in shown and "least squares" in shown
