"""Blind trials of whole vehicles: what is drawn can be flown, and the truth is sealed apart from the recordings."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from vtank.cli import main
from vtank.experiment.whole_scenario import load_whole_scenario
from vtank.plant import load_vehicle
from vtank.record import read_dataset
from vtank.record.table import Table
from vtank.studies.blind.seal import commitment, read_index
from vtank.studies.blind.whole import case as cases
from vtank.studies.blind.whole import scenarios
from vtank.studies.blind.whole.sizes import entries
from vtank.tank.places import CATALOGUE, partners, places, read_placed


@pytest.mark.parametrize("name", cases.CRAFT)
def test_every_effect_has_a_size_at_every_place_of_every_vehicle(name: str) -> None:
    """What is drawn is what a scenario may hold, and nothing of it is nothing."""
    vehicle, random = load_vehicle(name), np.random.default_rng(1)
    for effect in CATALOGUE:
        at = effect.places if effect.kind == "axis" else places(vehicle)[effect.kind]
        for place in at:
            sensor = next((s for s in vehicle.sensors if effect.kind == "sensor" and s.name == place), None)
            if sensor and effect.channels and not set(effect.channels) & set(sensor.channels):
                continue
            if effect.text == "other" and not partners(vehicle, place):
                continue
            told = entries(random, effect, place, vehicle, 0.7)
            placed = read_placed(Table(Path("trial"), "effects", {f"{effect.name}@{place}": told}), vehicle)
            assert placed[0].place == place
            assert all(np.isfinite(v) and v != 0.0 for v in told.values() if not isinstance(v, str)), told


@pytest.mark.parametrize("name", cases.CRAFT)
@pytest.mark.parametrize("family", scenarios.FAMILIES)
def test_every_family_of_scenarios_suits_every_vehicle(name: str, family: str, tmp_path: Path) -> None:
    (tmp_path / "drawn.toml").write_text(scenarios.draw_scenario(np.random.default_rng(2), load_vehicle(name), family))
    assert load_whole_scenario(tmp_path / "drawn.toml").pilot().orders


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenarios, "DURATION_S", (8.0, 9.0))
    monkeypatch.setattr(cases, "GIVEN", (1, 1))


def test_cases_are_sealed_and_come_again_from_their_seed(short: None, tmp_path: Path) -> None:
    for folder in ("one", "again"):
        out = tmp_path / folder
        assert (
            main(["blind", "make", "--vehicles", "--trials", "3", "--seed", "8", "--threads", "1", "--out", str(out)])
            == 0
        )
    index, again = read_index(tmp_path / "one"), read_index(tmp_path / "again")
    assert [entry.runs for entry in index.entries] == [entry.runs for entry in again.entries]
    for entry in index.entries:
        sealed = json.loads((tmp_path / "one-truth" / f"{entry.case}.json").read_text())
        assert commitment(sealed["salt"], sealed["truth"]) == entry.commitment
        truth = sealed["truth"]
        assert truth["vehicle"] == entry.nominal and truth["data"] == entry.data
        assert truth["kind"] in ("none", "parameters") or max(truth["signal"].values()) >= 1.0
        if truth["kind"] == "none":
            assert max(truth["signal"].values()) == 0.0
        runs = read_dataset(tmp_path / "one" / entry.case).runs
        assert len(runs) == truth["given"] == 1 and len(truth["held_out_files"]) == 1
        down = [z for run in runs for name in run.columns if name.endswith("depth_m") for z in run.samples(name)[1]]
        assert not down or min(down) > 20.0  # vtank's water has no surface to break
        told = "".join(path.read_text() for path in (tmp_path / "one" / entry.case).iterdir())
        assert "@" not in told and "@" not in (tmp_path / "one" / "cases.json").read_text()


def test_options_of_single_axis_trials_do_not_go_with_vehicles(tmp_path: Path, capsys) -> None:
    arguments = ["blind", "make", "--vehicles", "--trials", "1", "--seed", "1", "--out", str(tmp_path / "x")]
    assert main([*arguments, "--familiar"]) == 2
    assert "do not go with --vehicles" in capsys.readouterr().err
