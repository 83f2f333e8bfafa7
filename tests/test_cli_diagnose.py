"""`vtank diagnose` from a folder of recordings to what it prints and writes; inputs that do not fit are told."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from recorded import NOMINAL, TICK_S, record, sine

from vtank.cli import main
from vtank.diagnose import diagnosis, selection
from vtank.effects.catalogue import BY_NAME
from vtank.plant.parameters import vector
from vtank.record import Manifest, Run, write_dataset

KEYS = (
    "schema nominal verdict probabilities cause_set budget disturbance unexplained worse "
    "unnamed laws where shrink estimates absorbed tied next_experiment"
).split()


@pytest.fixture(scope="module")
def dragged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three runs of a minute with linear drag."""
    path, p = tmp_path_factory.mktemp("diagnose") / "data", vector({"linear_drag.c": 0.15}, NOMINAL)
    runs = []
    for k, drive in enumerate(((0.5, 12.0), (0.35, 10.0), (0.8, 14.0))):
        seen = record(f"run_{k}", sine(*drive, duration_s=60.0), p, 0.004, k)
        runs.append(Run(seen.name, seen.time_s, {"n_rev_s": seen.input, "range_m": seen.value}))
    write_dataset(path, runs, Manifest(seed=0))
    return path


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three effects instead of the whole catalogue, for speed."""
    chosen = [BY_NAME[name] for name in ("linear_drag", "ambient_current", "thrust_deadband")]
    monkeypatch.setattr(selection, "candidates", lambda nominal, runs, names: chosen)


def test_a_diagnosis_is_printed_and_written(
    dragged: Path, few: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = {"--json": tmp_path / "out" / "d.json", "--report": tmp_path / "d.html", "--model": tmp_path / "d.toml"}
    arguments = [str(part) for pair in files.items() for part in pair]
    assert main(["diagnose", str(dragged), *arguments, "--seed", "3"]) == 0
    printed = capsys.readouterr()
    first = (
        "Compared with paper-ii, the Phoenix of 1996, since no simulator was named. The gap is caused by linear drag."
    )
    assert " ".join(printed.out.split()).startswith(first)
    assert [h for h in ("Budget", "Where", "Which", "How far", "Ties", "Next") if f"\n{h} " in printed.out] == [
        "Budget", "Where", "Which", "How far", "Ties", "Next",
    ]  # fmt: skip
    assert "where the gap lies ...\n" in printed.err and "\x1b" not in printed.err

    document = json.loads(files["--json"].read_text())
    assert list(document)[: len(KEYS)] == KEYS
    assert document["schema"] == "vtank.diagnosis/2"
    assert document["verdict"]["kind"] == "effect" and document["verdict"]["effects"] == ["linear_drag"]
    assert document["verdict"]["channel"] == "hydrodynamics"
    assert set(document["where"]) == {"channel", "runs", "time_s", "frequency_rad_s", "region"}
    assert {"unit", "nominal", "refit", "diagnosed", "floor", "fraction_closed", "interval90"} <= set(
        document["shrink"]
    )
    assert document["cause_set"][0] == "linear_drag"
    told = {line["kind"]: line for line in document["budget"]}
    assert set(told["effect"]) == {"name", "kind", "share", "interval90"} and told["effect"]["name"] == "linear_drag"
    assert sum(line["share"] for line in document["budget"]) == pytest.approx(1.0)
    rest = document["unexplained"]
    assert rest["share"] == pytest.approx(told["repeatable"]["share"] + told["disturbance"]["share"])
    assert set(rest) == {"share", "interval90"} and rest["interval90"][0] <= rest["share"] <= rest["interval90"][1]
    assert set(document["disturbance"]) == {"sigma_m_s2", "memory_s", "plausible"}
    assert document["disturbance"]["plausible"] is True and document["worse"] == []
    estimate = document["estimates"]["linear_drag"]["c"]
    assert estimate["value"] == pytest.approx(0.15, rel=0.1)
    assert estimate["interval95"][0] < estimate["value"] < estimate["interval95"][1]
    assert files["--report"].read_text(encoding="utf-8").startswith("<!doctype html>")
    assert "linear_drag" in files["--model"].read_text()


def data_set(path: Path, columns: dict[str, np.ndarray], count: int = 200) -> Path:
    time_s = TICK_S * np.arange(count)
    write_dataset(
        path, [Run("run_1", time_s, {name: values[:count] for name, values in columns.items()})], Manifest(seed=0)
    )
    return path


WAVE = np.sin(0.1 * np.arange(200))


@pytest.mark.parametrize(
    ("columns", "count", "options", "message"),
    [
        (
            {"command": WAVE, "surge_m_s": WAVE},
            200,
            [],
            "its input is command, but the nominal simulator paper-ii is driven",
        ),
        ({"n_rev_s": WAVE, "range_m": 3.0 + WAVE}, 30, [], "30 measurements, expected at least 50"),
        ({"n_rev_s": 0.0 * WAVE, "range_m": 3.0 + WAVE}, 200, [], "n_rev_s is zero in all runs"),
        ({"n_rev_s": WAVE, "range_m": 3.0 + WAVE}, 200, ["--nominal", "paper-ix"], "paper-ix"),
        ({"n_rev_s": WAVE, "range_m": 3.0 + WAVE}, 200, ["--nominal", "no-such.toml"], "no-such.toml"),
        ({"n_rev_s": WAVE, "range_m": 3.0 + WAVE}, 200, ["--seed", "-1"], "--seed -1"),
    ],
)
def test_what_does_not_fit_is_told_in_one_line(
    columns: dict[str, np.ndarray], count: int, options: list[str], message: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    assert main(["diagnose", str(data_set(tmp_path / "data", columns, count)), *options]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("vtank: error: ") and captured.err.count("\n") == 1
    assert message in captured.err


def test_a_file_that_cannot_be_written_is_told_before_the_work(
    dragged: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    for option, path in (("--report", tmp_path), ("--json", tmp_path / "file" / "d.json")):
        assert main(["diagnose", str(dragged), option, str(path)]) == 2
        assert capsys.readouterr().err == f"vtank: error: {path}: cannot be written, expected the path of a file\n"


def test_a_foreign_input_is_pointed_to_its_option(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = data_set(tmp_path / "data", {"command": WAVE, "surge_m_s": WAVE})
    assert main(["diagnose", str(path)]) == 2
    assert "use --nominal none" in capsys.readouterr().err


def test_runs_with_different_inputs_do_not_go_together(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    time_s = TICK_S * np.arange(200)
    runs = [
        Run("a", time_s, {"n_rev_s": WAVE, "range_m": 3.0 + WAVE}),
        Run("b", time_s, {"command": WAVE, "range_m": 3.0 + WAVE}),
    ]
    write_dataset(tmp_path / "data", runs, Manifest(seed=0))
    assert main(["diagnose", str(tmp_path / "data")]) == 2
    assert "run b: its input is command, that of run a is n_rev_s" in capsys.readouterr().err


def test_recordings_that_tell_no_parameters_apart_end_in_one_line(
    dragged: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def singular(*arguments: object, **options: object) -> None:
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr(diagnosis, "select", singular)
    assert main(["diagnose", str(dragged), "--json", str(tmp_path / "d.json")]) == 2
    assert "do not tell the simulator's parameters apart (Singular matrix)" in capsys.readouterr().err
    assert not (tmp_path / "d.json").exists()
