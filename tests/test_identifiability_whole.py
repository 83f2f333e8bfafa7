"""Plans of whole vehicles: which coefficients they tell, and which effects at which places they tell apart."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from vtank.cli import main
from vtank.errors import InputError
from vtank.studies.design import WholeFindings, examine_whole, write_whole

SURGE = """vehicle = "bluerov2"
duration_s = 20
depth_m = 50
[[excite]]
kind = "multisine"
axis = "surge"
amplitudes_share = [0.2, 0.2, 0.2]
frequencies_rad_s = [0.4, 0.9, 1.8]
"""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Surge alone."""
    path = tmp_path_factory.mktemp("plan") / "surge.toml"
    path.write_text(SURGE)
    return path


@pytest.fixture(scope="module")
def found(scenario: Path) -> WholeFindings:
    return examine_whole([scenario])


def test_a_run_of_surge_tells_surge_and_not_sway(found: WholeFindings) -> None:
    """A drag of sway, which hardly moves, is known as before; that of surge as well as the thrust is.

    And a lag to within what nobody knows of when inputs act, which come 10 times a second.
    """
    told = {name: sd / prior for name, _, prior, sd in found.own}
    assert told["quadratic_drag@surge"] < 0.7 and told["lag@thrusters"] < 0.2
    assert told["quadratic_drag@sway"] > 0.9
    assert "lag@thrusters" in found.sentences()[0] and "@sway" not in found.sentences()[0]


def test_effects_are_seen_where_the_run_excites_them(found: WholeFindings) -> None:
    seen = {e.name: e for e in found.effects}
    assert seen["coulomb_friction@surge"].left > 3.0
    assert seen["munk_moment@yaw"].standing in ("too small", "absorbed")
    assert all(e.left <= 1.01 * e.raw for e in found.effects)
    rivals = {e.name: e.rival for e in found.effects if e.standing == "tied"}
    assert all(rival in seen and rival.partition(":")[0] != name.partition(":")[0] for name, rival in rivals.items())


def test_everything_is_written(found: WholeFindings, tmp_path: Path) -> None:
    names = write_whole(tmp_path / "out", found)
    assert sorted(names) == ["bounds.csv", "effects.csv", "identifiability.html", "identifiability.json"]
    lines = (tmp_path / "out" / "effects.csv").read_text().splitlines()
    assert len(lines) > len(found.effects)
    assert len(json.loads((tmp_path / "out" / "identifiability.json").read_text())["effects"]) == len(found.effects)


def test_plans_of_one_axis_and_of_vehicles_stay_apart(scenario: Path, capsys: Any) -> None:
    for arguments, message in (
        (["paper-ds1", str(scenario)], "experiment of one axis"),
        ([str(scenario), "--design"], "go with experiments of one axis"),
        (["paper-ds1", "--nominal", "bluerov2"], "goes with scenarios of a whole vehicle"),
    ):
        assert main(["identifiability", *arguments]) == 2
        assert message in capsys.readouterr().err
    with pytest.raises(InputError, match="different vehicles"):
        examine_whole([scenario, "whole/kingfisher-steps"])
