"""`vtank run`: data sets from scenarios, the same bytes from the same seed, nothing left behind after an error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vtank.cli import main
from vtank.record import read_dataset, read_truth

QUICK = ["--set", "duration_s=4"]


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_the_same_seed_gives_the_same_bytes_on_one_and_two_threads(tmp_path: Path) -> None:
    names = ["paper-ds1", "paper-ds3", "step-coast"]
    extra = ["--set", "turbulence.acceleration_m_s2=0.01", "--set", "sonar.dropout=0.1"]
    for folder, more in {"one": ["--threads", "1"], "two": ["--threads", "2"], "other": ["--seed", "7"]}.items():
        assert main(["run", *names, "--out", str(tmp_path / folder), *QUICK, *extra, *more]) == 0
    assert files(tmp_path / "one") == files(tmp_path / "two")
    changed = {name for name, data in files(tmp_path / "other").items() if data != files(tmp_path / "one")[name]}
    assert changed == {"manifest.json", "truth.json", *(f"{name}.csv" for name in names)}


@pytest.mark.parametrize("model", ["tank", "surge"])
def test_a_data_set_holds_runs_manifest_and_truth(
    tmp_path: Path, model: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "set"
    arguments = ["--model", model, "--truth", "physical", "--set", "effects.linear_drag.c_per_s=0.1"]
    assert main(["run", "paper-ds2", "paper-ds2", "--out", str(out), *QUICK, *arguments]) == 0
    data, truth = read_dataset(out), read_truth(out)
    assert [run.name for run in data] == ["paper-ds2-1", "paper-ds2-2"]
    assert data.manifest is not None and 'kind = "position_sine"' in data.manifest.scenarios["paper-ds2-1"]
    told = (out / "manifest.json").read_text()
    assert not [word for word in ("linear_drag", "physical", "1996", "noise", "turbulence", "truth") if word in told]
    assert all(set(run.columns) == {"n_rev_s", "range_m"} and run.time_s.size == 41 for run in data)
    assert (data.runs[0].columns["range_m"] != data.runs[1].columns["range_m"]).any()
    assert truth is not None and truth["model"] == model
    assert [run["truth"] for run in truth["runs"]] == ["physical", "physical"]
    assert truth["runs"][0]["effects"]["linear_drag.c"] == 0.1 and truth["runs"][0]["seed"] == 1996
    flown = {scenario["name"]: scenario["text"] for scenario in truth["scenarios"]}
    assert "--set effects.linear_drag.c_per_s=0.1" in flown["paper-ds2-1"] and "[sonar]" in flown["paper-ds2-2"]
    assert len(truth["runs"][0]["true"]["position_m"]) == 41
    said = capsys.readouterr()
    assert "paper-ds2-1: 4 s" in said.out and "100/100" in said.err


def test_drop_outs_are_empty_cells(tmp_path: Path) -> None:
    arguments = [
        "--out",
        str(tmp_path / "set"),
        "--model",
        "surge",
        "--set",
        "duration_s=20",
        "--set",
        "sonar.rate_hz=5",
    ]
    assert main(["run", "paper-ds1", *arguments]) == 0
    (run,) = read_dataset(tmp_path / "set")
    assert np.isnan(run.columns["range_m"]).mean() == pytest.approx(0.5, abs=0.01)
    assert run.samples("n_rev_s")[0].size == 201


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nosuch"], "no scenario named 'nosuch'"),
        (["paper-ds1", "--set", "sonar.noise_ft=1"], "'noise_m' [m]"),
        (["paper-ds1", "--set", "excitation.amplitude_m=2"], "hits the wall astern"),
        (["open-loop-sine", "--set", "excitation.offset_rev_s=18", "--model", "surge"], "hits the wall ahead"),
        (["paper-ds1", "--truth", "nosuch"], "no truth preset named 'nosuch'"),
        (["paper-ds1", "--threads", "0"], "--threads 0"),
        (["paper-ds1", "--seed", "-1"], "--seed -1"),
        (["paper-ds1", "--set", "duration_s=0.3", "--model", "surge"], "samples"),
    ],
)
def test_errors_exit_with_2_one_line_and_nothing_left(
    tmp_path: Path, arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", *arguments, "--out", str(tmp_path / "deep" / "set")]) == 2
    message = capsys.readouterr().err.splitlines()[-1]
    assert words in message and "Traceback" not in message
    assert not any(tmp_path.iterdir())


def test_a_folder_with_something_else_in_it_is_refused_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    assert main(["run", "paper-ds1", "--out", str(tmp_path)]) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]
