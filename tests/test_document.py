"""One document in every outlet: nothing is lost, nothing that is shown can become markup, narrow windows hold it."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from dataclasses import dataclass
from html import unescape
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from browser import shot

from vtank.present.blocks import Bars, Block, Details, Drawing, Film, Heading, Links, Paragraph, Picture, Table, Terms
from vtank.present.document import bound, csv_text, html, literal, markdown, plain
from vtank.present.numbers import fixed, number, percent
from vtank.present.svg import drawn
from vtank.record import jsonable

EVIL = ("<script>alert(1)</script>", "*a* _b_ `c` ~d~", "![x](http://y/z.png)", "[x](javascript:alert(1))", "&lt;b&gt;",
        "a|b", "\\*not\\*", "x\n# y", "<!-- z -->")  # fmt: skip


def test_no_line_breaks_between_a_number_and_its_unit() -> None:
    space = "\N{NO-BREAK SPACE}"
    told = "6.77 mm of 30 % in 2 runs, 0.3 m/s at 5 minutes"
    assert bound(told) == f"6.77{space}mm of 30{space}% in 2 runs, 0.3{space}m/s at 5 minutes"
    assert f"<b>49{space}% of its force</b>" in html("t", [Paragraph("thruster 1", "49 % of its force")])


def page(text: str) -> list[Block]:
    """Every kind of block, with that text wherever a text is shown."""
    table = Table((text, "n"), ((text, "1.0"),), (text,), ("first",), name="t", title=text)
    return [
        Heading(text, 1),
        Paragraph(text, text),
        Paragraph(text),
        table,
        Picture("p.png", text),
        Film("f.mp4", text),
        Drawing('<svg viewBox="0 0 9 9"></svg>', text, (("refit", text),)),
        Bars(((text, 0.95, True), (text, 0.001, False))),
        Terms(((text, (Paragraph(text, text), table)),)),
        Links((("a/index.html", text),)),
        Details(text, text),
    ]


class Shown(HTMLParser):
    """The tags of a page, and the text that is seen."""

    def __init__(self, code: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.texts: list[str] = []
        self.feed(code)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_every_kind_of_block_is_in_every_outlet() -> None:
    blocks = page("said")
    text, marked, code = plain(*blocks), markdown(blocks), html("said", blocks)
    assert text.count("said") >= 12 and "over 99" not in text and "95 %" in text and "under 1 %" in text
    for piece in (
        "# said",
        "**said** said",
        "| said | 1.0 |",
        "## said",
        "![said](p.png)",
        "[said](f.mp4)",
        "- [a/index.html](a/index.html): said",
    ):
        assert piece in marked
    shown = Shown(code)
    for tag in ("h1", "h2", "table", "img", "video", "svg", "dl", "details", "a", "figcaption", "footer"):
        assert tag in shown.tags
    assert "<td>1.0</td>" in code and '<a href="a/index.html">' in code and '<img src="p.png"' in code


@pytest.mark.parametrize("evil", EVIL)
def test_nothing_that_is_shown_becomes_html(evil: str) -> None:
    shown, harmless = Shown(html(evil, page(evil))), Shown(html("said", page("said")))
    assert shown.tags == harmless.tags
    assert sum(evil in text for text in shown.texts) == sum("said" in text for text in harmless.texts)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("<script>", "&lt;script>"),
        ("x < y, a <1>", "x < y, a <1>"),
        ("*a* _b_ q_ii", "\\*a\\* \\_b\\_ q_ii"),
        ("a|b `c` \\", "a\\|b \\`c\\` \\\\"),
        ("a [1/ft], [x](y)", "a [1/ft], [x\\](y)"),
        ("&lt; & so", "&amp;lt; & so"),
        ("two\nlines", "two lines"),
    ],
)
def test_markdown_escapes_what_is_markup_and_no_more(text: str, code: str) -> None:
    assert literal(text) == code


def test_a_paragraph_cannot_open_a_heading_or_a_list() -> None:
    starts = ["# a", "- a", "+ a", "1. a", "12) a", "> a", "[a]: b"]
    assert all(
        markdown([Paragraph(start)]).split("\\")[0].isdigit() or markdown([Paragraph(start)])[0] == "\\"
        for start in starts
    )
    assert markdown([Paragraph("a-b 1.5")]) == "a-b 1.5\n"


def test_a_row_of_a_markdown_table_keeps_its_cells() -> None:
    table = markdown([Table(("run", "n"), (("a|b\n| c", "1"),))]).splitlines()
    assert [line.replace("\\|", "").count("|") for line in table] == [3, 3, 3]


def test_addresses_hold_any_file_name() -> None:
    path = 'run #1 (50%) "x".png'
    quoted = "run%20%231%20%2850%25%29%20%22x%22.png"
    assert f"]({quoted})" in markdown([Picture(path, "c")]) and f'src="{quoted}"' in html("t", [Picture(path, "c")])
    inside = "data:image/png;base64,AA+/="
    assert f'src="{inside}"' in unescape(html("t", [Picture(inside, "c")]))


def test_text_for_a_terminal_keeps_its_width_and_aligns_its_tables() -> None:
    long = Paragraph("word " * 60)
    table = Table(("name", "x"), (("a", "10"), ("bcd", "1.5")), ("note",), title="Title")
    assert plain(table) == "\nTitle\n\nname    x\na      10\nbcd   1.5\nnote"
    text = plain(Heading("H"), long, Terms((("Where", (long, long)),)), width=60)
    assert max(map(len, text.splitlines())) <= 60
    margins = [line[:12].rstrip() for line in text.splitlines() if line.startswith(("Where", " "))]
    assert margins[0] == "Where" and set(margins[1:]) == {""}


def test_csv_and_json_hold_the_numbers() -> None:
    @dataclass
    class Found:
        a: float
        b: np.ndarray

    header, rows = ("name", "x", "n"), [("a,b", np.float64(1 / 3), 2), ("c", float("nan"), 3)]
    assert list(csv.reader(io.StringIO(csv_text(header, rows)))) == [
        [*header],
        ["a,b", "0.333333", "2"],
        ["c", "nan", "3"],
    ]
    assert csv_text(header, rows, blank=True).endswith("c,,3\n")
    data = jsonable({"f": Found(np.inf, np.array([1.0, np.nan])), 3: (np.float64(1.5), np.bool_(True), "s", None)})
    assert json.dumps(data, allow_nan=False) == '{"f": {"a": null, "b": [1.0, null]}, "3": [1.5, true, "s", null]}'


def test_numbers_as_they_are_shown() -> None:
    assert (number(1234.56), number(np.nan), fixed(1.239, 2), fixed(np.inf, 2)) == ("1235", "-", "1.24", "-")
    assert percent(0.9999) == "over 99 %"


def test_the_longest_things_do_not_widen_a_page(tmp_path: Path, fits: Callable[[Path], bool]) -> None:
    header, row = tuple(f"column {i}" for i in range(30)), ("x" * 400, *["1.23456"] * 29)
    wide = Table(header, (row,), ("n" * 500,), title="t" * 200)
    blocks = [*page("word " * 30), *page("x" * 300), wide, Links((("folder/" * 30 + "file.html", "there"),))]
    (tmp_path / "wide.html").write_text(html("t" * 300, blocks), encoding="utf-8")
    assert fits(tmp_path / "wide.html")


def test_a_figure_that_scrolls_sideways_is_shaded_where_more_follows(tmp_path: Path, browser: str) -> None:
    """It would look cut off else: a telephone shows no scroll bar."""
    page = tmp_path / "page.html"
    page.write_text(html("t", [Drawing(drawn("d", 800, 900, "", "empty"), "c")]), encoding="utf-8")
    narrow, wide = (shot(browser, tmp_path, page, width)[500, :, 0] for width in (400, 1200))  # a row, [0 to 1]
    assert narrow[30:360].min() > 0.95 and narrow[366:372].max() < 0.9  # 375 is the figure's end
    assert wide[110:1090].min() > 0.95
