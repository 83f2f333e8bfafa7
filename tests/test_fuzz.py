"""Readers of everything that comes from outside, against what is spoilt: each case is read, or refused in one message.

`make fuzz` tries ten times as many cases. The draws are the same every time.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fuzz import SPOILING, Files, files_of, put, reads_or_refuses, spoil
from hypothesis import HealthCheck, given, settings

from vtank.diagnose import read_model
from vtank.estimate import observe
from vtank.estimate.observed import stretches
from vtank.experiment import load_scenario, plan_run
from vtank.experiment.whole_scenario import load_whole_scenario
from vtank.library import load
from vtank.plant import load_truth, load_vehicle
from vtank.present.identified import known_truth
from vtank.record import read_dataset, read_run
from vtank.studies.blind.answer import check_data
from vtank.studies.blind.seal import read_index
from vtank.studies.blind.verify import open_all
from vtank.studies.campaign import Campaign, load_campaign
from vtank.tank.whole import load_whole
from vtank.tank.world import load_world

MORE = int(os.environ.get("VTANK_FUZZ", "1"))  # times the cases


def observed(folder: Path) -> None:
    """A run as far as an estimator takes it."""
    for run in stretches(load(folder / "run_1.csv")):
        seen = observe(run)
        assert np.isfinite(seen.value).all() and np.isfinite(seen.input).all()


def commands(folder: Path) -> None:
    scenario = load_whole_scenario(folder / "bluerov2-multisine.toml")
    if scenario.duration_s <= 600.0:
        assert all(np.isfinite(values).all() for values in scenario.commands().values())


def planned(folder: Path) -> None:
    scenario = load_scenario(folder / "dive.toml")
    if scenario.samples < 1e5:
        assert np.isfinite(plan_run(scenario).truth.vector()[:2]).all()


def campaign(folder: Path) -> Campaign:
    found = load_campaign(folder / "many.toml")
    found.choice(0)
    return found


def truths(folder: Path) -> None:
    for name in ("paper-ii.toml", "bluerov2.toml"):
        assert not np.isnan(load_truth(folder / name).vector()).any()


def predictor(folder: Path) -> None:
    models = read_model(folder / "model.toml")
    for one in (models.nominal, models.refit, models.diagnosed):
        assert not np.isnan(one.p).any()


def cases(folder: Path) -> None:
    index = read_index(folder / "cases")
    for entry in index.entries:
        check_data(folder / "cases", entry)


# Kind -> how it is read, and cases of a test
READERS: dict[str, tuple[Callable[[Path], object], int]] = {
    "run": (observed, 400),
    "whole run": (lambda folder: read_run(folder / "run.csv"), 150),
    "data set": (read_dataset, 200),
    "truth.json": (lambda folder: known_truth(folder / "truth.json"), 80),
    "truth": (truths, 150),
    "scenario": (planned, 250),
    "whole scenario": (commands, 120),
    "campaign": (campaign, 150),
    "model": (predictor, 150),
    "vehicle": (lambda folder: load_vehicle(folder / "bluerov2.toml"), 150),
    "trials": (lambda folder: open_all(folder / "cases", folder / "truth", folder / "answers.json"), 100),
    "cases": (cases, 50),
    "MJCF": (lambda folder: load_world(load_vehicle(folder / "bluerov2.toml"), folder / "basin.xml"), 100),
    "fins": (lambda folder: load_whole(load_vehicle(folder / "remus100.toml")), 60),
}


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Files]:
    """The sound files of a kind, made once."""
    kept: dict[str, Files] = {}

    def files(kind: str) -> Files:
        if kind not in kept:
            kept[kind] = files_of("trials" if kind == "cases" else kind, tmp_path_factory.mktemp("sound"))
            if kind == "MJCF":
                kept[kind] |= {"bluerov2.toml": files_of("vehicle", Path())["bluerov2.toml"]}
        return kept[kind]

    return files


def examples(count: int) -> Any:
    return settings(
        max_examples=count * MORE, derandomize=True, database=None, deadline=None,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("kind", READERS)
def test_a_spoilt_file_is_read_or_refused_in_one_message(
    kind: str, sound: Callable[[str], Files], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read, count = READERS[kind]
    files, folder = sound(kind), tmp_path / "files"
    monkeypatch.chdir(tmp_path)
    put(folder, files)
    read(folder)  # sound files are read

    @examples(count)
    @given(SPOILING)
    def case(orders: list[tuple[int, str, int, str]]) -> None:
        put(folder, spoil(files, orders))
        reads_or_refuses(read, folder)

    case()
    assert not list(tmp_path.glob("MUJOCO_LOG*"))
