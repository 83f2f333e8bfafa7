"""A diagnosis on the terminal: the verdict in plain words, then where, which, how far, ties and what is next."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from . import words
from .words import Document

MARGIN = 12  # columns for the headings
LISTED = 4  # hypotheses told


def terminal_text(document: Document, width: int = 100) -> str:
    """The findings as text of at most `width` columns."""
    head = textwrap.wrap(words.headline(document), width)
    parts = [*head, *textwrap.wrap(" ".join(words.explanation(document)), width), ""]
    told = {
        "Where": [f"{words.channel(document)} {words.runs(document)} {words.time(document)}",
                  words.frequency(document), words.region(document)],
        "Which": [f"{name}: {words.percent(p)}" for name, p in leading(document)] + sizes(document)
                 + own(document),
        "How far": [*gap_table(document), words.shrinkage(document)],
        "Ties": words.ties(document) or ["Nothing that these recordings cannot tell apart."],
        "Next": [words.next_experiment(document)],
    }  # fmt: skip
    for heading, lines in told.items():
        for k, line in enumerate(lines):
            lead = (heading if k == 0 else "").ljust(MARGIN)
            row = line.startswith(" ")  # of a table, never broken
            parts += (
                [lead + line]
                if row
                else textwrap.wrap(line, width, initial_indent=lead, subsequent_indent=" " * MARGIN)
            )
    return "\n".join(parts) + "\n"


def leading(document: Document) -> list[tuple[str, float]]:
    """The most probable hypotheses in words, those next to impossible left out."""
    ranked = sorted(document["probabilities"].items(), key=lambda item: -item[1])
    return [(words.hypothesis(name), p) for name, p in ranked[:LISTED] if p >= 0.001]


def sizes(document: Document) -> list[str]:
    """Estimates of the named effects, one sentence each."""
    lines = []
    for name, found in document["estimates"].items():
        for key, e in found.items():
            text = f"{words.effect_name(name)}, {words.meaning(name, key)}: {words.number(e['value'], 4)}"
            text = f"{text} {words.unit_text(document, e['unit'])}".rstrip()
            if e["interval95"]:
                low, high = e["interval95"]
                text += f" (95 %: {words.number(low)} to {words.number(high)})"
            lines.append(text)
    return lines


def own(document: Document) -> list[str]:
    """The simulator's own parameters before and after, one sentence each; none where it is right as it is."""
    if document["verdict"]["kind"] == "none":
        return []
    lines = []
    for name, p in document.get("parameters", {}).items():
        unit = words.unit_text(document, p["unit"])
        text = f"{words.OWN.get(name, name)}: {words.number(p['diagnosed'], 4)} {unit}".rstrip()
        lines.append(f"{text} (as it is {words.number(p['nominal'], 4)})")
    return lines


def gap_table(document: Document) -> list[str]:
    """Error of every run, before and after, as rows of a table."""
    runs = document["where"]["runs"]
    rows: list[Sequence[str]] = [("run", "as it is", "refitted", "diagnosed", "noise")]
    for run in runs:
        sizes = (run[name] for name in ("nominal", "refit", "diagnosed", "floor"))
        rows.append((run["run"], *(words.length(size, run["unit"]) for size in sizes)))
    widths = [max(len(row[i]) for row in rows) for i in range(5)]
    return [" " + row[0].ljust(widths[0]) + "".join(f"  {c.rjust(w)}" for c, w in zip(row[1:], widths[1:], strict=True))
            for row in rows]  # fmt: skip
