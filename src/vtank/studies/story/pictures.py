"""The pictures of the story: a recording and simulators of it over time, and a film of both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import vtank as vt

from ...present import Film
from ...present.svg import Panel, Scale, around, picture

WIDTH, LEFT, RIGHT = 500.0, 62.0, 490.0  # [px] of the picture, which a telephone shows whole, and of its axes
TRACE, ERROR, TOP, BETWEEN = 150.0, 80.0, 12.0, 16.0  # [px] heights of both panels, above them and between them
DOTS = 120  # measurements shown
SIZE, LONGEST_S = (720, 480), 4.0  # [px], [s] of a film: rendered in a few seconds without a graphics card; choices


def overlay(name: str, seen: Any, simulators: Mapping[str, Any]) -> tuple[str, float]:
    """A recording's distance ahead as dots, each simulator's as a line of its style, the errors below; the largest [m].

    seen: a view with the recording as its ghost. simulators: style -> poses.
    """
    time_s, measured = seen.ghost.time_s, seen.ghost.place_m[:, 0]
    ways = {style: np.interp(time_s, poses.time_s, poses.place_m[:, 0]) for style, poses in simulators.items()}
    errors = {style: measured - way for style, way in ways.items()}
    x, below = Scale(time_s[0], time_s[-1], LEFT, RIGHT), TOP + TRACE + BETWEEN
    trace = Panel(x, Scale(*around(np.concatenate([measured, *ways.values()])), TOP + TRACE, TOP))
    trace.frame("", "distance ahead [m]", "", 0, 4)
    error = Panel(x, Scale(*around(np.concatenate([*errors.values()])), below + ERROR, below))
    error.frame("time [s]", "error [m]", "", 6, 3)
    error.horizontal(0.0, "zero")
    for k in range(0, time_s.size, max(1, time_s.size // DOTS)):
        trace.dot(time_s[k], measured[k], "ink", radius=2.6)
    for style, way in ways.items():
        trace.line(time_s, way, style)
        error.line(time_s, errors[style], style)
    worst = {style: float(np.abs(e).max()) for style, e in errors.items()}
    said = "; ".join(f"{style}: up to {size:.3g} m off" for style, size in worst.items())
    svg = picture(name, WIDTH, below + ERROR + 42.0, [trace, error], f"Recording and simulator over time. {said}.")
    return svg, max(worst.values())


@dataclass(frozen=True)
class Filmed:
    """What became of a film: the film, or a sentence that says why there is none."""

    text: str
    blocks: tuple[Film, ...] = ()


def filmed(seen: Any, folder: Path, name: str, caption: str) -> Filmed:
    """Film a view into a file of a folder; where that cannot be, the sentence says why."""
    try:
        how = seen.film(folder / name, SIZE, LONGEST_S)
    except vt.InputError as reason:
        return Filmed(f"No film: {reason}.")
    return Filmed("", (Film(name, f"{caption}; {how}."),))
