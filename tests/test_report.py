"""The report: complete in itself, well formed, readable in light and dark, and drawn by a real browser."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import open_page
from drawings import cut_off
from matplotlib.image import imread
from recorded import find, recordings

from vtank.diagnose.budget import budget
from vtank.diagnose.diagnosis import Diagnosis
from vtank.diagnose.shrink import left_out
from vtank.diagnose.verdict import Verdict, probabilities
from vtank.present.page import report_html

EVIL = "<script>alert(1)</script>"
VOID = {"meta", "link", "br", "path", "circle", "rect", "polyline"}
SHRINK = {"unit": "m", "nominal": 0.08, "refit": 0.03, "diagnosed": 0.008, "floor": 0.007, "fraction_closed": 0.957,
          "interval90": [0.91, 0.99]}  # fmt: skip
BUDGET = {"budget": [
    {"name": "own parameters", "kind": "parameters", "share": 0.6, "interval90": [0.5, 0.7]},
    {"name": "coulomb_friction", "kind": "effect", "share": 0.35, "interval90": [0.3, 0.4]},
    {"name": "repeatable, unnamed", "kind": "repeatable", "share": 0.0, "interval90": [0.0, 0.0]},
    {"name": "disturbance", "kind": "disturbance", "share": 0.01, "interval90": [0.0, 0.02]},
    {"name": "sensor noise", "kind": "noise", "share": 0.04, "interval90": [0.03, 0.05]},
], "unexplained": {"share": 0.01, "interval90": [0.0, 0.02]}, "worse": []}  # fmt: skip
NEXT = {"experiment": "a sine", "minutes": 2.0, "per_minute": 0.9, "against_repeat": 6.0, "question": "how large",
        "alternatives": [{"experiment": "a step", "minutes": 1.0, "per_minute": 0.5}]}  # fmt: skip


@pytest.fixture(scope="module")
def friction() -> tuple[Diagnosis, dict[str, Any]]:
    found = find(recordings({"coulomb_friction.f": 0.006}), "coulomb_friction", "seiche")
    parts = left_out(found.selection, found.verdict)
    shares = budget(found.selection, found.verdict, 5, parts)
    chances = probabilities(found.selection)
    diagnosis = Diagnosis(found.selection, chances, found.verdict, parts, shares, seed=5)
    return diagnosis, diagnosis.summary() | {"where": found.place.document()}


@pytest.fixture(scope="module")
def page(friction: tuple[Diagnosis, dict[str, Any]]) -> str:
    diagnosis, document = friction
    return report_html(diagnosis, document | BUDGET | {"shrink": SHRINK, "next_experiment": NEXT})


class Reader(HTMLParser):
    """Collects tags, ids, addresses and text, and complains about tags that do not close."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.ids: list[str] = []
        self.addresses: list[str] = []
        self.headings: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attributes:
            if name == "id":
                self.ids.append(value or "")
            if name in ("src", "href", "xlink:href", "srcset", "action", "data", "poster"):
                self.addresses.append(value or "")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] in ("h1", "h2", "h3"):
            self.headings.append(data)


def test_the_page_is_well_formed(page: str) -> None:
    reader = Reader(page)
    assert len(set(reader.ids)) == len(reader.ids)
    assert reader.tags.count("svg") == 7
    assert reader.tags.count("figcaption") == reader.tags.count("figure") == 7


def test_the_page_loads_nothing(page: str) -> None:
    assert Reader(page).addresses == ["data:,"]
    assert set(re.findall(r"https?://[^\s\"'<]+", page)) == {"http://www.w3.org/2000/svg"}
    assert all(address.startswith("#") for address in re.findall(r"url\(([^)]*)", page))  # places of the page itself
    assert "@import" not in page
    assert "default-src 'none'" in page


def test_the_verdict_comes_first_and_the_sections_follow(page: str) -> None:
    assert Reader(page).headings == [
        "Compared with given parameters. The gap is caused by coulomb friction.",
        "What the gap is made of",
        "How far the gap shrinks",
        "Every run, before and after",
        "Where the gap lies",
        "Over time",
        "Over frequency",
        "Over speed, input and place",
        "Which effect",
        "What cannot be told apart",
        "Estimates",
        "Drag and thrust",
        "What to do next",
    ]


def test_every_picture_says_what_it_shows(page: str) -> None:
    titles = re.findall(
        r'<svg id="(\w+)"[^>]*role="img" aria-labelledby="\1-alt"[^>]*><title id="\1-alt">([^<]+)', page
    )
    assert [name for name, _ in titles] == ["budget", "gap", "shrink", "runs", "time", "spectrum", "force"]
    assert all(len(text) > 40 for _, text in titles)
    assert [text for svg in re.findall(r"<svg id.*?</svg>", page, re.DOTALL) for text in cut_off(svg)] == []


@pytest.fixture
def evil(friction: tuple[Diagnosis, dict[str, Any]]) -> str:
    """The report of a run with a name that would run if it became markup."""
    diagnosis, document = friction
    setting = diagnosis.selection.setting
    runs = (replace(setting.runs[0], name=EVIL), *setting.runs[1:])
    renamed = replace(diagnosis, selection=replace(diagnosis.selection, setting=replace(setting, runs=runs)))
    return report_html(renamed, document)


def test_names_of_runs_cannot_become_markup(evil: str) -> None:
    assert EVIL not in evil and "&lt;script&gt;" in evil
    Reader(evil)


def test_a_browser_shows_a_name_that_looks_like_markup_as_it_is(browser: str, evil: str, tmp_path: Path) -> None:
    (tmp_path / "evil.html").write_text(evil, encoding="utf-8")
    printed, console = open_page(browser, tmp_path / "profile", tmp_path / "evil.html", "--dump-dom")
    assert console == [] and printed.count("<script>") == 1 and "&lt;script&gt;alert(1)" in printed


def test_what_was_not_worked_out_is_said(friction: tuple[Diagnosis, dict[str, Any]]) -> None:
    text = report_html(*friction)
    assert "This was not worked out" in text and "left out was not worked out" in text and "No next experiment" in text
    assert Reader(text).tags.count("svg") == 5


@pytest.mark.parametrize("kind", ["none", "parameters", "varying", "unknown", "undecided", "open"])
def test_every_kind_of_verdict_makes_a_page(friction: tuple[Diagnosis, dict[str, Any]], kind: str) -> None:
    diagnosis, document = friction
    fit = {"none": diagnosis.selection.nominal, "parameters": diagnosis.selection.refit}.get(
        kind, diagnosis.verdict.fit
    )
    names = ("coulomb_friction",) if kind == "undecided" else ()
    own = ("beta",) if kind == "varying" else ()
    channel = None if kind in ("none", "parameters", "open") else "sensor"
    kind = "undecided" if kind == "open" else kind  # between no effect and others
    verdict = Verdict(kind, names, names, channel, 0.6, fit, own)
    other = replace(diagnosis, verdict=verdict)
    Reader(report_html(other, other.summary() | BUDGET | {"where": document["where"], "shrink": SHRINK}))


def luminance(colour: str) -> float:
    """Relative luminance of #rrggbb (WCAG 2.2)."""
    parts = [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return float(np.dot((0.2126, 0.7152, 0.0722), linear))


def contrast(a: str, b: str) -> float:
    """Contrast of two colours (WCAG 2.2)."""
    light, dark = sorted((luminance(a), luminance(b)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


STYLE = (resources.files("vtank.present") / "style.css").read_text(encoding="utf-8")
BLOCKS = re.findall(r"\{([^{}]*--paper: [^{}]*)\}", STYLE)
PALETTES = [dict(re.findall(r"--(\w+): (#\w{6})", block)) for block in BLOCKS]  # light, dark by choice, dark, printed


@pytest.mark.parametrize("palette", PALETTES)
def test_text_and_lines_stand_out_from_the_paper(palette: dict[str, str]) -> None:
    for ground in ("paper", "card"):
        assert contrast(palette["ink"], palette[ground]) > 10.0
        assert contrast(palette["muted"], palette[ground]) > 4.5
        for line in ("nominal", "refit", "diagnosed"):
            assert contrast(palette[line], palette[ground]) > 3.0
    for line in ("refit", "diagnosed"):
        assert contrast(palette[line], palette["floor"]) > 3.0
        assert contrast(palette[line], palette["mark"]) > 3.0


def test_dark_by_preference_and_dark_by_choice_are_the_same() -> None:
    light, chosen, preferred, printed = PALETTES
    assert chosen == preferred != light
    assert set(light) == set(chosen) == set(printed)


# --- in a browser --------------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory, friction: tuple[Diagnosis, dict[str, Any]]) -> Path:
    path = tmp_path_factory.mktemp("report") / "report.html"
    path.write_text(
        report_html(friction[0], friction[1] | BUDGET | {"shrink": SHRINK, "next_experiment": NEXT}), encoding="utf-8"
    )
    return path


def test_a_browser_runs_the_page_without_a_complaint(browser: str, file: Path, tmp_path: Path) -> None:
    printed, console = open_page(browser, tmp_path, file, "--dump-dom")
    assert console == []
    button = re.search(r'<button id="theme"[^>]*>(\w+)</button>', printed)
    assert button and button.group(1) == "Dark" and "hidden" not in button.group(0)


@pytest.mark.parametrize(("scheme", "setting"), [("light", "1"), ("dark", "0")])
def test_a_browser_draws_the_page_in_light_and_dark(
    browser: str, file: Path, tmp_path: Path, scheme: str, setting: str
) -> None:
    shot = tmp_path / "shot.png"
    options = (f"--blink-settings=preferredColorScheme={setting}", f"--screenshot={shot}", "--window-size=1000,2600")
    _, console = open_page(browser, tmp_path / "profile", file, *options)
    assert console == []
    picture = np.round(255.0 * imread(shot)[..., :3]).astype(int)
    paper = PALETTES[0 if scheme == "light" else 1]["paper"]
    assert picture[5, 5].tolist() == [int(paper[i : i + 2], 16) for i in (1, 3, 5)]
    for name in ("refit", "diagnosed"):  # the pictures are there, in the colours of the scheme
        colour = PALETTES[0 if scheme == "light" else 1][name]
        wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])
        assert np.sum(np.all(np.abs(picture - wanted) <= 2, axis=-1)) > 300


def test_a_telephone_is_not_overflowed(file: Path, fits: Callable[[Path], bool]) -> None:
    """The pictures scroll inside their frames; the page itself is no wider than the window."""
    assert fits(file)
