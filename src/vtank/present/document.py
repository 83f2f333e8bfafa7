"""One document, many outlets: a page of blocks as text for a terminal, as Markdown, as HTML; a table as CSV."""

from __future__ import annotations

import csv
import io
import math
import re
import textwrap
from collections.abc import Iterable, Sequence
from functools import cache
from typing import TYPE_CHECKING
from urllib.parse import quote

from .. import __version__
from .blocks import Bars, Block, Details, Drawing, Film, Heading, Links, Paragraph, Picture, Table, Terms
from .numbers import percent

if TYPE_CHECKING:
    from jinja2 import Environment

MARGIN = 12  # columns for terms on a terminal
WIDTH = 110  # columns of text on a terminal
# What Markdown would take for markup: emphasis, code, links, tags, entities, cells of tables
MARKUP = re.compile(r"[\\`*~|]|(?<![^\W_])_|_(?![^\W_])|](?=[(\[])|<(?=[A-Za-z/!?])|&(?=#?\w+;)")
ENTITIES = {"<": "&lt;", "&": "&amp;"}
MEASURE = re.compile(r"(?<=\d) (?=[%°]|(?:mm?|s|N|kg|V|A|Hz|rad|rev|min)\b)")  # between a number and its unit
OPENING = re.compile(r"^(\d*)(?=[-+#>=.)\[])")  # of a line that Markdown may take for a heading, a list or a quotation


# --- for a terminal ------------------------------------------------------------------------------------------------
def plain(*blocks: Block, width: int = WIDTH) -> str:
    """Blocks as text of at most `width` columns, tables as wide as they are; pictures are left out."""
    return "\n".join(line for block in blocks for line in _lines(block, width))


def _lines(block: Block, width: int) -> list[str]:
    match block:
        case Heading(text, level):
            return textwrap.wrap(text, width) if level == 1 else ["", *textwrap.wrap(text, width), ""]
        case Paragraph(text, lead):
            return textwrap.wrap(f"{lead} {text}" if lead else text, width)
        case Table():
            above = ["", block.title, ""] if block.title else []
            return [*above, *_aligned(block), *(line for note in block.notes for line in textwrap.wrap(note, width))]
        case Bars(rows):
            return [f"{name}: {percent(p)}" for name, p, _ in rows]
        case Links(items):
            longest = max((len(path) for path, _ in items), default=0)
            return [f"{path:<{longest}}  {text}" for path, text in items]
        case Terms(items):
            return [line for term, parts in items for line in _term(term, parts, width)]
    return []


def _aligned(table: Table) -> list[str]:
    """Header and rows in columns, text flush left and numbers flush right."""
    rows = (table.header, *table.rows)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    form = "  ".join(f"{{:{'<' if i < table.left else '>'}{width}}}" for i, width in enumerate(widths))
    return [form.format(*row).rstrip() for row in rows]


def _term(term: str, parts: Sequence[Block], width: int) -> list[str]:
    """The term in the margin, and beside it what is said."""
    lines = [line for part in parts for line in _lines(part, width - MARGIN)]
    return [f"{term if i == 0 else '':<{MARGIN}}{line}".rstrip() for i, line in enumerate(lines)]


# --- Markdown ------------------------------------------------------------------------------------------------------
def markdown(blocks: Iterable[Block]) -> str:
    """The page as Markdown; nothing in a text can become markup."""
    return "\n\n".join(_markdown(block) for block in blocks) + "\n"


def _markdown(block: Block) -> str:
    match block:
        case Heading(text, level):
            return f"{'#' * level} {literal(text)}"
        case Paragraph(text, lead):
            return f"**{literal(lead)}** {literal(text)}" if lead else OPENING.sub(r"\1\\", literal(text))
        case Film(path, caption):
            return f"[{literal(caption)}]({address(path)})"
        case Picture(path, caption, _):
            return f"![{literal(caption)}]({address(path)})\n\n*{literal(caption)}*"
        case Drawing(_, caption):
            return f"*{literal(caption)}*"
        case Links(items):
            return "\n".join(f"- [{literal(path)}]({address(path)}): {literal(text)}" for path, text in items)
        case Bars(rows):
            return "\n".join(f"- {literal(name)}: {percent(p)}" for name, p, _ in rows)
        case Terms(items):
            return "\n\n".join(f"**{literal(term)}**\n\n{markdown(parts).rstrip()}" for term, parts in items)
        case Details(summary, text):
            return f"{literal(summary)}\n\n{textwrap.indent(text, '    ')}"
        case Table(header, rows, notes, _, left):
            ruler = (":--",) * left + ("--:",) * (len(header) - left)
            cells = [[literal(cell) for cell in row] for row in (header, *rows)]
            lines = [f"| {' | '.join(row)} |" for row in (cells[0], ruler, *cells[1:])]
            title = f"## {literal(block.title)}\n\n" if block.title else ""
            return title + "\n".join(lines) + "".join(f"\n\n{literal(note)}" for note in notes)


def literal(text: str) -> str:
    """Text on one line, with what Markdown would take for markup made harmless."""
    return MARKUP.sub(lambda found: ENTITIES.get(found[0], f"\\{found[0]}"), " ".join(text.split()))


def address(path: str) -> str:
    """A path as the address of a link; pictures inside the page stay as they are."""
    return path if path.startswith("data:image/") else quote(path)


# --- HTML ----------------------------------------------------------------------------------------------------------
def html(title: str, blocks: Iterable[Block], about: str = "") -> str:
    """The page as one HTML file with its style inside, which loads nothing but pictures beside it; all is escaped."""
    page = templates().get_template("page.html")
    return page.render(title=title, blocks=list(blocks), about=about, version=__version__)


@cache
def templates() -> Environment:
    """The templates beside this module."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    found = Environment(loader=PackageLoader("vtank.present", ""), autoescape=True, undefined=StrictUndefined)
    found.trim_blocks = found.lstrip_blocks = True
    found.filters |= {"address": address, "bound": bound, "percent": percent}
    return found


def bound(text: str) -> str:
    """Text in which no line breaks between a number and its unit."""
    return MEASURE.sub("\N{NO-BREAK SPACE}", text)


# --- CSV -----------------------------------------------------------------------------------------------------------
def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]], blank: bool = False) -> str:
    """A table as CSV with lines ended by LF, numbers with six digits; `blank`: what is not finite is left empty."""

    def cell(value: object) -> object:
        if not isinstance(value, float):  # numpy's float64 is one
            return value
        return "" if blank and not math.isfinite(value) else f"{value:.6g}"

    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([header, *(map(cell, row) for row in rows)])
    return text.getvalue()
