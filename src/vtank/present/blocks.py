"""What a document is made of; present/document.py turns it into text, HTML, Markdown and CSV."""

from __future__ import annotations

from dataclasses import dataclass


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
    """A table of text.

    Attributes:
        header, rows: cells; the first `left` columns are text, the others numbers.
        notes: stand below.
        kinds: a class for each row, for the style sheet.
        name, title: of its CSV file without suffix, and above the table; empty for none.
    """

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    left: int = 1
    name: str = ""
    title: str = ""


@dataclass(frozen=True)
class Picture:
    """A picture by its path relative to the page, or as a data: address; a plot is never shown too small to be read."""

    path: str
    caption: str
    plot: bool = True


@dataclass(frozen=True)
class Film:
    """An MP4 by its path relative to the page."""

    path: str
    caption: str


@dataclass(frozen=True)
class Drawing:
    """A picture drawn in SVG, trusted as it is; legend: (class of the swatch, text)."""

    svg: str
    caption: str
    legend: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Bars:
    """Probabilities as bars: name, probability, whether it is the one named."""

    rows: tuple[tuple[str, float, bool], ...]


@dataclass(frozen=True)
class Terms:
    """Terms, each with what is said about it: cards on a page, a margin on the terminal."""

    items: tuple[tuple[str, tuple[Paragraph | Table | Bars, ...]], ...]


@dataclass(frozen=True)
class Links:
    """Places to go on to: (path relative to the page, what is there)."""

    items: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Details:
    """Text as it is, folded away under a summary."""

    summary: str
    text: str


Block = Heading | Paragraph | Table | Picture | Film | Drawing | Bars | Terms | Links | Details
