"""`vtank demo`: the story from the sealed cause to the second recording, its start page, and what becomes of it
where it is interrupted."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from browser import open_page
from matplotlib.image import imread

import vtank as vt
from vtank.cli import main
from vtank.present import Heading, Links, Table
from vtank.studies.story import bluerov, phoenix, pictures
from vtank.studies.story.page import write_page
from vtank.studies.story.step import Act, Step
from vtank.studies.story.withheld import candidates, draw, toml
from vtank.tank.poses import Poses

NOMINAL = vt.load_truth("paper-ii")
EVIL = "<script>alert(1)</script>"
PAPER = {"1": (251, 251, 249), "0": (15, 22, 27)}  # of the page, light and dark


# --- what is withheld ----------------------------------------------------------------------------------------------
def test_every_effect_that_can_be_seen_is_drawn_and_none_that_cannot(tmp_path: Path) -> None:
    drawn = {}
    for seed in range(150):
        effect, truth = draw(seed, NOMINAL)
        drawn[effect.name] = truth
        (tmp_path / "truth.toml").write_text(toml(effect, truth), encoding="utf-8")
        assert np.allclose(vt.load_truth(tmp_path / "truth.toml").vector(), truth.vector(), rtol=1e-8)
    assert set(drawn) == {effect.name for effect in candidates(NOMINAL)} and len(drawn) > 15
    assert not {"thrust_lag", "sonar_offset", "sonar_latency", "command_delay"} & set(drawn)  # known, absorbed, tied


def test_a_seed_draws_one_world() -> None:
    assert toml(*draw(7, NOMINAL)) == toml(*draw(7, NOMINAL)) != toml(*draw(8, NOMINAL))


# --- the story -----------------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, str]]:
    """The demo on short flights: its folder, and what it prints."""
    out, lines = tmp_path_factory.mktemp("demo") / "out", []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(phoenix, "EXPERIMENTS", ("paper-ds1", "multisine"))
        patch.setattr(phoenix, "SETTINGS", ("duration_s=40",))
        patch.setattr(bluerov, "SETTINGS", ("duration_s=20",))
        patch.setattr(pictures, "SIZE", (96, 64))
        patch.setattr(pictures, "LONGEST_S", 0.4)
        patch.setattr("builtins.print", lambda *text, **_: lines.append(" ".join(text)))
        assert main(["demo", "--out", str(out), "--seed", "1996"]) == 0
    yield out, "\n".join(lines)


@pytest.mark.slow
def test_it_is_told_in_numbered_steps_that_end_with_what_was_withheld(told: tuple[Path, str]) -> None:
    out, said = told
    assert [int(n) for n in re.findall(r"^ ?(\d+)  [A-Z]", said, re.MULTILINE)] == list(range(1, 14))
    assert said.count(f"{out / 'index.html'} is the page to start at") == 2 and "vtank reproduce" in said
    effect, _ = draw(1996, NOMINAL)
    said = " ".join(said.split())
    assert said.index("Its cause.") < said.index(f"It was {effect.name.replace('_', ' ')}. The diagnosis named it.")
    assert "It was thruster 4" in said and "The diagnosis named it, with 49" in said


@pytest.mark.slow
def test_what_is_diagnosed_lies_apart_from_the_truth(told: tuple[Path, str]) -> None:
    out, _ = told
    for data in ("recording", "second", "bluerov2/bluerov2-multisine", "bluerov2/turns-and-steps"):
        assert not (out / data / "truth.json").exists() and vt.load(out / data)
    assert {path.name for path in (out / "withheld").iterdir()} == {
        "phoenix.toml", "recording.json", "second.json",
        "bluerov2.txt", "bluerov2-multisine.json", "turns-and-steps.json",
    }  # fmt: skip


@pytest.mark.slow
def test_the_corrected_simulator_agrees_with_the_second_recording(told: tuple[Path, str]) -> None:
    out, _ = told
    errors = vt.predict(out / "gap.toml", out / "second" / "paper-ds2.csv")
    assert errors["rms"]["diagnosed"] < 0.2 * errors["rms"]["nominal"]
    assert errors["rms"]["diagnosed"] < 3.0 * errors["floor"]
    verdict = json.loads((out / "bluerov2" / "gap.json").read_text())["verdict"]
    assert (verdict["effects"], verdict["places"]) == (["thruster_dead"], ["thruster_4"])


@pytest.mark.slow
def test_the_start_page_leads_to_what_is_there_and_fits(told: tuple[Path, str], fits: Callable[[Path], bool]) -> None:
    page = told[0] / "index.html"
    text = page.read_text(encoding="utf-8")
    targets = set(re.findall(r'(?:src|href)="([^"#]+)', text)) - {"data:,"}
    assert {"tank.png", "gap.html", "bluerov2/gap.html"} <= targets
    assert all((page.parent / target).exists() for target in targets)
    assert "://" not in text.replace("http://www.w3.org/2000/svg", "")
    assert len(re.findall(r"<h2>\d+\. ", text)) == 13 and "being flown" not in text
    assert fits(page) and fits(page.with_name("gap.html")) and fits(page.parent / "bluerov2" / "gap.html")


@pytest.mark.slow
@pytest.mark.parametrize("width", [500, 1400])
@pytest.mark.parametrize("light", ["1", "0"])
def test_a_browser_draws_the_start_page(
    told: tuple[Path, str], browser: str, tmp_path: Path, width: int, light: str
) -> None:
    """With its pictures, in light and dark, on a wide screen and on the narrowest window that the browser has."""
    shot = tmp_path / "shot.png"
    options = (f"--blink-settings=preferredColorScheme={light}", f"--screenshot={shot}", f"--window-size={width},1900")
    _, console = open_page(browser, tmp_path / "profile", told[0] / "index.html", *options)
    seen = np.round(255.0 * imread(shot)[..., :3]).astype(int)
    assert console == [] and tuple(seen[3, 3]) == PAPER[light]
    water = np.abs(seen - [145, 200, 208]).max(axis=-1) < 14  # of the tank's picture
    assert water.sum() > 2000


# --- the command ---------------------------------------------------------------------------------------------------
def first(act: Act) -> Iterator[Step]:
    (act.folder / "gap.html").write_text("the first act")
    yield Step("The first step", "It took 1 m.", card=("The gap", "1 m", "noise makes 7 mm"))


def interrupted(act: Act) -> Iterator[Step]:
    (act.folder / "half.txt").write_text("half done")
    yield Step("The second step", "It goes on.")
    raise KeyboardInterrupt


def second(act: Act) -> Iterator[Step]:
    yield Step("The second step", "It goes on.")


def test_the_first_act_is_there_before_the_second_and_stays_when_that_is_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(phoenix, "phoenix", first)
    monkeypatch.setattr(bluerov, "bluerov", interrupted)
    assert main(["demo", "--out", str(tmp_path / "out")]) == 130
    said, page = capsys.readouterr().out, (tmp_path / "out" / "index.html").read_text()
    assert " 1  The first step. It took 1 m." in said and "a second act follows" in said and " 2  The second" in said
    assert "The first step" in page and "being flown" in page and "The second step" not in page
    assert not (tmp_path / "out" / "half.txt").exists()
    monkeypatch.setattr(bluerov, "bluerov", second)
    assert main(["demo", "--out", str(tmp_path / "out")]) == 0  # in the place of what is there
    page = (tmp_path / "out" / "index.html").read_text()
    assert "The second step" in page and "being flown" not in page and 'href="gap.html"' in page
    files = set(json.loads((tmp_path / "out" / "demo.json").read_text())["files"])
    assert files == {"gap.html", "index.html"}


# --- the page and its pictures -------------------------------------------------------------------------------------
def test_names_cannot_become_markup_in_a_browser(browser: str, tmp_path: Path) -> None:
    blocks = (Heading(EVIL), Table((EVIL,), ((EVIL,),)), Links(((EVIL, EVIL),)))
    view = SimpleNamespace(film=refused)
    step = Step(EVIL, pictures.filmed(view, tmp_path, "a.mp4", EVIL).text, blocks, (EVIL, EVIL, EVIL))
    write_page(tmp_path, [step], complete=True)
    printed, console = open_page(browser, tmp_path / "profile", tmp_path / "index.html", "--dump-dom")
    assert console == [] and printed.count("<script>") == 1  # that of the theme
    assert printed.count("&lt;script&gt;alert(1)&lt;/script&gt;") > 8


def refused(*args: object) -> str:
    raise vt.InputError(f"{EVIL}: no film")


def test_a_film_that_cannot_be_made_is_said(tmp_path: Path) -> None:
    found = pictures.filmed(SimpleNamespace(film=refused), tmp_path, "a.mp4", "a flight")
    assert found.blocks == () and found.text == f"No film: {EVIL}: no film."
    made = pictures.filmed(SimpleNamespace(film=lambda *args: "rendered"), tmp_path, "a.mp4", "a flight")
    assert made.text == "" and [film.caption for film in made.blocks] == ["a flight; rendered."]


def test_the_overlay_shows_both_and_tells_how_far_they_part() -> None:
    t = np.arange(0.0, 10.0, 0.1)
    ghost, flown = (
        Poses(t, np.outer(way, [1, 0, 0]), np.zeros((t.size, 3))) for way in (np.sin(t), np.sin(t) + 0.05 * t)
    )
    svg, apart_m = pictures.overlay("before", SimpleNamespace(ghost=ghost), {"nominal": flown})
    assert apart_m == pytest.approx(0.05 * t[-1])
    marks = ElementTree.fromstring(svg)
    kinds = [mark.get("class") for mark in marks.iter() if mark.tag.endswith("polyline")]
    assert kinds == ["line nominal", "line nominal"] and "nominal: up to 0.495 m off" in svg
