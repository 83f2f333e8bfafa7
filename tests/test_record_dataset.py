"""Data sets: order, manifest, truth kept apart, and folders that appear whole or not at all."""

from __future__ import annotations

import hashlib
import json
import warnings
from pathlib import Path

import numpy as np
import pytest

from vtank.errors import InputError
from vtank.record import DataSetWarning, Manifest, Run, read_dataset, read_truth, write_dataset
from vtank.record.atomic import write_text
from vtank.record.folder import new_folder

MANIFEST = Manifest(scenarios={"sine": "duration_s = 1.1\n"}, seed=7)


def a_run(name: str, amplitude: float = 1.0) -> Run:
    time_s = np.arange(12) * 0.1
    return Run(name, time_s, {"n_rev_s": amplitude * np.sin(time_s), "range_m": 3.0 - 0.1 * time_s})


def written(folder: Path, *names: str) -> Path:
    write_dataset(folder, [a_run(name) for name in names or ("run_1", "run_2")], MANIFEST, {"alpha_per_m": -0.5})
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_written_data_set_comes_back(tmp_path: Path) -> None:
    data = read_dataset(written(tmp_path / "data"))
    assert [run.name for run in data] == ["run_1", "run_2"]
    assert len(data) == 2
    np.testing.assert_allclose(data.runs[0].columns["n_rev_s"], a_run("").columns["n_rev_s"], atol=0.5e-6)
    assert data.manifest is not None
    assert (data.manifest.scenarios, data.manifest.seed) == ({"sine": "duration_s = 1.1\n"}, 7)
    assert [entry.rows for entry in data.manifest.runs] == [12, 12]


def test_runs_come_in_natural_order(tmp_path: Path) -> None:
    names = ["run_2", "run_10", "run_1", "sine-0.5", "sine-0.2"]
    data = read_dataset(written(tmp_path / "data", *names))
    assert [run.name for run in data] == ["run_1", "run_2", "run_10", "sine-0.2", "sine-0.5"]


def test_the_same_work_gives_the_same_bytes(tmp_path: Path) -> None:
    first, second = contents(written(tmp_path / "a")), contents(written(tmp_path / "b"))
    assert first == second
    assert set(first) == {"run_1.csv", "run_2.csv", "manifest.json", "truth.json"}


def test_the_manifest_names_schema_versions_and_hashes(tmp_path: Path) -> None:
    folder = written(tmp_path / "data")
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["schema"] == "vtank.manifest/1"
    assert {"vtank", "python", "mujoco", "numpy", "numba"} <= set(manifest["versions"])
    for entry in manifest["runs"]:
        assert entry["sha256"] == hashlib.sha256((folder / entry["file"]).read_bytes()).hexdigest()


def test_the_truth_is_in_its_own_file_and_can_be_withheld(tmp_path: Path) -> None:
    folder = written(tmp_path / "data")
    for name, data in contents(folder).items():
        assert (b"alpha" in data) == (name == "truth.json")
    assert read_truth(folder) == read_truth(folder / "run_1.csv") == read_truth(folder / "truth.json")
    assert read_truth(folder) == {"schema": "vtank.truth/1", "alpha_per_m": -0.5}
    (folder / "truth.json").unlink()
    assert read_truth(folder) is None
    assert len(read_dataset(folder)) == 2


def test_reading_runs_never_opens_the_truth(tmp_path: Path) -> None:
    folder = written(tmp_path / "data")
    (folder / "truth.json").write_text("not even JSON")
    assert len(read_dataset(folder)) == 2


def test_numpy_numbers_in_a_truth_become_plain_ones(tmp_path: Path) -> None:
    truth = {"alpha": np.float64(-0.5), "per_run": np.arange(2.0)}
    write_dataset(tmp_path / "data", [a_run("a")], MANIFEST, truth)
    assert read_truth(tmp_path / "data") == {"schema": "vtank.truth/1", "alpha": -0.5, "per_run": [0.0, 1.0]}


@pytest.mark.filterwarnings("error")
def test_an_untouched_data_set_gives_no_warning(tmp_path: Path) -> None:
    read_dataset(written(tmp_path / "data"))


def test_changed_lost_and_added_runs_are_named(tmp_path: Path) -> None:
    folder = written(tmp_path / "data", "a", "b", "c")
    (folder / "a.csv").write_bytes((folder / "a.csv").read_bytes().replace(b",3\n", b",4\n"))
    (folder / "b.csv").rename(folder / "d.csv")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assert len(read_dataset(folder)) == 3
    messages = [str(item.message) for item in caught if item.category is DataSetWarning]
    assert len(messages) == 3
    for file, said in {"a.csv": "changed since", "d.csv": "added since", "b.csv": "not here"}.items():
        assert any(file in message and said in message for message in messages)


def test_a_thruster_s_bench_table_among_the_runs_is_none(tmp_path: Path) -> None:
    folder = written(tmp_path / "data", "a", "b")
    (folder / "thrust.csv").write_text("command, force_N\n-1,-40\n0,0\n1,50\n", encoding="utf-8")
    with pytest.warns(DataSetWarning, match="thrust.csv: a thruster's bench table, no run"):
        assert [run.name for run in read_dataset(folder)] == ["a", "b"]
    (folder / "thrust.csv").write_text("command,force_N,more\n0,0,0\n", encoding="utf-8")
    with pytest.raises(InputError, match="thrust.csv, line 1: no column time_s"):
        read_dataset(folder)


def test_one_file_is_a_data_set_of_one_run(tmp_path: Path) -> None:
    folder = written(tmp_path / "data")
    data = read_dataset(folder / "run_2.csv")
    assert ([run.name for run in data], data.manifest) == (["run_2"], None)


def test_a_folder_without_runs_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no runs here, expected \*\.csv"):
        read_dataset(tmp_path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "line 1: not JSON"),
        ("[]", "found schema None"),
        ('{"schema": "vtank.manifest/2"}', "found schema 'vtank.manifest/2', expected 'vtank.manifest/1'"),
        ('{"schema": "vtank.manifest/1"}', "no key 'scenarios'"),
        ('{"schema": "vtank.manifest/1", "scenarios": 3}', "not a manifest"),
    ],
)
def test_a_broken_manifest_is_refused(tmp_path: Path, text: str, message: str) -> None:
    folder = written(tmp_path / "data")
    (folder / "manifest.json").write_text(text)
    with pytest.raises(InputError, match=message):
        read_dataset(folder)


def test_a_data_set_is_replaced_as_a_whole(tmp_path: Path) -> None:
    folder = written(tmp_path / "data", "old_1", "old_2")
    write_dataset(folder, [a_run("new")], MANIFEST)
    assert set(contents(folder)) == {"new.csv", "manifest.json"}
    assert [path.name for path in tmp_path.iterdir()] == ["data"]


def test_an_empty_folder_is_filled(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    assert len(read_dataset(written(tmp_path / "data"))) == 2


def test_nothing_that_vtank_did_not_write_is_ever_deleted(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"holds notes\.txt, no part of a data set"):
        written(tmp_path)
    folder = written(tmp_path / "data")
    (folder / "notes.txt").write_text("mine")
    before = contents(folder)
    with pytest.raises(InputError, match=r"holds notes\.txt"):
        written(folder)
    assert contents(folder) == before


def test_a_failure_half_way_leaves_the_old_data_set(tmp_path: Path) -> None:
    folder = written(tmp_path / "data")
    before = contents(folder)
    bad = Run("bad", np.zeros(12), a_run("").columns)
    with pytest.raises(InputError, match="run bad"):
        write_dataset(folder, [a_run("a"), bad], MANIFEST)
    assert contents(folder) == before
    assert [path.name for path in tmp_path.iterdir()] == ["data"]


def test_an_interrupt_half_way_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt), new_folder(tmp_path / "deep" / "deeper" / "data") as folder:
        (folder / "half").write_text("...")
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="is a file, expected a folder"):
        written(tmp_path / "file")
    with pytest.raises(InputError, match="cannot be written"):
        written(tmp_path / "file" / "data")
    assert contents(tmp_path) == {"file": b""}


def test_two_runs_of_one_name_and_no_runs_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="different names, found a, a"):
        written(tmp_path / "data", "a", "a")
    with pytest.raises(InputError, match="found none"):
        write_dataset(tmp_path / "data", [], MANIFEST)
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_replaced_whole_and_a_device_is_left_in_place(tmp_path: Path) -> None:
    write_text(tmp_path / "a.json", "one")
    write_text(tmp_path / "a.json", "two")
    assert contents(tmp_path) == {"a.json": b"two"}
    write_text("/dev/null", "nothing")
    assert Path("/dev/null").is_char_device()


def test_foreign_recordings_need_no_manifest(recordings: Path) -> None:
    data = read_dataset(recordings / "kingfisher_2017")
    assert data.manifest is None
    assert [run.name for run in data] == [f"run_{k:02d}" for k in range(1, 15)]
    assert {run.input for run in data} == {"command"}
    drive = read_dataset(recordings / "emps_estimation")
    assert [(run.input, run.outputs) for run in drive] == [("thrust_N", ("position_m",))]
