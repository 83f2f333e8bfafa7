"""Figures of the response and of station keeping; the one module of this package that loads matplotlib."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...experiment import Plan
from .bounds import drift_bound_m, thrust_bound_m
from .loop import Complex
from .response import HALF_POWER, TAKEN_OVER, Response, unwrapped
from .station import DEPTH_SHARE, ERROR_M, Stations

INK, GREY, PALE, BAND = "#1c2529", "#7d8a91", "#c9d1d5", "#f3efe3"
PAPER_RAD_S = (0.2, 0.7)  # [rad/s] the paper's experiments
DPI = 130
STYLE = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e6eaec",
    "grid.linewidth": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.titlesize": 11.0,
    "figure.titleweight": "bold",
}


def response_figure(measured: Response, linear: Complex, balanced: Complex, subject: str) -> bytes:
    """Gain, phase and use of the propellers over frequency as PNG.

    linear: shape (W,), NaN where the linear loop is unstable; balanced: shape (A, W).
    """
    from matplotlib import colormaps, rc_context

    with rc_context(STYLE):
        figure, (gain, phase, use) = _page(
            f"Surge position against its command\n{subject}", (7.4, 8.2), 3, (3, 2.2, 1.6)
        )
        w = measured.rad_s
        colours = colormaps["viridis"](np.linspace(0.0, 0.85, measured.amplitude_m.size))
        (straight,) = gain.loglog(w, np.abs(linear), color=INK, lw=1.2, ls=(0, (5, 2)))
        phase.semilogx(w, np.degrees(unwrapped(linear[None])[0]), color=INK, lw=1.2, ls=(0, (5, 2)))
        for i, colour in enumerate(colours):
            label = f"{measured.amplitude_m[i]:g} m, tank"
            gain.loglog(w, np.abs(balanced[i]), color=colour, lw=1.1)
            gain.loglog(w, measured.gain[i], color=colour, ls="", marker="o", ms=4.5, label=label)
            phase.semilogx(w, np.degrees(unwrapped(balanced[i : i + 1])[0]), color=colour, lw=1.1)
            phase.semilogx(w, np.degrees(measured.phase_rad[i]), color=colour, ls="", marker="o", ms=4.5)
            use.semilogx(w, 100.0 * measured.at_limit[i], color=colour, lw=1.1, marker="o", ms=3.5)
        gain.axhline(HALF_POWER, color=GREY, lw=0.9, ls=":")
        gain.text(w[0], HALF_POWER, "-3 dB", color=GREY, va="bottom", fontsize=8)
        gain.set(ylabel="gain", ylim=(max(0.05, 0.8 * np.nanmin(measured.gain)), 2.5))
        gain.set_yticks([0.1, 0.2, 0.5, 1.0, 2.0], ["0.1", "0.2", "0.5", "1", "2"])
        gain.set_yticks([], minor=True)
        linear_label = "linear model" if np.isfinite(linear).any() else "linear model: unstable, not drawn"
        (curved,) = gain.plot([], [], color=GREY, lw=1.1)
        handles, labels = gain.get_legend_handles_labels()
        gain.legend([*handles, curved, straight], [*labels, "harmonic balance", linear_label], loc="lower left")
        phase.set(ylabel="phase [deg]", yticks=np.arange(-180.0, 1.0, 45.0))
        use.axhline(100.0 * TAKEN_OVER, color=GREY, lw=0.9, ls=":")
        use.set(ylabel="time at the limit of n [%]", xlabel="frequency [rad/s]", ylim=(-3.0, 103.0))
        for axes in (gain, phase, use):
            axes.axvspan(*PAPER_RAD_S, color=BAND, zorder=0, lw=0)
            axes.set_xlim(0.95 * w[0], 1.05 * w[-1])
            axes.set_xticks([0.05, 0.1, 0.2, 0.5, 1.0, 2.0], ["0.05", "0.1", "0.2", "0.5", "1", "2"])
            axes.set_xticks([], minor=True)
        gain.text(PAPER_RAD_S[0] * 1.03, 2.25, "the paper's band", color=GREY, va="top", fontsize=8)
        return _png(figure)


def station_figure(seas: Sequence[Stations], plan: Plan, subject: str) -> bytes:
    """Error over period and height for each kind of sea and water depth as PNG, with the limits of what is held."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE | {"axes.grid": False}):
        depths = seas[0].water_depth_m
        figure = Figure(figsize=(2.9 * depths.size + 1.5, 3.0 * len(seas) + 1.2), layout="constrained")
        figure.suptitle(
            f"Station keeping in waves, held below both coloured lines\n{subject}", x=0.01, ha="left", color=INK
        )
        panels = figure.subplots(len(seas), depths.size, sharex=True, sharey=True, squeeze=False)
        mesh: Any = None
        for row, sea in zip(panels, seas, strict=True):
            for d, axes in enumerate(row):
                mesh = _sea(axes, sea, d)
                _bounds(axes, sea, d, plan)
                depth = sea.water_depth_m[d]
                axes.set_title(f"{sea.kind}, water {depth:g} m, vehicle at {DEPTH_SHARE * depth:g} m")
            row[0].set_ylabel("significant height [m]" if sea.kind == "irregular" else "height [m]")
        for axes in panels[-1]:
            axes.set_xlabel("peak period [s]" if seas[-1].kind == "irregular" else "period [s]")
        bar = figure.colorbar(mesh, ax=panels, shrink=0.8, pad=0.01)
        bar.set_label("error passed 5 % of the time [m]")
        handles, labels = panels[0][0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower left", ncols=2)
        return _png(figure)


def _sea(axes: Any, sea: Stations, d: int) -> Any:
    """Colours of the error, and the lines up to which error and propellers stay within bounds."""
    from matplotlib.patheffects import withStroke

    error, share = sea.most_m[d], sea.at_limit[d]
    x, y = sea.period_s, sea.height_m
    mesh = axes.pcolormesh(x, y, error, cmap="YlGnBu", vmin=0.0, vmax=2.0 * ERROR_M, shading="nearest", rasterized=True)
    for i, height in enumerate(y):
        for j, period in enumerate(x):
            if np.isfinite(error[i, j]):
                dark = error[i, j] > 1.2 * ERROR_M
                ink, halo = ("white", "#12306b") if dark else (INK, "#f4f9e4")
                stroke = [withStroke(linewidth=1.6, foreground=halo)]
                text = f"{error[i, j]:.2f}"
                axes.text(
                    period,
                    height,
                    text,
                    ha="center",
                    va="center",
                    fontsize=6.5,
                    color=ink,
                    zorder=6,
                    path_effects=stroke,
                )
    _contour(axes, x, y, error, ERROR_M, "#d55e00", f"error {ERROR_M:g} m for 5 % of the time")
    _contour(axes, x, y, share, TAKEN_OVER, "#7a2a8c", "propellers at their limit for 5 % of the time")
    axes.set(yscale="log", xscale="log", ylim=(0.85 * y[0], 1.15 * y[-1]), xlim=(0.87 * x[0], 1.15 * x[-1]))
    axes.set_xticks(x, [f"{value:g}" for value in x])
    axes.set_yticks(y, [f"{value:g}" for value in y])
    axes.set_xticks([], minor=True)
    axes.set_yticks([], minor=True)
    return mesh


def _contour(axes: Any, x: Any, y: Any, value: Any, level: float, colour: str, label: str) -> None:
    shown = np.ma.masked_invalid(value)
    if shown.count() and shown.min() < level < shown.max():
        axes.contour(x, y, shown, levels=[level], colors=[colour], linewidths=1.8)
    axes.plot([], [], color=colour, lw=1.8, label=label)


def _bounds(axes: Any, sea: Stations, d: int, plan: Plan) -> None:
    """For regular waves, what theory says without a simulation."""
    styles = {"color": INK, "lw": 1.0}
    if sea.kind == "regular":
        water, period = float(sea.water_depth_m[d]), np.geomspace(sea.period_s[0], sea.period_s[-1], 60)
        place = (water, DEPTH_SHARE * water)
        still = [thrust_bound_m(plan, float(t), *place) for t in period]
        drift = [drift_bound_m(ERROR_M, float(t), *place) for t in period]
        axes.plot(period, still, ls=(0, (5, 2)), **styles)
        axes.plot(period, drift, ls=(0, (1, 1.5)), **styles)
    axes.plot([], [], ls=(0, (5, 2)), label="theory: a hull kept quite still takes all of n (regular waves)", **styles)
    axes.plot([], [], ls=(0, (1, 1.5)), label=f"theory: the water itself moves {ERROR_M:g} m (regular waves)", **styles)


def _page(title: str, size: tuple[float, float], rows: int, heights: Sequence[float]) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    figure.suptitle(title, x=0.01, ha="left", color=INK)
    return figure, figure.subplots(rows, 1, sharex=True, height_ratios=heights)


def _png(figure: Any) -> bytes:
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DPI, metadata={"Software": None})
    return file.getvalue()
