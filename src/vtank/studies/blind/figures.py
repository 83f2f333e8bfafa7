"""Figures of the score: confusion matrix and reliability diagram."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...effects import CATALOGUE
from ...present.canvas import BLUE, GREY, PALE, drawn, page, ticks
from .calibration import corp, pav
from .rows import Row

BAND_DRAWS = 400
PICTURES = {
    "confusion.png": "Truth down, most probable answer across; colours are shares of each truth, numbers are cases.",
    "reliability.png": "Stated probability of the most probable answer against how often it was right.",
}


def draw_all(rows: Sequence[Row], names: Sequence[str] = tuple(PICTURES)) -> dict[str, tuple[str, bytes]]:
    """File name -> caption and PNG, of the figures of these names; nothing without rows."""
    drawings = dict(zip(PICTURES, (confusion, reliability), strict=True))
    return {name: (PICTURES[name], drawings[name](rows)) for name in names if rows}


@drawn
def confusion(rows: Sequence[Row]) -> Any:
    """Truth down, most probable answer across, as shares of each truth; pairs and triples are one line each."""
    order = ["none", "parameters", "varying", *(effect.name for effect in CATALOGUE), "pair", "triple", "unknown"]
    pairs = [(_short(r.label), _short(r.answer)) for r in rows]
    labels, answers = ({pair[i] for pair in pairs} for i in (0, 1))
    true = [name for name in order if name in labels]
    said = [name for name in order if name in answers] + sorted(answers - set(order))
    counts = np.array([[pairs.count((t, a)) for a in said] for t in true])
    total = counts.sum(axis=1, keepdims=True)
    figure = page(f"{len(rows)} blind cases", 2.5 + 0.38 * len(said), 2.2 + 0.32 * len(true))
    axes = figure.add_subplot()
    axes.imshow(counts / total, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    for i, j in zip(*np.nonzero(counts), strict=True):
        colour = "white" if counts[i, j] > 0.6 * total[i, 0] else "black"
        axes.text(j, i, str(counts[i, j]), ha="center", va="center", fontsize=7, color=colour)
    ticks(axes.xaxis, range(len(said)), said)
    ticks(axes.yaxis, range(len(true)), [f"{name} ({n})" for name, n in zip(true, total[:, 0], strict=True)])
    axes.tick_params(axis="x", rotation=90)
    axes.grid(visible=False)
    axes.set(xlabel="most probable answer", ylabel="truth (cases)")
    return figure


@drawn
def reliability(rows: Sequence[Row]) -> Any:
    """Stated probability of the most probable answer against how often it was right, isotonic, with a chance band."""
    stated = np.array([r.chances[r.answer] for r in rows])
    right = np.array([float(r.right) for r in rows])
    order = np.argsort(stated)
    x = stated[order]
    random = np.random.default_rng(0)
    chance = np.array([pav(x, (random.random(x.size) < x).astype(float)) for _ in range(BAND_DRAWS)])
    low, high = np.quantile(chance, (0.05, 0.95), axis=0)
    found = corp(stated, right)
    title = f"Miscalibration {found.miscalibration:.4f} (by chance {found.expected:.4f}), n = {found.n}"
    figure = page(title, 5.6, 5.6)
    top, bottom = figure.subplots(2, 1, height_ratios=(4, 1), sharex=True)
    top.fill_between(x, low, high, color=PALE, label="90 % of calibrated answers", step="mid")
    top.plot([0, 1], [0, 1], color=GREY, lw=0.8)
    top.plot(x, pav(stated, right)[order], color=BLUE, lw=1.8, label="isotonic regression")
    top.set(ylabel="share that was right", ylim=(-0.02, 1.02), xlim=(0, 1.01))
    top.legend(loc="upper left")
    bottom.hist(stated, np.linspace(0, 1, 21).tolist(), color=BLUE)
    bottom.set(xlabel="stated probability of the most probable answer", ylabel="cases")
    return figure


def _short(label: str) -> str:
    return (label, "pair", "triple")[min(label.count("+"), 2)]
