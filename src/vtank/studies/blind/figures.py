"""Figures of the score: confusion matrix, reliability diagram, gap closed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ...effects import CATALOGUE
from .calibration import corp, pav
from .rows import STRATA, Row

DPI = 150
BAND_DRAWS = 400


def draw_all(out: Path, rows: Sequence[Row]) -> None:
    """Write confusion.png, reliability.png and closed.png."""
    if rows:
        confusion(rows).savefig(out / "confusion.png", dpi=DPI)
        reliability(rows).savefig(out / "reliability.png", dpi=DPI)
        closed(rows).savefig(out / "closed.png", dpi=DPI)


def confusion(rows: Sequence[Row]) -> Figure:
    """Truth down, most probable answer across, as shares of each truth; pairs are one line."""
    order = ["none", "parameters", *(effect.name for effect in CATALOGUE), "pair", "unknown"]
    pairs = [(_short(r.label), _short(r.answer)) for r in rows]
    true = [name for name in order if any(t == name for t, _ in pairs)]
    said = [name for name in order if any(a == name for _, a in pairs)] + [
        name for name in sorted({a for _, a in pairs}) if name not in order
    ]
    counts = np.array([[sum(p == (t, a) for p in pairs) for a in said] for t in true])
    total = counts.sum(axis=1, keepdims=True)
    figure = Figure(figsize=(2.5 + 0.38 * len(said), 2.2 + 0.32 * len(true)), layout="constrained")
    axes = figure.add_subplot()
    axes.imshow(counts / total, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    for i, j in zip(*np.nonzero(counts), strict=True):
        colour = "white" if counts[i, j] > 0.6 * total[i, 0] else "black"
        axes.text(j, i, str(counts[i, j]), ha="center", va="center", fontsize=7, color=colour)
    axes.set_xticks(range(len(said)), said, rotation=90, fontsize=8)
    axes.set_yticks(range(len(true)), [f"{name} ({n})" for name, n in zip(true, total[:, 0], strict=True)], fontsize=8)
    axes.set(xlabel="most probable answer", ylabel="truth (cases)", title=f"{len(rows)} blind cases")
    return figure


def reliability(rows: Sequence[Row]) -> Figure:
    """Stated probability of the most probable answer against how often it was right, isotonic, with a chance band."""
    stated = np.array([r.chances[r.answer] for r in rows])
    right = np.array([float(r.right) for r in rows])
    order = np.argsort(stated)
    x = stated[order]
    random = np.random.default_rng(0)
    chance = np.array([pav(x, (random.random(x.size) < x).astype(float)) for _ in range(BAND_DRAWS)])
    low, high = np.quantile(chance, (0.05, 0.95), axis=0)
    found = corp(stated, right)
    figure = Figure(figsize=(4.6, 5.2), layout="constrained")
    top, bottom = figure.subplots(2, 1, height_ratios=(4, 1), sharex=True)
    top.fill_between(x, low, high, color="0.85", label="90 % of calibrated answers", step="mid")
    top.plot([0, 1], [0, 1], color="0.5", lw=0.8)
    top.plot(x, pav(stated, right)[order], color="C0", lw=1.8, label="isotonic regression")
    top.set(ylabel="share that was right", ylim=(-0.02, 1.02), xlim=(0, 1.01))
    top.set_title(
        f"miscalibration {found.miscalibration:.4f} (by chance {found.expected:.4f}), n = {found.n}", fontsize=9
    )
    top.legend(loc="upper left", fontsize=8, frameon=False)
    bottom.hist(stated, np.linspace(0, 1, 21).tolist(), color="C0")
    bottom.set(xlabel="stated probability of the most probable answer", ylabel="cases")
    return figure


def closed(rows: Sequence[Row]) -> Figure:
    """Share of the oracle's closing that the diagnosis reaches, over d, for known effects."""
    some = [r for r in rows if np.isfinite([r.closed.refit, r.closed.oracle, r.closed.diagnosed]).all() and r.d > 0.0]
    some = [r for r in some if r.closed.refit > 1.1 * r.closed.oracle and "+" not in r.label]
    figure = Figure(figsize=(5.4, 3.6), layout="constrained")
    axes = figure.add_subplot()
    for right, colour, text in ((True, "C0", "named first"), (False, "C3", "another named first")):
        points: Any = np.array([(r.d, np.clip(r.closed.fraction, -0.5, 1.2)) for r in some if r.right == right])
        if points.size:
            axes.plot(points[:, 0], points[:, 1], "o", ms=4, alpha=0.7, color=colour, label=text)
    axes.axhline(1.0, color="0.5", lw=0.8)
    for low, _ in STRATA.values():
        axes.axvline(low, color="0.9", lw=0.8, zorder=0)
    axes.set(xscale="log", xlabel="post-refit signal-to-noise ratio d", ylabel="gap closed, oracle = 1")
    axes.set_title(f"{len(some)} cases with a single known effect; cut off at -0.5", fontsize=9)
    if some:
        axes.legend(fontsize=8, frameon=False)
    return figure


def _short(label: str) -> str:
    return "pair" if "+" in label else label
