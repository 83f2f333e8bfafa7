"""Recordings that stop for a while: what happened meanwhile is not integrated through, and the user is told."""

from __future__ import annotations

import json
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from recorded import NOISE, NOMINAL, TICK_S, find, record, sine

from vtank.cli import main
from vtank.diagnose import model_file
from vtank.diagnose.given import telling
from vtank.diagnose.holdout import Model
from vtank.diagnose.model_file import ModelFile
from vtank.diagnose.shrink import parts_of
from vtank.errors import InputError
from vtank.estimate.observed import observe, stretches
from vtank.plant.parameters import slot
from vtank.present.identification import NAMES
from vtank.record import Run, write_run
from vtank.record.manifest import DataSetWarning

PAUSE_S = 1e7
OVERNIGHT_S = 5e4  # in a file; a pause of more than a day makes two recordings, which a reader refuses


def paused(pause_s: float, half_s: float = 30.0) -> Run:
    """A run of twice half_s whose recorder slept in between; the vehicle came back to where it had been."""
    parts = [record("run", sine(w, 12.0, half_s), NOMINAL, 0.004, k) for k, w in enumerate((0.5, 0.8))]
    time = np.concatenate([parts[0].time_s, parts[0].time_s[-1] + pause_s + parts[1].time_s])
    n, seen = (np.concatenate([getattr(part, name) for part in parts]) for name in ("input", "value"))
    return Run("run", time, {"n_rev_s": n, "range_m": seen})


def test_a_whole_vehicle_s_recording_is_cut_too() -> None:
    """Steps through the pause would be as many as it has seconds times thirty, and the vehicle's state a guess."""
    time = np.append(np.arange(0.0, 6.0, 0.1), 4000.0 + np.arange(0.0, 6.0, 0.1))
    turn = np.sin(time)
    run = Run(
        "run", time, {"bow_command": 0.3 * turn, "gyro.yaw_rate_rad_s": 0.1 * turn, "battery_V": 12.0 + 0.0 * time}
    )
    with pytest.warns(DataSetWarning, match="nothing was recorded for 3994 s; taken as stretches"):
        kept, _ = telling([run])
    assert [part.duration_s for part in kept] == pytest.approx([5.9, 5.9])


def nominal_alone() -> ModelFile:
    return ModelFile("n_rev_s", *[Model(NOMINAL)] * 3, NOISE, {})


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("paused") / "run.csv"
    write_run(path, paused(OVERNIGHT_S))
    return path


def test_a_pause_makes_two_stretches_with_clocks_of_their_own() -> None:
    with pytest.warns(DataSetWarning, match="run run: nothing was recorded for 3600 s.* 0-29.9s, 3629.9-3659.8s$"):
        first, second = stretches([paused(3600.0)])
    assert (first.name, second.name) == ("run_0-29.9s", "run_3629.9-3659.8s")
    assert second.time_s[0] == 0.0 and second.time_s.size == 300
    np.testing.assert_array_equal(second.columns["n_rev_s"], paused(3600.0).columns["n_rev_s"][300:])


def test_short_stretches_are_left_out() -> None:
    run = paused(3600.0)
    cut = Run("run", run.time_s[:340], {name: values[:340] for name, values in run.columns.items()})
    with pytest.warns(DataSetWarning, match="1 short ones left out"):
        assert [part.time_s.size for part in stretches([cut])] == [300]


@pytest.mark.parametrize(("step_s", "pause_s"), [(0.1, 9.0), (1.0, 60.0)])
def test_what_is_no_pause_stays_one_run(step_s: float, pause_s: float) -> None:
    time = step_s * np.arange(100.0)
    time[50:] += pause_s
    run = Run("run", time, {"n_rev_s": np.ones(100), "range_m": np.ones(100)})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert stretches([run]) == (run,)


def test_predict_takes_the_stretches(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(model_file, "read_model", lambda path: nominal_alone())
    assert main(["predict", "model.toml", str(file), "--json", "-"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["rms"]["nominal"] < 0.008
    assert "taken as stretches" in captured.err


def test_identify_takes_the_stretches(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "found.json"
    assert main(["identify", str(file), "--model", "II", "--method", "ml", "--json", str(out)]) == 0
    joint = json.loads(out.read_text())["models"]["II"]["likelihood"]
    assert joint["parameters"][NAMES["alpha"]]["value"] == pytest.approx(NOMINAL[slot("alpha")], rel=0.1)
    assert "taken as stretches" in capsys.readouterr().err


def test_diagnose_takes_the_stretches() -> None:
    with pytest.warns(DataSetWarning):
        runs = [observe(run) for run in stretches([paused(PAUSE_S)])]
    assert find(runs).verdict.kind == "none"


def test_blocks_in_which_nothing_was_measured_are_passed_over() -> None:
    whole = record("run", sine(0.5, 12.0, 40.0), NOMINAL, 0.004, 0)
    seen = (whole.time_s < 5.0) | (whole.time_s > 25.0)
    run = replace(whole, time_s=whole.time_s[seen], value=whole.value[seen], kind=whole.kind[seen])
    found = parts_of(find([run]).selection.setting).setting
    assert [part.time_s.size > 0 for part in found.runs] == [True, True, True]
    assert found.noise == NOISE and len(found.weight) == 3


@pytest.mark.parametrize("missing", ["time_s", "input"])
def test_a_run_without_samples_never_reaches_a_kernel(missing: str) -> None:
    run = record("run", sine(0.5, 12.0, TICK_S), NOMINAL, 0.004, 0)
    with pytest.raises(InputError, match="run 'run': no (measurement|value of n_rev_s)"):
        replace(run, **{missing: np.empty(0)})


@pytest.mark.parametrize("begin_s", [0.0, 1000.0, -1000.0, 1.7e9])
def test_a_run_has_a_clock_of_its_own_that_begins_with_it(begin_s: float) -> None:
    """Of one axis or a whole vehicle alike: what estimates and diagnoses sees no other."""
    time_s = 0.5 * np.arange(200)
    run = Run("run", begin_s + time_s, {"thruster_1_command": np.ones(200), "depth.depth_m": np.sin(time_s)})
    (own,) = stretches([run])
    np.testing.assert_allclose(own.time_s, time_s, atol=1e-6)
    assert (own is run) == (begin_s == 0.0) and own.columns.keys() == run.columns.keys()
