"""Objects as a notebook shows them: HTML in which everything is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

WIDE, HIGH, POINTS = 240, 36, 240  # [pixels, pixels, -] of a curve; choices


def html_table(header: Sequence[str], rows: Iterable[Sequence[str]], pictures: int = 0) -> str:
    """A table of texts; `pictures`: how many of the last columns are pictures of `curve`."""
    first = len(header) - pictures
    lines = [f"<tr>{''.join(f'<th>{escape(cell)}</th>' for cell in header)}</tr>"]
    for row in rows:
        cells = [escape(cell) if k < first else cell for k, cell in enumerate(row)]
        lines.append(f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>")
    return f"<table>{''.join(lines)}</table>"


def preformatted(text: str) -> str:
    """A text as a terminal shows it."""
    return f"<pre>{escape(text)}</pre>"


def curve(time_s: NDArray[np.float64], values: NDArray[np.float64]) -> str:
    """A small picture of a channel, shape (K,) each; nothing for fewer than two samples."""
    if time_s.size < 2:
        return ""
    rows = np.linspace(0, time_s.size - 1, min(time_s.size, POINTS)).astype(int)
    x = WIDE * (time_s[rows] - time_s[0]) / np.ptp(time_s)
    y = HIGH - HIGH * (values[rows] - values.min()) / (np.ptp(values) or 1.0)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    size = f'width="{WIDE}" height="{HIGH}" viewBox="0 -1 {WIDE} {HIGH + 2}"'
    return f'<svg {size}><polyline points="{points}" fill="none" stroke="currentColor"/></svg>'
