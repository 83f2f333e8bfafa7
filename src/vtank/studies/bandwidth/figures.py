"""Figures of the response and of station keeping."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...experiment import Plan
from ...present.canvas import GREY, INK, VERMILION, drawn, halo, legend_below, page, shades, ticks
from .bounds import drift_bound_m, thrust_bound_m
from .loop import Complex
from .response import HALF_POWER, TAKEN_OVER, Response, unwrapped
from .station import DEPTH_SHARE, ERROR_M, Stations

BAND = "#f3efe3"  # ground of the paper's band
PAPER_RAD_S = (0.2, 0.7)  # [rad/s] the paper's experiments


@drawn
def response_figure(measured: Response, linear: Complex, balanced: Complex, subject: str) -> Any:
    """Gain, phase and use of the propellers over frequency.

    linear: shape (W,), NaN where the linear loop is unstable; balanced: shape (A, W).
    """
    figure = page(f"Surge position against its command\n{subject}", 7.4, 8.2)
    gain, phase, use = figure.subplots(3, 1, sharex=True, height_ratios=(3, 2.2, 1.6))
    w, lowest = measured.rad_s, max(0.05, 0.8 * float(np.nanmin(measured.gain)))
    straight = {"color": INK, "lw": 1.2, "ls": (0, (5, 2))}
    for i, colour in enumerate(shades(measured.amplitude_m.size)):
        dots = {"color": colour, "ls": "", "marker": "o", "ms": 4.5}
        gain.loglog(w, np.abs(balanced[i]), color=colour, lw=1.1)
        gain.loglog(w, measured.gain[i], label=f"{measured.amplitude_m[i]:g} m, tank", **dots)
        phase.semilogx(w, np.degrees(unwrapped(balanced[i])), color=colour, lw=1.1)
        phase.semilogx(w, np.degrees(measured.phase_rad[i]), **dots)
        use.semilogx(w, 100.0 * measured.at_limit[i], color=colour, lw=1.1, marker="o", ms=3.5)
    gain.plot([], [], color=GREY, lw=1.1, label="harmonic balance")
    stable = np.isfinite(linear).any()
    gain.loglog(w, np.abs(linear), label=f"linear model{'' if stable else ': unstable, not drawn'}", **straight)
    phase.semilogx(w, np.degrees(unwrapped(linear)), **straight)
    gain.axhline(HALF_POWER, color=GREY, lw=0.9, ls=":")
    gain.text(w[0], HALF_POWER, "-3 dB", color=GREY, va="bottom", fontsize=8)
    gain.text(PAPER_RAD_S[0] * 1.03, 2.25, "the paper's band", color=GREY, va="top", fontsize=8)
    gain.set(ylabel="gain", ylim=(lowest, 2.5))
    ticks(gain.yaxis, (0.1, 0.2, 0.5, 1.0, 2.0))
    gain.legend(loc="lower left")
    phase.set(ylabel="phase [deg]", yticks=np.arange(-180.0, 1.0, 45.0))
    use.axhline(100.0 * TAKEN_OVER, color=GREY, lw=0.9, ls=":")
    use.set(ylabel="time at the limit of n [%]", xlabel="frequency [rad/s]", ylim=(-3.0, 103.0))
    for axes in (gain, phase, use):
        axes.axvspan(*PAPER_RAD_S, color=BAND, zorder=0, lw=0)
        axes.set_xlim(0.95 * w[0], 1.05 * w[-1])
        ticks(axes.xaxis, (0.05, 0.1, 0.2, 0.5, 1.0, 2.0))
    return figure


@drawn
def station_figure(seas: Sequence[Stations], plan: Plan, subject: str) -> Any:
    """Error over period and height for each kind of sea and water depth, with the limits of what is held."""
    depths = seas[0].water_depth_m
    title = f"Station keeping in waves, held below both coloured lines\n{subject}"
    figure = page(title, 2.9 * depths.size + 1.5, 3.0 * len(seas) + 1.2)
    panels = figure.subplots(len(seas), depths.size, sharex=True, sharey=True, squeeze=False)
    for row, sea in zip(panels, seas, strict=True):
        wave, time = ("significant height", "peak period") if sea.kind == "irregular" else ("height", "period")
        row[0].set_ylabel(f"{wave} [m]")
        for d, axes in enumerate(row):
            mesh = _sea(axes, sea, d)
            _bounds(axes, sea, d, plan)
            axes.set_title(f"{sea.kind}, water {depths[d]:g} m, vehicle at {DEPTH_SHARE * depths[d]:g} m")
            if sea is seas[-1]:
                axes.set_xlabel(f"{time} [s]")
    figure.colorbar(mesh, ax=panels, shrink=0.8, pad=0.01).set_label("error passed 5 % of the time [m]")
    legend_below(figure, panels.flat, 2)
    return figure


def _sea(axes: Any, sea: Stations, d: int) -> Any:
    """Colours of the error, and the lines up to which error and propellers stay within bounds."""
    error, x, y = sea.most_m[d], sea.period_s, sea.height_m
    mesh = axes.pcolormesh(x, y, error, cmap="YlGnBu", vmin=0.0, vmax=2.0 * ERROR_M, shading="nearest", rasterized=True)
    for i, j in np.argwhere(np.isfinite(error)):
        ink, rim = ("white", "#12306b") if error[i, j] > 1.2 * ERROR_M else (INK, "#f4f9e4")
        axes.text(x[j], y[i], f"{error[i, j]:.2f}", ha="center", va="center", fontsize=6.5, color=ink, zorder=6,
                  path_effects=halo(rim))  # fmt: skip
    _contour(axes, x, y, error, ERROR_M, VERMILION, f"error {ERROR_M:g} m for 5 % of the time")
    _contour(axes, x, y, sea.at_limit[d], TAKEN_OVER, "#7a2a8c", "propellers at their limit for 5 % of the time")
    axes.grid(visible=False)
    axes.set(yscale="log", xscale="log", ylim=(0.85 * y[0], 1.15 * y[-1]), xlim=(0.87 * x[0], 1.15 * x[-1]))
    ticks(axes.xaxis, x)
    ticks(axes.yaxis, y)
    return mesh


def _contour(axes: Any, x: Any, y: Any, value: Any, level: float, colour: str, label: str) -> None:
    shown = np.ma.masked_invalid(value)
    if shown.count() and shown.min() < level < shown.max():
        axes.contour(x, y, shown, levels=[level], colors=[colour], linewidths=1.8)
    axes.plot([], [], color=colour, lw=1.8, label=label)


def _bounds(axes: Any, sea: Stations, d: int, plan: Plan) -> None:
    """For regular waves, what theory says without a simulation."""
    still, drift = ({"color": INK, "lw": 1.0, "ls": (0, dashes)} for dashes in ((5, 2), (1, 1.5)))
    if sea.kind == "regular":
        water, period = float(sea.water_depth_m[d]), np.geomspace(sea.period_s[0], sea.period_s[-1], 60)
        place = (water, DEPTH_SHARE * water)
        axes.plot(period, [thrust_bound_m(plan, float(t), *place) for t in period], **still)
        axes.plot(period, [drift_bound_m(ERROR_M, float(t), *place) for t in period], **drift)
    axes.plot([], [], label="theory: a hull kept quite still takes all of n (regular waves)", **still)
    axes.plot([], [], label=f"theory: the water itself moves {ERROR_M:g} m (regular waves)", **drift)
