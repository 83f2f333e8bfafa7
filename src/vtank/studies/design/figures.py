"""The page of a study as one picture."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...present import NAMES, canvas
from ...present.canvas import BLUE, CRIMSON, GREEN, GREY, INK, ORANGE, PALE, drawn, legend_below, ticks
from .bias import BiasMap
from .estimators import LIKELIHOOD, METHODS, TITLES
from .flown import Array
from .profile import Profile
from .study import Study
from .trials import Trials

COLOURS = dict(zip(METHODS, (BLUE, CRIMSON, ORANGE, GREEN), strict=True))
MARKS = dict(zip(METHODS, ("o", "s", "D", "^"), strict=True))
CHI2 = 5.9915  # 95 % of two normal variables together
LINEAR_PERCENT = 1.0  # [%] bias up to which its axis is linear, logarithmic beyond
BIASES = (-1000.0, -100.0, -10.0, -1.0, 0.0, 1.0, 10.0, 100.0, 1000.0)  # [%] ticks; bias beyond is drawn at the edge
ELLIPSES = 3  # pairs of parameters that are drawn, those that go together most


@drawn
def page(study: Study, trials: Trials | None, bias: BiasMap | None, profiles: Sequence[Profile]) -> Any:
    """Ellipses, profiles, coverage, bias against frequency and noise; what was not run is left out."""
    heights = [3.2, *([2.7] if trials else []), *([0.6 + 1.75 * len(bias.names)] if bias else [])]
    seeds = f", {trials.seeds} seeds" if trials else ""
    about = f"Model {study.model} from {', '.join(f.run.name for f in study.flown)}: truth {study.truth.name}{seeds}"
    figure = canvas.page(about, 11.0, 0.4 + sum(heights))
    bands = iter(figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0])
    _first_row(next(bands), study, trials, profiles)
    if trials:
        _coverage_row(next(bands), trials)
    if bias:
        _bias_rows(next(bands), bias)
    return figure


def _first_row(band: Any, study: Study, trials: Trials | None, profiles: Sequence[Profile]) -> None:
    together = sorted(itertools.combinations(range(len(study.free)), 2), key=lambda pair: -abs(study.correlation[pair]))
    pairs = together[:ELLIPSES]
    axes = band.subplots(1, len(pairs) + 1)
    for ax, (i, j) in zip(axes, pairs, strict=False):
        _ellipse(ax, study, trials, i, j)
    axes[0].set_title("Bound (95 %) and estimates by likelihood" if trials else "Cramer-Rao bound (95 %)")
    _profiles(axes[-1], profiles)
    if trials:
        legend_below(band, axes[:1])


def _ellipse(ax: Any, study: Study, trials: Trials | None, i: int, j: int) -> None:
    """Two parameters, errors in per cent of the truth."""
    x, y = (100.0 * e for e in outline(study.covariance, i, j))
    if trials is not None:
        error = 100.0 * (trials.found[LIKELIHOOD] - trials.true) / np.abs(trials.true)
        ax.plot(error[:, i], error[:, j], ls="", marker=".", ms=3.5, color=BLUE, alpha=0.6, label="estimates")
        sx, sy = (100.0 * e for e in outline(np.cov(error.T / 100.0), i, j))
        ax.plot(sx, sy, color=BLUE, lw=1.0, ls=(0, (4, 2)), label="their spread")
    ax.plot(x, y, color=INK, lw=1.6, label="bound")
    ax.plot(0.0, 0.0, ls="", marker="+", ms=9, color=INK)
    ax.set(xlabel=f"{NAMES[study.free[i]]}, error [%]", ylabel=f"{NAMES[study.free[j]]}, error [%]")


def outline(covariance: Array, i: int, j: int) -> tuple[Array, Array]:
    """Points of the 95 % ellipse of two parameters."""
    values, vectors = np.linalg.eigh(covariance[np.ix_([i, j], [i, j])])
    angle = np.linspace(0.0, 2.0 * np.pi, 120)
    circle = np.array([np.cos(angle), np.sin(angle)])
    x, y = (vectors * np.sqrt(np.maximum(CHI2 * values, 0.0))) @ circle
    return x, y


def _profiles(ax: Any, profiles: Sequence[Profile]) -> None:
    fine = np.linspace(-3.2, 3.2, 100)
    ax.plot(fine, fine**2, color=GREY, lw=4.0, alpha=0.35, label="normal")
    for profile, style in zip(profiles, ("-", (0, (5, 2)), (0, (1, 1.5)), "-."), strict=False):
        ax.plot(profile.deviations, profile.drop, color=INK, lw=1.2, ls=style, label=NAMES[profile.name])
    ax.axhline(3.84, color=PALE, lw=1.0)
    ax.text(-3.2, 3.95, "95 %", color=GREY, fontsize=7.5)
    ax.set(ylim=(0.0, 10.0), xlabel="off the truth [bound]", title="Profile likelihood, 2 x drop")
    ax.legend(loc="upper center", fontsize=7.5)


def _coverage_row(band: Any, trials: Trials) -> None:
    left, right = band.subplots(1, 2)
    for k, method in enumerate(METHODS):
        at = np.arange(len(trials.names)) + 0.2 * (k - 1.5)
        cover, ratio = 100.0 * trials.coverage(method), trials.spread_over_bound(method)
        for ax, value, least, above in ((left, cover, 0.6, cover + 1.5), (right, ratio, 0.55, 1.12 * ratio)):
            ax.bar(at, np.maximum(value, least), 0.18, color=COLOURS[method], label=TITLES[method])
            for x, v, height in zip(at, value, np.maximum(above, 1.12 * least), strict=True):
                text = f"{v:.2g}" if ax is right and v < 100 else f"{v:.0f}"
                ax.text(x, height, text, ha="center", fontsize=7.5, color=INK)
    half = 196.0 * np.sqrt(0.0475 / trials.seeds)
    left.axhspan(95.0 - half, min(95.0 + half, 100.0), color=PALE, alpha=0.6, zorder=0, lw=0)
    left.set(title="Truth inside the claimed 95 % interval [%]; grey: 95 as it shows on so many seeds", ylim=(0, 112))
    right.axhline(1.0, color=INK, lw=1.0)
    right.set(title="Spread of the estimates over the bound", yscale="log", ylim=(0.5, None))
    for ax in (left, right):
        ticks(ax.xaxis, range(len(trials.names)), [NAMES[name] for name in trials.names])
        ax.grid(axis="x", visible=False)
    legend_below(band, [right])


def _bias_rows(band: Any, bias: BiasMap) -> None:
    axes = band.subplots(len(bias.names), bias.noise_m.size, sharex=True, sharey="row", squeeze=False)
    for s, noise in enumerate(bias.noise_m):
        axes[0, s].set_title(f"Bias of one run{', bars 2 sd' * (s == 0)}; sonar {1e3 * noise:g} mm")
        axes[-1, s].set_xlabel("frequency of the sinusoid [rad/s]")
        for i, ax in enumerate(axes[:, s]):
            _bias(ax, bias, i, s)
    for name, ax in zip(bias.names, axes[:, 0], strict=True):
        ax.set_ylabel(f"{NAMES[name]}, bias [%]")


def _bias(ax: Any, bias: BiasMap, i: int, s: int) -> None:
    for k, method in enumerate(METHODS):
        middle, doubt = 100.0 * bias.error[method][s, :, :, i].T
        at = bias.rad_s * (1.0 + 0.02 * (k - 1.5))
        ax.errorbar(at, np.clip(middle, BIASES[0], BIASES[-1]), yerr=2.0 * doubt, color=COLOURS[method],
                    marker=MARKS[method], ms=4, lw=1.0, elinewidth=0.6, label=TITLES[method])  # fmt: skip
    ax.axhline(0.0, color=INK, lw=1.0)
    ax.set_yscale("symlog", linthresh=LINEAR_PERCENT)
    ax.set(xscale="log", ylim=(1.3 * BIASES[0], 1.3 * BIASES[-1]))
    ticks(ax.yaxis, BIASES)
    ticks(ax.xaxis, bias.rad_s)
