"""Pictures in SVG: scales, axes and marks, coloured by the page's style sheet so that they follow light and dark."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np

NARROWEST, WIDEST = 0.7, 1.3  # of a picture's own width, between which its letters can be read; choices
TICK = 44.0  # [px] between the numbers of an axis at least, so that none runs into the next; a choice
CLIP = "panel-that-clips"  # stands in a mark for the id of its panel's outline, which the picture gives
MOST_POINTS = 500  # points of a line; denser ones are drawn as the envelope of their extremes


@dataclass(frozen=True)
class Scale:
    """A value's place on the picture: `low` lies at `start`, `high` at `end` [px], evenly or by logarithm."""

    low: float
    high: float
    start: float
    end: float
    log: bool = False

    def __call__(self, value: float) -> float:
        """Pixel of a value, held within twice the picture so that no outlier leaves it by far."""
        a, b, v = self.low, self.high, value
        if self.log:
            a, b, v = math.log10(a), math.log10(b), math.log10(max(value, 1e-300))
        share = min(max((v - a) / (b - a), -1.0), 2.0)
        return self.start + share * (self.end - self.start)

    def holds(self, values: np.ndarray) -> bool:
        """Whether all values lie between the ends, but for rounding."""
        low, high = sorted((self.low, self.high))
        room = 1e-9 * (high - low)
        return bool(np.all((values >= low - room) & (values <= high + room)))

    def ticks(self, count: int = 5) -> list[float]:
        """Round values from low to high: 1, 2 or 5 times a power of ten, or powers of ten; 0 asks for none."""
        if count == 0:
            return []
        if self.log:
            first, last = math.ceil(math.log10(self.low) - 1e-9), math.floor(math.log10(self.high) + 1e-9)
            powers = [10.0**k for k in range(first, last + 1)]
            fine = [m * 10.0**k for k in range(first - 1, last + 1) for m in (1, 2, 5)]
            inside = [v for v in fine if self.low * (1.0 - 1e-9) <= v <= self.high * (1.0 + 1e-9)]
            return powers if len(powers) > 2 else inside
        span = self.high - self.low
        rough = span / count
        power = 10.0 ** math.floor(math.log10(rough))
        step = next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= rough * (1.0 - 1e-9))
        first = math.ceil(self.low / step - 1e-9)
        return [k * step for k in range(first, math.floor(self.high / step + 1e-9) + 1)]


def around(values: Iterable[float], margin: float = 0.06) -> tuple[float, float]:
    """Low and high end of a scale that holds all values with some room."""
    found = [float(v) for v in values if math.isfinite(v)]
    low, high = (min(found), max(found)) if found else (0.0, 1.0)
    room = margin * (high - low) or 0.5 * abs(high) or 0.5
    return low - room, high + room


def plain(value: float) -> str:
    """A number on an axis, without trailing zeros."""
    if value != 0.0 and not 1e-3 <= abs(value) < 1e5:
        mantissa, power = f"{value:.0e}".split("e")
        return f"{mantissa}e{int(power)}"
    return f"{value:.5g}".replace("-", "\N{MINUS SIGN}")


@dataclass
class Panel:
    """A pair of axes; marks are added in the order they are drawn.

    Attributes:
        x, y: scales.
        marks: SVG elements so far.
    """

    x: Scale
    y: Scale
    marks: list[str] = field(default_factory=list)

    def frame(self, x_label: str = "", y_label: str = "", title: str = "", x_ticks: int = 6, y_ticks: int = 4) -> None:
        """Grid, tick labels, axis labels and title."""
        left, right, bottom, top = self.x.start, self.x.end, self.y.start, self.y.end
        for value in self.x.ticks(min(x_ticks, max(1, int(abs(right - left) / TICK)))):
            p = self.x(value)
            self.marks.append(f'<path class="grid" d="M{p:.1f} {bottom:.1f}V{top:.1f}"/>')
            self.text(p, bottom + 16.0, plain(value), "tick middle")
        for value in self.y.ticks(y_ticks):
            p = self.y(value)
            self.marks.append(f'<path class="grid" d="M{left:.1f} {p:.1f}H{right:.1f}"/>')
            self.text(left - 7.0, p + 4.0, plain(value), "tick end")
        self.marks.append(f'<path class="axis" d="M{left:.1f} {top:.1f}V{bottom:.1f}H{right:.1f}"/>')
        self.text(0.5 * (left + right), bottom + 34.0, x_label, "label middle")
        self.text(left, top - 8.0, title, "title")
        if y_label:
            middle = 0.5 * (top + bottom)
            turned = f'transform="translate({left - 46.0:.1f} {middle:.1f}) rotate(-90)"'
            self.marks.append(f'<text class="label middle" {turned}>{escape(y_label)}</text>')

    def text(self, px: float, py: float, text: str, style: str = "") -> None:
        """Text at a pixel."""
        if text:
            self.marks.append(f'<text class="{style}" x="{px:.1f}" y="{py:.1f}">{escape(text)}</text>')

    def line(self, x: np.ndarray, y: np.ndarray, style: str) -> None:
        """A line through points, thinned where it is too dense to be seen, and cut off where it leaves the panel."""
        x, y = thinned(np.asarray(x, float), np.asarray(y, float))
        if x.size:
            points = " ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in zip(x, y, strict=True))
            inside = self.x.holds(x) and self.y.holds(y)
            clip = "" if inside else f' clip-path="url(#{CLIP})"'
            self.marks.append(f'<polyline class="line {style}"{clip} points="{points}"/>')

    def outline(self, name: str) -> str:
        """The panel's rectangle under this id, to clip marks to."""
        left, right, top, bottom = self.x.start, self.x.end, self.y.end, self.y.start
        size = f'x="{left:.1f}" y="{top:.1f}" width="{right - left:.1f}" height="{bottom - top:.1f}"'
        return f'<clipPath id="{name}"><rect {size}/></clipPath>'

    def drawn(self, name: str) -> str:
        """All marks; `name` is the panel's unique id in the page."""
        marks = "\n".join(self.marks)
        return f"{self.outline(name)}\n{marks.replace(CLIP, name)}" if CLIP in marks else marks

    def horizontal(self, value: float, style: str) -> None:
        """A line across the panel."""
        self.marks.append(f'<path class="line {style}" d="M{self.x.start:.1f} {self.y(value):.1f}H{self.x.end:.1f}"/>')

    def vertical(self, value: float, style: str) -> None:
        """A line from bottom to top."""
        self.marks.append(f'<path class="line {style}" d="M{self.x(value):.1f} {self.y.start:.1f}V{self.y.end:.1f}"/>')

    def box(self, x0: float, x1: float, y0: float, y1: float, style: str, note: str = "") -> None:
        """A filled rectangle between values; `note` shows on hovering."""
        a, b = sorted((self.x(x0), self.x(x1)))
        c, d = sorted((self.y(y0), self.y(y1)))
        inner = f"<title>{escape(note)}</title>" if note else ""
        size = f'x="{a:.1f}" y="{c:.1f}" width="{max(b - a, 0.5):.1f}" height="{max(d - c, 0.5):.1f}"'
        self.marks.append(f'<rect class="{style}" {size}>{inner}</rect>')

    def dot(self, x: float, y: float, style: str, note: str = "", radius: float = 4.5) -> None:
        """A round mark at a value; `note` shows on hovering."""
        inner = f"<title>{escape(note)}</title>" if note else ""
        place = f'cx="{self.x(x):.1f}" cy="{self.y(y):.1f}" r="{radius}"'
        self.marks.append(f'<circle class="{style}" {place}>{inner}</circle>')


def thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same line with at most MOST_POINTS points, which keep the extremes."""
    if x.size <= MOST_POINTS:
        return x, y
    pieces = np.array_split(np.arange(x.size), MOST_POINTS // 2)
    keep = np.unique([k for piece in pieces for k in (piece[np.argmin(y[piece])], piece[np.argmax(y[piece])])])
    return x[keep], y[keep]


def picture(name: str, width: float, height: float, panels: Sequence[Panel], alt: str) -> str:
    """An SVG element with an alternative text; `name` is its unique id in the page."""
    marks = "\n".join(panel.drawn(f"{name}-{number}") for number, panel in enumerate(panels, 1))
    return drawn(name, width, height, marks, alt)


def drawn(name: str, width: float, height: float, marks: str, alt: str) -> str:
    """As `picture`, from its elements; never so narrow or so wide on a page that its letters cannot be read."""
    size = f'style="min-width:{NARROWEST * width:g}px;max-width:{WIDEST * width:g}px"'
    label = f'role="img" aria-labelledby="{name}-alt" {size}'
    return (
        f'<svg id="{name}" viewBox="0 0 {width:g} {height:g}" {label} xmlns="http://www.w3.org/2000/svg">'
        f'<title id="{name}-alt">{escape(alt)}</title>\n{marks}\n</svg>'
    )
