"""A page of headings, paragraphs, tables and pictures, written as Markdown or as HTML from one source."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape


@dataclass(frozen=True)
class Heading:
    """A heading; level 1 is the page's title."""

    text: str
    level: int = 2


@dataclass(frozen=True)
class Paragraph:
    """A paragraph, with a lead in bold where one is given."""

    text: str
    lead: str = ""


@dataclass(frozen=True)
class Table:
    """Cells as text; `kinds` gives each row a class for HTML, `notes` stand below."""

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    left: int = 1  # columns set flush left; the others are numbers


@dataclass(frozen=True)
class Picture:
    """A picture by its path relative to the page."""

    path: str
    caption: str


@dataclass(frozen=True)
class Links:
    """Places to go on to: (path relative to the page, what is there)."""

    items: tuple[tuple[str, str], ...]


Block = Heading | Paragraph | Table | Picture | Links


def markdown(blocks: Iterable[Block]) -> str:
    """The page as Markdown."""
    return "\n\n".join(_markdown(block) for block in blocks) + "\n"


def _markdown(block: Block) -> str:
    match block:
        case Heading(text, level):
            return f"{'#' * level} {text}"
        case Paragraph(text, lead):
            return f"**{lead}** {text}" if lead else text
        case Picture(path, caption):
            return f"![{caption}]({path})\n\n*{caption}*"
        case Links(items):
            return "\n".join(f"- [{path}]({path}): {text}" for path, text in items)
        case Table(header, rows, notes, _, left):
            ruler = [":--"] * left + ["--:"] * (len(header) - left)
            lines = [f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |" for row in (header, *rows)]
            lines.insert(1, f"| {' | '.join(ruler)} |")
            return "\n".join(lines) + "".join(f"\n\n{note}" for note in notes)


def plain(table: Table) -> str:
    """A table for a terminal."""
    rows = (table.header, *table.rows)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = (c.ljust(w) if i < table.left else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True)))
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1c2529; max-width: 1180px; margin: 2em auto; padding: 0 1em; }
h1, h2, h3 { line-height: 1.2; margin: 1.6em 0 .5em; } h1 { margin-top: 0; }
table { border-collapse: collapse; margin: .8em 0; font-variant-numeric: tabular-nums; font-size: 14px; }
th, td { padding: .15em .7em; text-align: right; white-space: nowrap; } th { border-bottom: 2px solid #1c2529; }
th.left, td.left { text-align: left; } tr.first td { border-top: 1px solid #b9c4c9; }
tr.truth td { font-weight: 600; } tr.published td:not(:first-child) { color: #a02c00; }
figure { margin: 1.4em 0; } figure img { max-width: 100%; } figcaption, .note { color: #55646b; font-size: 13px; }
"""


def html(title: str, blocks: Iterable[Block]) -> str:
    """The page as one HTML file with its style inside."""
    body = "\n".join(_html(block) for block in blocks)
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{STYLE}</style>'
    return f'<!doctype html>\n<html lang="en"><head>{head}</head><body>\n{body}\n</body></html>\n'


def _html(block: Block) -> str:
    match block:
        case Heading(text, level):
            return f"<h{level}>{escape(text)}</h{level}>"
        case Paragraph(text, lead):
            return f"<p><b>{escape(lead)}</b> {escape(text)}</p>" if lead else f"<p>{escape(text)}</p>"
        case Picture(path, caption):
            image = f'<img src="{escape(path)}" alt="{escape(caption)}">'
            return f"<figure>{image}<figcaption>{escape(caption)}</figcaption></figure>"
        case Links(items):
            entries = (f'<li><a href="{escape(path)}">{escape(path)}</a>: {escape(text)}</li>' for path, text in items)
            return f"<ul>{''.join(entries)}</ul>"
        case Table():
            return _html_table(block)


def _html_table(table: Table) -> str:
    kinds = table.kinds or ("",) * len(table.rows)
    lines = [_html_row("th", table.header, table.left)]
    lines += [_html_row("td", row, table.left, kind) for row, kind in zip(table.rows, kinds, strict=True)]
    notes = "".join(f'<p class="note">{escape(note)}</p>' for note in table.notes)
    return f"<table>{''.join(lines)}</table>{notes}"


def _html_row(tag: str, cells: Sequence[str], left: int, kind: str = "") -> str:
    classes = ' class="left"'
    inner = "".join(f"<{tag}{classes if i < left else ''}>{escape(cell)}</{tag}>" for i, cell in enumerate(cells))
    return f'<tr class="{kind}">{inner}</tr>'


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table as CSV with lines ended by LF."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()
