"""Scales, ticks and lines of the report's pictures."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest
from drawings import SVG, cut_off

from vtank.present.svg import MOST_POINTS, Panel, Scale, around, picture, plain, thinned


def test_a_scale_maps_its_ends_and_middle() -> None:
    scale = Scale(2.0, 6.0, 100.0, 300.0)
    assert [scale(2.0), scale(4.0), scale(6.0)] == [100.0, 200.0, 300.0]
    log = Scale(0.1, 10.0, 0.0, 100.0, log=True)
    assert log(1.0) == pytest.approx(50.0)


def test_a_value_far_outside_stays_near_the_picture() -> None:
    assert -200.0 <= Scale(0.0, 1.0, 0.0, 100.0)(-1e9) <= 0.0
    assert Scale(0.1, 10.0, 0.0, 100.0, log=True)(0.0) == -100.0


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (-0.23, 0.19), (3.0, 1234.5), (-7e-4, 2e-4), (99.0, 101.0)])
@pytest.mark.parametrize("count", [3, 5, 8])
def test_ticks_are_round_inside_and_about_as_many_as_asked(low: float, high: float, count: int) -> None:
    ticks = np.array(Scale(low, high, 0.0, 1.0).ticks(count))
    step = ticks[1] - ticks[0]
    mantissa = step / 10.0 ** np.floor(np.log10(step) + 1e-9)
    assert np.min(np.abs(mantissa - np.array([1.0, 2.0, 5.0]))) < 1e-6
    assert ticks[0] >= low - 1e-9 * step and ticks[-1] <= high + 1e-9 * step
    assert 0.4 * count - 1 <= ticks.size <= count + 1


def test_ticks_of_a_logarithmic_scale() -> None:
    assert Scale(0.1, 1000.0, 0.0, 1.0, log=True).ticks() == pytest.approx([0.1, 1.0, 10.0, 100.0, 1000.0])
    assert Scale(0.3, 9.0, 0.0, 1.0, log=True).ticks() == pytest.approx([0.5, 1.0, 2.0, 5.0])
    assert Scale(0.0, 1.0, 0.0, 1.0).ticks(0) == []


def test_around_holds_all_values_with_room() -> None:
    low, high = around([1.0, np.nan, 3.0])
    assert low < 1.0 and high > 3.0
    assert around([2.0, 2.0]) == (1.0, 3.0)
    assert around([]) < (1.0,)


def test_numbers_on_an_axis() -> None:
    assert [plain(v) for v in (0.0, -0.5, 1234.0, 1e6, 2e-5)] == ["0", "\N{MINUS SIGN}0.5", "1234", "1e6", "2e-5"]
    assert [plain(v) for v in (10000.0, 15000.0)] == ["10000", "15000"]


def test_a_dense_line_keeps_its_extremes_and_order() -> None:
    x = np.linspace(0.0, 1.0, 20011)
    y = np.sin(40.0 * x)
    y[7777] = 5.0
    a, b = thinned(x, y)
    assert a.size <= MOST_POINTS
    assert np.all(np.diff(a) > 0.0)
    assert b.max() == 5.0 and b.min() == pytest.approx(-1.0, abs=1e-3)


def test_a_picture_is_well_formed_and_says_what_it_shows() -> None:
    panel = Panel(Scale(0.0, 1.0, 60.0, 300.0), Scale(0.0, 1.0, 100.0, 10.0))
    panel.frame("time <s>", "a & b", "run <1>")
    panel.line(np.array([0.0, 1.0]), np.array([0.0, 1.0]), "refit")
    panel.box(0.0, 0.5, 0.0, 1.0, "mark", 'said "so"')
    panel.dot(0.5, 0.5, "diagnosed", "here & there")
    root = ElementTree.fromstring(picture("one", 320.0, 140.0, [panel], "what <it> shows"))
    assert root.attrib["role"] == "img"
    title = root.find("{*}title")
    assert (
        title is not None and title.text == "what <it> shows" and title.attrib["id"] == root.attrib["aria-labelledby"]
    )
    assert "run <1>" in [element.text for element in root.iter("{http://www.w3.org/2000/svg}text")]


def test_a_line_that_leaves_its_panel_is_cut_off_there() -> None:
    panels = [Panel(Scale(0.0, 1.0, 60.0, 300.0), Scale(0.0, 1.0, low, low - 90.0)) for low in (100.0, 220.0)]
    for panel, top in zip(panels, (1.0, 7.0), strict=True):
        panel.line(np.array([0.0, 1.0]), np.array([0.0, top]), "refit")
    root = ElementTree.fromstring(picture("one", 320.0, 240.0, panels, "two lines"))
    inside, leaving = root.iter(f"{SVG}polyline")
    assert "clip-path" not in inside.attrib and leaving.attrib["clip-path"] == "url(#one-2)"
    (outline,) = root.iter(f"{SVG}clipPath")
    assert outline.attrib["id"] == "one-2"
    assert outline[0].attrib == {"x": "60.0", "y": "130.0", "width": "240.0", "height": "90.0"}


def test_numbers_of_a_narrow_axis_do_not_run_into_each_other() -> None:
    panel = Panel(Scale(-8.0, 120.0, 200.0, 350.0), Scale(0.0, 1.0, 100.0, 10.0))
    panel.frame(x_ticks=8)
    root = ElementTree.fromstring(picture("one", 500.0, 140.0, [panel], "a narrow axis"))
    numbers = [text for text in root.iter(f"{SVG}text") if text.get("class") == "tick middle"]
    places = [float(text.attrib["x"]) for text in numbers]
    assert len(places) >= 2 and min(np.diff(places)) > 30.0


def test_a_text_that_runs_out_of_its_picture_is_found() -> None:
    panel = Panel(Scale(0.0, 1.0, 200.0, 300.0), Scale(0.0, 1.0, 100.0, 10.0))
    panel.frame("share", "height")
    assert cut_off(picture("one", 320.0, 140.0, [panel], "short")) == []
    panel.frame("a label that is much too long for it", "and one more, upright")
    assert len(cut_off(picture("one", 320.0, 140.0, [panel], "long"))) == 2
