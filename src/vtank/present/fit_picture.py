"""How well identified models follow a run: measured and simulated, residuals, and the input below."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..estimate.comparison import Comparison
from ..estimate.observed import CHANNELS
from .canvas import BLUE, GREEN, GREY, INK, VERMILION, drawn, legend_below, page

COLOURS = {"I": VERMILION, "II": BLUE, "III": GREEN}
DASHES = {"I": "-", "II": "-", "III": (0, (4, 4))}  # Models II and III often lie on each other
LABELS = {"range_m": "range [m]", "position_m": "position [m]", "surge_m_s": "surge speed [m/s]"}
INPUTS = {"n_rev_s": "n [rev/s]", "command": "command [-]", "thrust_N": "thrust [N]"}


@drawn
def fit_picture(found: Sequence[Comparison], index: int) -> Any:
    """One run under all models: free runs from the input and the estimated start alone."""
    run = found[0].runs[index]
    channel = next(name for name, kind in CHANNELS.items() if kind in run.first)
    chosen = run.kind == CHANNELS[channel]
    time, value = run.time_s[chosen], run.value[chosen]
    figure = page(f"{run.name}: measured and simulated", 8.0, 5.6)
    top, middle, bottom = figure.subplots(3, 1, sharex=True, height_ratios=(3, 1.6, 1.2))
    top.plot(time, value, ".", ms=2.5, color=GREY, label="measured")
    middle.axhline(0.0, color=INK, lw=0.7)
    for c in found:
        residual = c.joint.free_runs()[index].innovation[chosen]
        label = f"Model {c.model}, rms {np.sqrt(np.mean(residual**2)):.3g}"
        top.plot(time, value - residual, color=COLOURS[c.model], ls=DASHES[c.model], label=label)
        middle.plot(time, residual, color=COLOURS[c.model], lw=0.8)
    bottom.plot(run.input_time_s, run.input, color=INK, lw=0.8, drawstyle="steps-post")
    top.set_ylabel(LABELS[channel])
    middle.set_ylabel("residual")
    bottom.set(ylabel=INPUTS[run.input_name], xlabel="time [s]")
    legend_below(figure, [top], 4)
    return figure
