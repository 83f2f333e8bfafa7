"""Pieces of an HTML page; all text is escaped."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from . import words


def section(title: str, *parts: str) -> str:
    """A heading and what belongs to it."""
    name = title.lower().replace(" ", "-")
    return f'<section aria-labelledby="{name}"><h2 id="{name}">{escape(title)}</h2>\n{"".join(parts)}</section>\n'


def heading(text: str) -> str:
    """A heading inside a section."""
    return f"<h3>{escape(text)}</h3>\n"


def paragraph(text: str) -> str:
    """A paragraph."""
    return f"<p>{escape(text)}</p>\n"


def figure(svg: str, caption: str, legend: Sequence[tuple[str, str]] = ()) -> str:
    """A picture with its caption and legend: (class of the swatch, text)."""
    items = "".join(f'<li><i class="{style}"></i>{escape(text)}</li>' for style, text in legend)
    marks = f'<ul class="legend">{items}</ul>' if items else ""
    scrolling = f'<div class="wide" tabindex="0">{svg}</div>'
    return f"<figure>{marks}{scrolling}<figcaption>{escape(caption)}</figcaption></figure>\n"


def table(header: Sequence[str], rows: Sequence[Sequence[str]], text_columns: int = 1) -> str:
    """A table whose first columns are text and the others numbers."""

    def cells(tag: str, row: Sequence[str]) -> str:
        styles = ("text" if i < text_columns else "num" for i in range(len(row)))
        return "".join(f'<{tag} class="{s}">{escape(cell)}</{tag}>' for s, cell in zip(styles, row, strict=True))

    head = f"<thead><tr>{cells('th', header)}</tr></thead>"
    body = "".join(f"<tr>{cells('td', row)}</tr>" for row in rows)
    return f'<div class="wide"><table>{head}<tbody>{body}</tbody></table></div>\n'


def bars(rows: Sequence[tuple[str, float, bool]]) -> str:
    """Probabilities as bars: name, probability, whether it is the one named."""
    lines = []
    for name, p, named in rows:
        style = "bar named" if named else "bar"
        bar = f'<td class="{style}"><span style="width:{100.0 * p:.1f}%"></span></td>'
        lines.append(f"<tr><td>{escape(name)}</td>{bar}<td>{escape(words.percent(p))}</td></tr>")
    return f'<table class="bars"><tbody>{"".join(lines)}</tbody></table>\n'
