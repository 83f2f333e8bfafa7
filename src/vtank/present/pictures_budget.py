"""The pictures of the gap as a whole: what it is made of, and every run measured and simulated."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from typing import Any

import numpy as np

from ..diagnose.localise.gap import RunGap
from ..estimate.observed import POSITION, RANGE, SPEED
from . import words, words_budget
from .pictures import WIDTH, in_thousandths, shortened
from .svg import Panel, Scale, around, picture

NAMES, NUMBERS = 200.0, 150.0  # [px] for the lines' names and their sizes
ROW = 34.0  # [px] of a line
STYLES = {"parameters": "refit", "effect": "diagnosed", "repeatable": "found", "disturbance": "nominal"}
MEASURED = {RANGE: "range", POSITION: "position", SPEED: "speed"}
LEFT = 66.0  # [px] for the labels of the vertical axis
TRACE, ERROR, PITCH = 120.0, 60.0, 262.0  # [px] height of a run's trace and of its error, and from run to run


def budget_picture(lines: Sequence[dict[str, Any]], document: words.Document, width: float = WIDTH) -> str:
    """A waterfall: the shares that own parameters, effects and the rest take off the gap, with their intervals."""
    ends = 100.0 * (1.0 - np.array([0.0, *accumulate(line["share"] for line in lines)]))
    spans = [[start - 100.0 * v for v in line["interval90"]] for start, line in zip(ends, lines, strict=False)]
    inside = [min(max(v, -20.0), 120.0) for span in spans for v in span]  # no interval squeezes the rest
    low, high = min(0.0, *ends, *inside), max(100.0, *ends, *inside)
    height = 62.0 + ROW * len(lines)
    panel = Panel(Scale(low, high, NAMES, width - NUMBERS), Scale(len(lines), 0.0, height - 48.0, 10.0))
    panel.frame("share of the mean-square error left [%]", x_ticks=8, y_ticks=0)
    said = []
    for k, line in enumerate(lines):
        y, name = k + 0.5, words_budget.line_name(line, document)
        a, b = line["interval90"]
        size = f"{words_budget.share(line['share'])} ({words.whole(100.0 * a)} to {words.whole(100.0 * b)})"
        panel.box(ends[k], ends[k + 1], y - 0.3, y + 0.3, STYLES.get(line["kind"], "floor"), f"{name}: {size}")
        span = np.clip(spans[k], low, high)
        panel.line(span, np.array([y, y]), "ink")
        for end in span:
            panel.line(np.array([end, end]), np.array([y - 0.12, y + 0.12]), "ink")
        panel.text(NAMES - 12.0, panel.y(y) + 4.5, shortened(name, 26), "end")
        panel.text(width - NUMBERS + 12.0, panel.y(y) + 4.5, size, "small")
        said.append(f"{name} {size}")
    return picture("budget", width, height, [panel], f"What the gap is made of: {'; '.join(said)}.")


def runs_picture(gaps: Sequence[RunGap], before: str) -> str:
    """Every run measured and simulated, before and after, and the errors below."""
    panels, said = [], []
    for row, gap in enumerate(gaps):
        top = 26.0 + PITCH * row
        panels += run_panels(gap, before, top)
        sizes = [gap.rms(name) for name in (before, "diagnosed")]
        factor, unit = in_thousandths(sizes, gap.unit)
        said.append(f"{gap.run}: error {factor * sizes[0]:.3g} to {factor * sizes[1]:.3g} {unit}")
    alt = f"Measured and simulated over time, before and after the diagnosis. {'; '.join(said)}."
    return picture("runs", WIDTH, 26.0 + PITCH * len(gaps), panels, alt)


def run_panels(gap: RunGap, before: str, top: float) -> list[Panel]:
    """Traces above, errors below; a simulation that leaves the recording by far leaves the picture."""
    keep = gap.counts["diagnosed"]
    time, value = gap.time_s[keep], gap.value[keep]
    shown = {name: gap.error[name][keep] for name in (before, "diagnosed")}
    x = Scale(time[0], time[-1], LEFT, WIDTH - 14.0)
    trace = Panel(x, Scale(*around(np.concatenate([value, value - shown["diagnosed"]]), 0.1), top + TRACE, top))
    trace.frame("", f"{MEASURED[gap.kind]} [{gap.unit}]", shortened(gap.run, 60), 0, 4)
    factor, unit = in_thousandths([float(np.max(np.abs(e))) for e in shown.values()], gap.unit)
    below = top + TRACE + 14.0
    ends = around([factor * e for error in shown.values() for e in error])
    error = Panel(x, Scale(*ends, below + ERROR, below))
    error.frame("time [s]", f"error [{unit}]", "", 12, 3)
    error.horizontal(0.0, "zero")
    for t, v in zip(*(a[:: max(1, a.size // 120)] for a in (time, value)), strict=True):
        trace.dot(t, v, "ink", radius=2.2)
    for name, e in shown.items():
        trace.line(time, value - e, name)
        error.line(time, factor * e, name)
    return [trace, error]
