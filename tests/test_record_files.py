"""What no reader can take ends in one line that names the file: pipes, nesting, endless numbers, names with a NUL."""

from __future__ import annotations

import os
import socket
import tracemalloc
import warnings
from pathlib import Path

import numpy as np
import pytest

from vtank.cli import main
from vtank.errors import InputError
from vtank.experiment.scenario import load_scenario
from vtank.plant.truth import load_truth
from vtank.plant.vehicle import load_vehicle
from vtank.record import read_dataset, read_run, read_truth
from vtank.record.documents import json_text
from vtank.resources import models_dir
from vtank.studies.campaign import load_campaign

EXCITATION = '[excitation]\nkind = "position_sine"\namplitude_m = 0.3\nfrequency_rad_s = 0.5\n'
DEEP, ENDLESS = "[" * 5000, "9" * 5000
NUL = '"a\\u0000b.toml"'
READERS = {"run.csv": read_run, "scenario.toml": load_scenario, "truth.toml": load_truth, "vehicle.toml": load_vehicle,
           "campaign.toml": load_campaign, "truth.json": read_truth}  # fmt: skip


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("kind", ["pipe", "device", "socket", "folder"])
def test_only_regular_files_are_read(name: str, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A pipe or a device has no end: the reader would wait, or fill the memory."""
    monkeypatch.chdir(tmp_path)  # the path of a socket is short
    path = Path(name)
    with socket.socket(socket.AF_UNIX) as plug:
        {"pipe": lambda: os.mkfifo(path), "device": lambda: path.symlink_to("/dev/zero"), "folder": path.mkdir,
         "socket": lambda: plug.bind(name)}[kind]()  # fmt: skip
        with pytest.raises(InputError, match=f"^{name}: is a .*expected a file"):
            READERS[name](path)


def test_a_pipe_in_place_of_a_manifest_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time_s,n_rev_s,range_m\n" + "".join(f"{k},1,3\n" for k in range(12)))
    os.mkfifo(tmp_path / "manifest.json")
    with pytest.raises(InputError, match="manifest.json: is a pipe"):
        read_dataset(tmp_path)


@pytest.mark.parametrize(
    "value", [DEEP, "{a=" * 5000, ENDLESS, "1" + "0" * 400, "1e300", "nan", NUL], ids=lambda v: v[:9]
)
@pytest.mark.parametrize("key", ["duration_s", "seed", "truth", "vehicle", "walls", "effects", "sonar.noise_m"])
def test_values_beyond_reason_end_in_one_line(
    key: str, value: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "trial.toml"
    path.write_text(f"{key} = {value}\n{EXCITATION}")
    assert main(["run", str(path), "--model", "surge", "--out", str(tmp_path / "out")]) == 2
    assert "trial.toml" in capsys.readouterr().err
    path.write_text(EXCITATION)
    assert main(["run", str(path), "--set", f"{key}={value}", "--model", "surge", "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert said.startswith("vtank: error: ") and said.count("\n") == 1 and len(said) < 1000


@pytest.mark.parametrize("text", ['{"schema": ' + DEEP, '{"schema": ' + ENDLESS + "}", "\xff", "[]", "{"])
def test_documents_beyond_reason_are_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "truth.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match="truth.json"):
        read_truth(tmp_path / "truth.json")


def test_what_is_not_finite_is_null_in_json() -> None:
    assert json_text({"a": [np.nan, np.float64(1.5)], "b": np.inf, "c": np.arange(2)}).split() == (
        '{ "a": [ null, 1.5 ], "b": null, "c": [ 0, 1 ] }'.split()
    )


# --- one number of a recording ---------------------------------------------------------------------------------------
WRONG = {  # column -> value, and what is expected
    "range_m": ("1e300", "1e8 m at most"),
    "n_rev_s": ("-1e300", "rev/s within 200"),
    "surge_m_s": ("1e9", "m/s within 200"),
    "position_m": ("-1e12", "metres within 1e8"),
    "depth_m": ("1e300", "a number within 1e12"),
    "time_s": ("1e7", "without a row, expected 86400 s at most"),
}


@pytest.mark.parametrize("column", WRONG)
@pytest.mark.parametrize("command", ["check-data", "identify", "diagnose"])
def test_one_number_beyond_reason_is_told_by_line_and_column(
    column: str, command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = ["time_s", "n_rev_s", "range_m", "surge_m_s", "position_m", "depth_m"]
    rows = [[f"{0.1 * k:.1f}", f"{np.sin(0.05 * k):.3f}", "3", "0.1", "0.1", "1"] for k in range(100)]
    for k in range(60, 100) if column == "time_s" else (60,):
        rows[k][names.index(column)] = str(float(WRONG[column][0]) + 0.1 * k)
    (tmp_path / "a.csv").write_text("\n".join(map(",".join, [names, *rows])) + "\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert main([command, str(tmp_path / "a.csv")]) == 2
    said = capsys.readouterr().err
    assert f"a.csv, line 62: column {column}: found" in said and WRONG[column][1] in said


def test_a_vehicle_beyond_reason_is_refused(tmp_path: Path) -> None:
    text = (models_dir() / "bluerov2.toml").read_text()
    line = next(line for line in text.splitlines() if line.startswith("diameter_m"))
    (tmp_path / "big.toml").write_text(text.replace(line, "diameter_m = 1e300"))
    with pytest.raises(
        InputError, match=r"big.toml:\d+: propeller.diameter_m: expected .* up to 1e\+12 \[m\], found 1e\+300"
    ):
        load_vehicle(tmp_path / "big.toml")


# --- paths in files --------------------------------------------------------------------------------------------------
def test_files_are_found_beside_the_file_that_names_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever vtank runs; what the command line names is found from there."""
    set_apart = tmp_path / "set"
    set_apart.mkdir()
    for name in ("bluerov2.toml", "bluerov2.xml", "basin.xml"):
        (set_apart / f"my-{name}").write_text(
            (models_dir() / name).read_text().replace("bluerov2.xml", "my-bluerov2.xml")
        )
    truth = (models_dir() / "truths" / "bluerov2.toml").read_text()
    (set_apart / "my-truth.toml").write_text(truth.replace('vehicle = "bluerov2"', 'vehicle = "my-bluerov2.toml"'))
    assert "my-bluerov2.toml" in (set_apart / "my-truth.toml").read_text()
    names = 'truth = "my-truth.toml"\nvehicle = "my-bluerov2.toml"\nwalls = "my-basin.xml"\nduration_s = 4.0\n'
    (set_apart / "dive.toml").write_text(names + EXCITATION)
    (set_apart / "many.toml").write_text(
        'model = "surge"\n[grid]\nscenario = "dive.toml"\nvehicle = ["my-bluerov2.toml"]\n'
    )
    monkeypatch.chdir(tmp_path)
    scenario = load_scenario("set/dive.toml")
    assert (scenario.truth, scenario.vehicle, scenario.walls) == tuple(
        str(set_apart / name) for name in ("my-truth.toml", "my-bluerov2.toml", "my-basin.xml")
    )
    assert load_truth(scenario.truth).name == load_truth("bluerov2").name
    assert main(["run", "set/dive.toml", "--model", "surge", "--out", "one"]) == 0
    assert main(["campaign", "set/many.toml", "--threads", "1", "--out", "many"]) == 0
    assert load_scenario("set/dive.toml", ["truth=set/my-truth.toml"]).truth == scenario.truth
    assert load_scenario("set/dive.toml", ["truth=physical"]).truth == "physical"
    with pytest.raises(InputError, match="my-truth.toml: cannot be read"):
        load_truth(load_scenario("set/dive.toml", ["truth=my-truth.toml"]).truth)


def test_a_range_has_a_reasonable_number_of_values(tmp_path: Path) -> None:
    for grid, words in {
        "sonar.noise_m = { from = 0.0, to = 0.1, count = 1000000000 }": "10,000,000 values at most",
        "seed = { from = 0, to = 1e300, count = 5 }": "whole numbers",
        "sonar.noise_m = [0.0, 0.1]\n[draw]\n": "10,000,000 at most",
    }.items():
        head = "repeats = 100000000000000000\n" if "[draw]" in grid else ""
        (tmp_path / "many.toml").write_text(f'{head}[grid]\nscenario = "paper-ds1"\n{grid}\n')
        with pytest.raises(InputError, match=words):
            load_campaign(tmp_path / "many.toml")


def test_a_recording_is_read_in_little_more_than_its_numbers_take(tmp_path: Path) -> None:
    rows, columns = 4000, 20
    table = np.column_stack([np.arange(rows) * 0.02, np.random.default_rng(2).uniform(-1.0, 1.0, (rows, columns))])
    names = ["time_s", *(f"thruster_{k}_command" for k in range(1, columns + 1))]
    path = tmp_path / "run.csv"
    np.savetxt(path, table, "%.6f", ",", header=",".join(names), comments="")
    tracemalloc.start()
    run = read_run(path)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    np.testing.assert_allclose(run.columns["thruster_7_command"], table[:, 7], atol=1e-6)
    assert most < 4.0 * path.stat().st_size + 2.0 * table.nbytes
