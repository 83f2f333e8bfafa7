"""The catalogue on the command line, and in the document of the scenarios."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from vtank.cli import main
from vtank.effects.catalogue import BY_NAME, CATALOGUE
from vtank.present.catalogue import catalogue_table
from vtank.tank.places.catalogue import CATALOGUE as PLACED

DEAD = next(effect for effect in PLACED if effect.name == "thruster_dead").numbers[0]
README = Path(__file__).parents[1] / "scenarios" / "README.md"


def test_all_effects_are_told_with_law_unit_source_and_rivals(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects"]) == 0
    shown, _, last = capsys.readouterr().out.rpartition("\n\n")
    assert "vtank effects --places" in last
    paragraphs = {text.split("\n")[0]: " ".join(text.split()) for text in shown.split("\n\n")}
    assert list(paragraphs) == list(BY_NAME)
    for effect in CATALOGUE:
        text = paragraphs[effect.name]
        assert effect.channel in text and " ".join(effect.law.split()) in text and effect.source in text
        assert all(f"{q.key} " in text and f"[{q.unit}]" in text for q in effect.parameters)
        assert all(name in text for name in effect.confused_with)


def test_one_effect(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "thrust_saturation"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("thrust_saturation\n")
    assert "at least 0, no effect where it is never reached" in " ".join(shown.split())


def test_json_holds_the_whole_catalogue(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [entry["name"] for entry in found] == list(BY_NAME)
    drag = next(entry for entry in found if entry["name"] == "linear_drag")
    assert drag["parameters"][0]["key"] == "c_per_s"
    assert drag["parameters"][0]["null"] == 0.0
    saturation = next(entry for entry in found if entry["name"] == "thrust_saturation")
    assert saturation["parameters"][0]["null"] is None and saturation["parameters"][0]["bounds"][1] is None


def test_an_unknown_effect_lists_those_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "magic"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("vtank: error: no effect 'magic'; there are: ")
    assert error.count(", ") == 4 and re.search(r" and \d\d more\n$", error), "the nearest of many, and how many more"
    assert error.count("\n") == 1


def test_the_table_of_the_document_is_current() -> None:
    text = README.read_text(encoding="utf-8")
    table = text.split("<!-- effects -->\n")[1].split("<!-- end of effects")[0]
    assert table == catalogue_table(), "run: vtank effects --markdown, and put the table into scenarios/README.md"


def test_every_row_of_the_table_has_the_same_number_of_cells() -> None:
    rows = catalogue_table().replace("\\|", "").splitlines()
    assert {row.count("|") for row in rows} == {6}
    assert len(rows) == len(CATALOGUE) + 2


def test_an_effect_at_places_is_shown_by_its_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "thruster_dead"]) == 0
    assert capsys.readouterr().out == (
        "thruster_dead\n"
        "  place          a thruster, by its name\n"
        "  law            F -> (1 - share) F\n"
        f"  share          {DEAD.meaning}, {DEAD.low:g} to {DEAD.high:g}, {DEAD.default:g} where it is not given\n"
        '  in a scenario  effects."thruster_dead@PLACE"\n'
    )
    assert main(["effects", "linear_drag", "thruster_dad"]) == 2
    assert "no effect 'thruster_dad'; did you mean 'thruster_dead'?" in capsys.readouterr().err
    for effect in PLACED:
        assert main(["effects", effect.name]) == 0 and "|" not in capsys.readouterr().out.splitlines()[0]
    assert main(["effects", "thruster_wek"]) == 2
    assert "did you mean 'thruster_dead'?" in capsys.readouterr().err
    assert main(["effects", "linear_drag", "thruster_dead"]) == 0
    assert "\n\nthruster_dead\n" in capsys.readouterr().out
    assert main(["effects", "thruster_dead", "--json"]) == 2
    assert "no effect 'thruster_dead' of surge" in capsys.readouterr().err
