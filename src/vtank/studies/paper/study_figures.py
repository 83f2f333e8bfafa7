"""Figures of the study: estimates beside truths and print, factor by factor and part by part."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ...present.canvas import PUBLISHED, TRUTH_COLOURS, VERMILION, drawn, legend_below, page
from .evidence import Results
from .paper_figures import NAMES
from .published import SETS, brutzman_a_per_ft, published
from .study import QUANTITIES, STEPS_S, Level, Study

Place = tuple[Level, int | None, int | None]  # level, data set, T; None: all

TITLES = {
    "kalman": "Kalman, printed q_ii = 1",
    "two_stage": "two-stage, printed q_ii",
    "least_squares": "least squares",
    "literal": "Kalman, q_ii in the print's units",
    "normalised": "Kalman, q_ii normalised",
}
FACTOR_TITLES = {
    "filter q": "sonar filter's q [ft²/s⁵]",
    "filter on n": "filter also on n",
    "record": "length of record",
    "noise": "sonar noise [mm]",
    "amplitude": "amplitude of the command",
    "spikes": "tachometer spikes of 8 rev/s",
}
COLUMNS = (  # factor, label, method, table beside it
    ("method", "kalman", "kalman", 2),
    ("method", "two_stage", "two_stage", 4),
    ("method", "least_squares", "least_squares", 2),
    ("Model III", "q_ii = 3", "kalman", 3),
)
ROWS = ("a", "b", "tau", "gamma")
LIMITS = {"a": (-3.4, 1.4), "b": (-0.004, 0.010), "tau": (-0.4, 4.2), "gamma": (-0.21, 0.09)}
LIMITS_III = LIMITS | {"b": (-0.045, 0.065), "tau": (-1.0, 16.0)}
PART_TITLES = {
    "exact": "time step\nalone",
    "filter u": "filter\non u",
    "filter u,n": "filter on\nu and n",
    "noise": "noise\nin u",
    "recorded": "all, as\nrecorded",
}


@drawn
def truths_and_print(r: Results) -> Any:
    """What each estimator makes of three vehicles, beside what was published."""
    s = r.study
    figure = page("The paper's estimators on three vehicles, T unknown, beside the published values", 12.5, 8.4)
    grid = figure.subplots(len(ROWS), len(COLUMNS), squeeze=False)
    for j, (factor, label, method, number) in enumerate(COLUMNS):
        level = s.level(factor, label, method)
        name = TITLES[method] if level.model == "II" else "Kalman, printed q_ii = 3"
        grid[0, j].set_title(f"{name}\nModel {level.model}, beside Table {number}")
        for ax, quantity in zip(grid[:, j], ROWS, strict=True):
            if quantity == "gamma" and level.model == "II":
                ax.set_axis_off()
                continue
            _truths(ax, s, [(level, d, None) for d in range(SETS)], quantity)
            ax.plot(range(SETS), published()[number].values[quantity], "x", color=VERMILION, ms=8, mew=2, zorder=5)
            ax.set(ylim=(LIMITS_III if level.model == "III" else LIMITS)[quantity])
            ax.set_ylabel(NAMES[quantity] if j in (0, 3) else "")
            ax.set_xticks(range(SETS), [f"set {k + 1}" for k in range(SETS)])
    grid[0, 0].plot([], [], "x", color=VERMILION, ms=8, mew=2, label="published")
    _legend_in(grid[-1, 0], grid[0, 0])
    return figure


@drawn
def factors(r: Results, method: str) -> Any:
    """The estimate of a, all data sets together, as one thing after another varies."""
    s = r.study
    panels = [("Q", group) for group in ("literal", "normalised")] if method == "kalman" else []
    panels += [("T", method), *((name, method) for name in FACTOR_TITLES if name in s.factors)]
    figure = page(f"Drag estimated by {TITLES[method]} (Model II, data sets 1 to 4 together, T unknown)", 12.5, 7.0)
    grid = figure.subplots(2, -(-len(panels) // 2), sharey=True, squeeze=False)
    for ax, (factor, group) in zip(grid.flat, panels, strict=False):
        chosen = [level for level in s.levels if (level.factor, level.method) == (factor, group)]
        _published_band(ax)
        places: list[Place] = [(level, None, None) for level in chosen]
        if factor == "T":
            places = [(s.level("method", method, method), None, k) for k in range(len(STEPS_S))]
        _truths(ax, s, places, "a")
        labels = [f"{step:g}" for step in STEPS_S] if factor == "T" else [level.label for level in chosen]
        ax.set_xticks(range(len(labels)), [label.removesuffix(" mm") for label in labels])
        ax.set(title=(FACTOR_TITLES | TITLES).get(group if factor == "Q" else factor, "T [s]"), ylim=(-4.0, 1.6))
    for ax in grid.flat[len(panels) :]:
        ax.set_axis_off()
    for ax in grid[:, 0]:
        ax.set_ylabel("a [1/ft]")
    _multiples(grid[0, -1])
    _legend_in(grid[-1, -1], grid[0, 0])
    return figure


@drawn
def parts(r: Results) -> Any:
    """Where the error comes from: time step, filter, noise, all together."""
    s = r.study
    figure = page("Where the error of the drag comes from (Model II, T unknown)", 12.5, 6.4)
    grid = figure.subplots(2, SETS, sharex=True, squeeze=False)
    for row, method, limits in ((grid[0], "least_squares", (-2.0, 1.0)), (grid[1], "kalman", (-4.0, 1.6))):
        chosen = [level for level in s.levels if (level.factor, level.method) == ("part", method)]
        for data_set, ax in enumerate(row):
            _truths(ax, s, [(level, data_set, None) for level in chosen], "a")
            ax.axhline(published()[2].values["a"][data_set], **PUBLISHED)
            ax.set(title=f"{TITLES[method]}, data set {data_set + 1}", ylim=limits)
            ax.set_xticks(range(len(chosen)), [PART_TITLES[level.label] for level in chosen], fontsize=8)
        row[0].set_ylabel("a [1/ft]")
    legend_below(figure, [grid[0, 0]], 4)
    return figure


def _truths(ax: Any, s: Study, places: list[Place], quantity: str) -> None:
    """One place on the axis for each level, data set and T; there, in one colour a truth, median and 10-90 % band."""
    for k, truth in enumerate(s.truths):
        colour, x = TRUTH_COLOURS[truth], np.arange(len(places)) + 0.22 * (k - 1)
        low, middle, high = np.array(
            [s.band(truth, level, quantity, data_set, step) for level, data_set, step in places]
        ).T
        ax.vlines(x, low, high, color=colour, lw=2.6, alpha=0.45)
        ax.plot(x, middle, "o", color=colour, ms=4, label=f"truth {truth}: median and\n10-90 %; dashed: its value")
        ax.axhline(s.truths[truth][QUANTITIES.index(quantity)], color=colour, lw=0.9, ls=(0, (5, 2)))
    ax.grid(axis="x", visible=False)


def _legend_in(empty: Any, ax: Any) -> None:
    """The legend of one panel in the room of an empty one, where it widens nothing."""
    legend = empty.legend(*ax.get_legend_handles_labels(), loc="upper left", borderaxespad=0.0, labelspacing=1.0)
    legend.set_in_layout(False)


def _published_band(ax: Any) -> None:
    a = published()[2].values["a"]
    ax.axhspan(a.min(), a.max(), color=VERMILION, alpha=0.13, lw=0, label="published, Table 2")


def _multiples(ax: Any) -> None:
    """A second axis in multiples of Brutzman's drag."""
    brutzman = brutzman_a_per_ft()
    axis = ax.secondary_yaxis("right", functions=(lambda a: a / brutzman, lambda multiple: multiple * brutzman))
    axis.set_ylabel("times Brutzman's drag")


STUDY_PICTURES: dict[str, tuple[str, Callable[..., bytes]]] = {  # file name without suffix -> caption, drawing
    "study-truths": ("Three vehicles through the paper's estimators, beside the published values.", truths_and_print),
    "study-parts": ("Time step, sonar filter and noise, each by itself and together.", parts),
    "study-kalman": (
        "The printed Kalman estimator as Q, T, filter and experiment vary.",
        partial(factors, method="kalman"),
    ),
    "study-least-squares": (
        "Least squares, which a settling Q amounts to, as T, filter and experiment vary.",
        partial(factors, method="least_squares"),
    ),
}
