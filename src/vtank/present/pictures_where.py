"""The pictures of where: residual over time, spectrum with coherence, residual force over motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..diagnose.localise.frequency import Spectrum
from ..diagnose.localise.gap import RunGap
from ..diagnose.localise.region import Profile
from ..diagnose.localise.time import Windows
from . import words
from .pictures import WIDTH, in_thousandths, shortened
from .svg import Panel, Scale, around, picture

LEFT = 66.0  # [px] for the labels of the vertical axis
MOST_RUNS = 6  # runs shown over time, those with the largest share
MOST_SPECTRA = 4  # runs whose spectrum is shown
SMOOTH_S = 2.0  # [s] over which the strong lines are averaged, so that they stand out of the noise
STRIP = 96.0  # [px] height of a run over time
PITCH = 140.0  # [px] from one run to the next


def shown(gaps: Sequence[RunGap], most: int) -> list[int]:
    """Indices of the runs with the largest shares, in their own order."""
    return sorted(sorted(range(len(gaps)), key=lambda k: -gaps[k].share)[:most])


def time_picture(gaps: Sequence[RunGap], windows: Sequence[Windows], pair: tuple[str, str]) -> str:
    """Measured less simulated over time, before and after, with the windows in which the difference is significant."""
    chosen = shown(gaps, MOST_RUNS)
    errors = [gaps[k].error[s][gaps[k].counts["diagnosed"]] for k in chosen for s in pair]
    factor, unit = in_thousandths([float(np.max(np.abs(e))) for e in errors], gaps[0].unit)
    panels, said = [], []
    for row, k in enumerate(chosen):
        gap, window = gaps[k], windows[k]
        keep, top = gap.counts["diagnosed"], 26.0 + PITCH * row
        curves = {s: factor * gap.error[s][keep] for s in pair}
        floor = 2.0 * factor * gap.floor
        low, high = around(np.concatenate([*curves.values(), [-floor, floor]]))
        time = gap.time_s[keep]
        panel = Panel(Scale(time[0], time[-1], LEFT, WIDTH - 14.0), Scale(low, high, top + STRIP, top))
        for w in np.flatnonzero(window.significant):
            panel.box(window.edges_s[w], window.edges_s[w + 1], low, high, "mark")
        panel.box(time[0], time[-1], -floor, floor, "floor")
        last = row == len(chosen) - 1
        panel.frame("time [s]" if last else "", f"error [{unit}]", shortened(gap.run, 60), 12, 4)
        for simulator, curve in curves.items():
            panel.line(time, curve, f"{simulator} pale")
        for simulator, curve in curves.items():
            panel.line(time, smoothed(time, curve), simulator)
        panels.append(panel)
        said.append(f"{gap.run}: {int(window.significant.sum())} of {window.gain.size}")
    alt = f"Measured less simulated over time. Windows with a significant difference: {'; '.join(said)}."
    return picture("time", WIDTH, 26.0 + PITCH * len(chosen) + 6.0, panels, alt)


def smoothed(time_s: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Mean over SMOOTH_S about each stamp, shape (M,); shorter at the ends."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    first = np.searchsorted(time_s, time_s - 0.5 * SMOOTH_S)
    last = np.searchsorted(time_s, time_s + 0.5 * SMOOTH_S, side="right")
    mean: np.ndarray = (total[last] - total[first]) / (last - first)
    return mean


def spectrum_picture(gaps: Sequence[RunGap], spectra: Sequence[Spectrum]) -> str:
    """Spectrum of what the refit cannot predict, its significant lines, and the coherence with the input."""
    chosen = shown(gaps, MOST_SPECTRA)
    columns = 1 if len(chosen) == 1 else 2
    wide = (WIDTH - 14.0 - columns * LEFT - (columns - 1) * 24.0) / columns
    panels: list[Panel] = []
    for place, k in enumerate(chosen):
        left = LEFT + (place % columns) * (wide + LEFT + 24.0)
        top = 28.0 + 330.0 * (place // columns)
        panels += spectrum_panels(spectra[k], left, left + wide, top)
    lines = [line for k in chosen for line in spectra[k].lines]
    said = "; ".join(f"{line.run} {words.number(line.frequency_rad_s)} rad/s" for line in lines) or "none"
    height = 28.0 + 330.0 * ((len(chosen) - 1) // columns + 1) - 14.0
    return picture("spectrum", WIDTH, height, panels, f"Spectrum of what the refit cannot predict. Lines: {said}.")


def spectrum_panels(s: Spectrum, left: float, right: float, top: float) -> list[Panel]:
    """Power above, coherence below."""
    x = Scale(float(s.frequency_rad_s[0]), float(s.frequency_rad_s[-1]), left, right, log=True)
    most = max(float(np.max(s.power)), float(np.max(s.significant)))
    power = Panel(x, Scale(0.1, 4.0 * most, top + 170.0, top, log=True))
    power.frame("", "power over noise [-]", shortened(s.run, 40))
    if s.drive_rad_s > 0.0:
        power.vertical(s.drive_rad_s, "drive")
    power.line(s.frequency_rad_s, np.maximum(s.power, 0.1), "refit")
    power.line(s.frequency_rad_s, s.significant, "level")
    for line in s.lines:
        note = f"{words.number(line.frequency_rad_s)} rad/s, {words.number(line.power)} times the noise"
        power.dot(line.frequency_rad_s, line.power, "refit", note)
        multiple = f" ({line.multiple}\N{MULTIPLICATION SIGN})" if line.multiple and line.multiple > 1 else ""
        power.text(
            x(line.frequency_rad_s) + 7.0, power.y(line.power) - 3.0, f"{line.frequency_rad_s:.2f}{multiple}", "small"
        )
    shared = Panel(x, Scale(0.0, 1.0, top + 262.0, top + 196.0))
    shared.frame("frequency [rad/s]", "coherence", y_ticks=2)
    if s.drive_rad_s > 0.0:
        shared.vertical(s.drive_rad_s, "drive")
    shared.line(s.frequency_rad_s, s.coherence, "ink thin")
    shared.horizontal(s.coherent, "level")
    return [power, shared]


def force_picture(profiles: Sequence[Profile]) -> str:
    """Acceleration that the refit lacks over input, speed and place, with bands; and what the diagnosis leaves."""
    gap = 50.0
    wide = (WIDTH - 14.0 - LEFT - (len(profiles) - 1) * gap) / len(profiles)
    sure = [(p.force[k], p.half_width[k]) for p in profiles for k in range(p.force.size)]
    usual = 3.0 * float(np.median([h for _, h in sure]))
    ends = [f + sign * min(h, usual) for f, h in sure for sign in (-1.0, 1.0)]
    factor, unit = in_thousandths(ends, "m/s2")
    y = Scale(*around([factor * e for e in [*ends, 0.0]]), 262.0, 24.0)
    panels, said = [], []
    for k, p in enumerate(profiles):
        left = LEFT + k * (wide + gap)
        panel = Panel(Scale(float(p.edges[0]), float(p.edges[-1]), left, left + wide), y)
        force_panel(panel, p, factor, unit, f"missing acceleration [{unit}]" if k == 0 else "")
        panels.append(panel)
        said.append(f"{words.WORDS['quantity'][p.name][2]}: {int(p.significant.sum())} of {p.force.size} bins")
    alt = f"Acceleration that the refit lacks. Bins whose band excludes zero: {'; '.join(said)}."
    return picture("force", WIDTH, 310.0, panels, alt)


def force_panel(panel: Panel, p: Profile, factor: float, unit: str, label: str) -> None:
    """One variable: a band and a line for every bin."""
    panel.frame(words.WORDS["quantity"][p.name][2], label, x_ticks=4, y_ticks=5)
    for b in range(p.force.size):
        low, high = p.edges[b], p.edges[b + 1]
        f, h, rest = factor * p.force[b], factor * p.half_width[b], factor * p.left[b]
        size = f"{words.number(f)} \N{PLUS-MINUS SIGN} {words.number(h)} {unit}"
        note = f"{words.number(low)} to {words.number(high)}: {size}"
        bottom, top = (min(max(v, panel.y.low), panel.y.high) for v in (f - h, f + h))
        panel.box(low, high, bottom, top, "band found" if p.significant[b] else "band", note)
        for value, style in ((f, "refit thick"), (rest, "diagnosed")):
            if panel.y.low <= value <= panel.y.high:
                panel.line(np.array([low, high]), np.array([value, value]), style)
    panel.horizontal(0.0, "zero")


def pair_of(document: words.Document) -> tuple[str, str]:
    """The two simulators whose errors are compared over time."""
    shown = words.simulators(document)
    return (shown[0], shown[1]) if document["verdict"]["kind"] in ("none", "parameters") else (shown[-2], shown[-1])
