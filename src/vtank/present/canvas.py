"""The one module of this package that loads matplotlib: paper, pens and the way to a PNG."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from pathlib import Path
from typing import Any

# Okabe and Ito's colours, told apart by the colour-blind (jfly.uni-koeln.de/color)
BLUE, ORANGE, GREEN, VERMILION, SKY, PURPLE = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9", "#CC79A7"
CRIMSON = "#b2182b"
INK, GREY, PALE = "#1c2529", "#7d8a91", "#c9d1d5"

TRUTH: dict[str, Any] = {"color": INK, "lw": 1.3, "ls": (0, (5, 2)), "label": "truth"}
PUBLISHED: dict[str, Any] = {"color": VERMILION, "lw": 1.2, "ls": (0, (1, 1.5)), "label": "published"}
TRUTH_COLOURS = {"physical": GREEN, "paper-ii": BLUE, "paper-iii": PURPLE}

STYLE = Path(__file__).with_name("canvas.mplstyle")
DPI = 120


def drawn(draw: Callable[..., Any]) -> Callable[..., bytes]:
    """Turn a function that returns a figure into one that returns a PNG in the house style."""

    @wraps(draw)
    def png(*args: Any, **keywords: Any) -> bytes:
        from matplotlib import style

        with style.context(STYLE):
            file = io.BytesIO()
            draw(*args, **keywords).savefig(file, format="png", dpi=DPI, metadata={"Software": None})
        return file.getvalue()

    return png


def page(title: str, width_in: float, height_in: float) -> Any:
    """An empty figure with a title."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    figure.suptitle(title, x=0.01, ha="left", color=INK)
    return figure


def ticks(axis: Any, values: Iterable[float], labels: Sequence[str] | None = None) -> None:
    """Ticks of one axis at these values and nowhere else."""
    values = list(values)
    axis.set_ticks([], minor=True)
    axis.set_ticks(values, [f"{value:g}" for value in values] if labels is None else labels)


def shades(count: int) -> Any:
    """So many colours from dark to light."""
    from matplotlib import colormaps

    return colormaps["viridis"]([0.85 * i / max(count - 1, 1) for i in range(count)])


def halo(colour: str) -> list[Any]:
    """A rim that lifts text off what lies under it."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=1.6, foreground=colour)]


def legend_below(figure: Any, axes: Iterable[Any], columns: int = 6) -> None:
    """One legend for all axes below them, each label once."""
    found: dict[str, Any] = {}
    for ax in axes:
        handles, labels = ax.get_legend_handles_labels()
        found |= {label: handle for handle, label in zip(handles, labels, strict=True) if label not in found}
    figure.legend(found.values(), found.keys(), loc="outside lower left", ncols=columns)
