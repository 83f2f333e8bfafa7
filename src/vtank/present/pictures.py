"""The pictures of the report that show sizes: the gap of every run, and how far it shrinks on runs left out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..diagnose.localise.gap import RunGap
from . import words
from .svg import Panel, Scale, picture

WIDTH = 920.0  # [px] of every picture, before the page scales it
LEFT = 170.0  # [px] for the runs' names
ROW = 34.0  # [px] of a run
SIMULATORS = ("nominal", "refit", "diagnosed")
BARS = Scale(3.0, 0.0, 122.0, 14.0)  # three rows of a picture of bars
CALLED = words.WORDS["called"]


def in_thousandths(sizes: Sequence[float], unit: str) -> tuple[float, str]:
    """Factor and unit in which the sizes are shown: mm for m where all are below 0.5 m."""
    shown = unit.replace("s2", "s²")
    return (1e3, f"m{shown}") if max((abs(s) for s in sizes), default=1.0) < 0.5 else (1.0, shown)


def gap_picture(gaps: Sequence[RunGap], simulators: Sequence[str] = SIMULATORS) -> str:
    """Error of the simulators in every run, and the noise floor."""
    sizes = [gap.rms(s) for gap in gaps for s in simulators]
    factor, unit = in_thousandths(sizes, gaps[0].unit)
    height = 62.0 + ROW * len(gaps)
    panel = Panel(
        Scale(0.0, 1.06 * factor * max(sizes), LEFT, WIDTH - 20.0), Scale(len(gaps), 0.0, height - 48.0, 10.0)
    )
    panel.frame(f"root mean square of measured less simulated [{unit}]", x_ticks=8, y_ticks=0)
    said = []
    for k, gap in enumerate(gaps):
        values = {s: factor * gap.rms(s) for s in simulators}
        floor = factor * gap.floor
        y = k + 0.5
        panel.box(0.0, floor, y - 0.32, y + 0.32, "floor", f"{gap.run}, noise floor: {words.number(floor)} {unit}")
        panel.line(np.array([min(values.values()), max(values.values())]), np.array([y, y]), "nominal")
        for name, value in values.items():
            panel.dot(value, y, name, f"{gap.run}, {CALLED[name]}: {words.number(value)} {unit}", 6.0)
        panel.text(LEFT - 12.0, panel.y(y) + 4.5, shortened(gap.run), "end")
        listed = ", ".join(f"{CALLED[s]} {words.number(v)} {unit}" for s, v in values.items())
        said.append(f"{gap.run}: {listed}, floor {words.number(floor)} {unit}")
    return picture("gap", WIDTH, height, [panel], f"Error of each run. {'; '.join(said)}.")


def shortened(name: str, most: int = 22) -> str:
    """A run's name that fits beside a picture."""
    return name if len(name) <= most else f"{name[: most - 1]}\N{HORIZONTAL ELLIPSIS}"


def shrink_picture(document: dict[str, Any]) -> str:
    """Error on runs left out, before and after, and the share of the gap that is closed with its interval."""
    shrink = document["shrink"]
    sizes = {s: float(shrink[s]) for s in words.simulators(document)}
    factor, unit = in_thousandths(list(sizes.values()), shrink["unit"])
    whole = shrink.get("fraction_closed") is None
    panel = Panel(Scale(0.0, 1.2 * factor * max(sizes.values()), LEFT, WIDTH - 20.0 if whole else 540.0), BARS)
    panel.frame(f"error on {words.left_out(document)} [{unit}]", y_ticks=0)
    panel.box(0.0, factor * float(shrink["floor"]), 0.0, 3.0, "floor", "noise floor")
    for k, (name, size) in enumerate(sizes.items()):
        y = k + 0.5
        panel.box(0.0, factor * size, y - 0.24, y + 0.24, name)
        panel.text(LEFT - 12.0, panel.y(y) + 4.5, f"simulator {CALLED[name]}", "end")
        panel.text(panel.x(factor * size) + 7.0, panel.y(y) + 4.5, f"{words.number(factor * size)} {unit}", "small")
    panels = [panel] if whole else [panel, closed_panel(shrink)]
    return picture("shrink", WIDTH, 170.0, panels, words.shrinkage(document))


def closed_panel(shrink: dict[str, Any]) -> Panel:
    """Share of the reducible gap that the diagnosis closes, with its interval."""
    share = 100.0 * float(shrink["fraction_closed"])
    low, high = (100.0 * float(v) for v in shrink.get("interval90") or (share / 100.0, share / 100.0))
    panel = Panel(Scale(min(0.0, low, share), max(100.0, high, share), 610.0, WIDTH - 30.0), BARS)
    panel.frame("gap closed [%], 90 % interval", y_ticks=0)
    panel.line(np.array([low, high]), np.array([1.5, 1.5]), "diagnosed thick")
    panel.dot(share, 1.5, "diagnosed", f"{share:.0f} %", 7.0)
    panel.text(panel.x(share), panel.y(1.5) - 16.0, f"{share:.0f} %", "title middle")
    return panel
