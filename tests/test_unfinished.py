"""A diagnosis of a whole vehicle that was interrupted goes on where it was, to the same end."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vtank as vt
from vtank import compiled
from vtank.diagnose.whole import model
from vtank.diagnose.whole.unfinished import digest, filed, step

SETTINGS = (
    "vehicle=bluerov2",
    "duration_s=15",
    "sensor.imu.rate_hz=10",
    'effects."thruster_dead@thruster_1".share=0.3',
)


@pytest.fixture(scope="module")
def flight() -> tuple[vt.Run, ...]:
    return vt.run("whole/zigzag", settings=SETTINGS, seed=5)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(compiled, "FOLDER", tmp_path)
    return tmp_path / "unfinished"


def stopped_at(word: str, runs: tuple[vt.Run, ...]) -> None:
    def progress(text: str) -> None:
        if text.startswith(word):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        vt.diagnose(runs, "bluerov2", axes=["surge", "yaw"], progress=progress)


def test_goes_on_where_it_was_interrupted(
    flight: tuple[vt.Run, ...], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fitted, fits = model._fitted, []

    def counted(*given: object) -> model.Model:
        fits.append(given)
        return fitted(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(model, "_fitted", counted)
    through = vt.diagnose(flight, "bluerov2", axes=["surge", "yaw"]).document
    assert not list(folder.iterdir())
    every = len(fits)
    stopped_at("what has no name", flight)
    assert len(list(folder.iterdir())) == 1
    before = len(fits) - every
    assert before > 5
    again = vt.diagnose(flight, "bluerov2", axes=["surge", "yaw"]).document
    assert len(fits) <= 2 * every  # none of them twice
    assert json.dumps(again) == json.dumps(through)
    assert not list(folder.iterdir())


def test_other_recordings_are_diagnosed_anew(flight: tuple[vt.Run, ...], folder: Path) -> None:
    stopped_at("rivals", flight)
    (first,) = folder.iterdir()
    columns = {name: values.copy() for name, values in flight[0].columns.items()}
    name = next(name for name in columns if name.endswith("depth_m"))
    columns[name] += 1e-9
    stopped_at("rivals", (replace(flight[0], columns=columns),))
    assert len({first, *folder.iterdir()}) == 2


def test_a_failure_leaves_nothing(folder: Path) -> None:
    with pytest.raises(ValueError, match="no"), filed("a"):
        step(lambda: "key", lambda: 1, lambda x: x, lambda x: x)
        raise ValueError("no")
    assert not list(folder.iterdir())


def test_a_line_that_was_cut_off_is_no_step(folder: Path) -> None:
    value = 0.1 + 0.2
    with pytest.raises(KeyboardInterrupt), filed("a"):
        step(lambda: "whole", lambda: value, lambda x: x, lambda x: x)
        step(lambda: "cut", lambda: value, lambda x: x, lambda x: x)
        raise KeyboardInterrupt
    (path,) = folder.iterdir()
    path.write_text(path.read_text(encoding="utf-8")[:-5], encoding="utf-8")
    with filed("a"):
        assert step(lambda: "whole", lambda: 0.0, lambda x: x, lambda x: x) == value
        assert step(lambda: "cut", lambda: 1.0, lambda x: x, lambda x: x) == 1.0


def test_without_a_place_to_write_it_goes_through(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "FOLDER", Path("/proc/none"))
    with filed("a"):
        assert step(lambda: "key", lambda: 1, lambda x: x, lambda x: x) == 1


def test_the_digest_tells_parts_apart() -> None:
    assert digest(["a", "bc"]) != digest(["ab", "c"])
    assert digest([np.zeros(2)]) != digest([np.zeros(3)])
    assert digest([0.1]) == digest([0.1])
