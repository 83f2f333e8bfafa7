"""A diagnosis on the terminal: the verdict in plain words, then where, which, how far, ties and what is next."""

from __future__ import annotations

from collections.abc import Iterator

from . import likeness, words, words_budget
from .blocks import Bars, Heading, Paragraph, Table, Terms
from .document import plain
from .words import Document

LISTED = 4  # hypotheses told
COLUMNS = {"nominal": "as it is", "refit": "refitted", "diagnosed": "diagnosed", "floor": "noise"}


def terminal_text(document: Document, width: int = 100) -> str:
    """The findings as text of at most `width` columns."""
    verdict = plain(Heading(words.headline(document), 1), Paragraph(" ".join(words.explanation(document))), width=width)
    place = f"{words.channel(document)} {words.runs(document)} {words.time(document)}"
    told = Terms((
        *([("Likeness", paragraphs(likeness.sentence(document)))] if "against" in document else []),
        *([("Budget", paragraphs(*shares))] if (shares := words_budget.budget(document)) else []),
        ("Where", paragraphs(place, words.frequency(document), words.region(document))),
        ("Which", (leading(document), *paragraphs(*sizes(document), *own(document)))),
        *([("Law", paragraphs(*found))] if (found := [*words_budget.laws(document)]) else []),
        ("How far", (gap_table(document), Paragraph(words.shrinkage(document)))),
        ("Ties", paragraphs(*(words.ties(document) or [words.NO_TIES]))),
        ("Next", paragraphs(words.next_experiment(document))),
    ))  # fmt: skip
    return f"{verdict}\n\n{plain(told, width=width)}\n"


def paragraphs(*texts: str) -> tuple[Paragraph, ...]:
    """Each text as a paragraph."""
    return tuple(map(Paragraph, texts))


def leading(document: Document) -> Bars:
    """The most probable hypotheses in words, those next to impossible left out."""
    ranked = sorted(document["probabilities"].items(), key=lambda item: -item[1])
    return Bars(tuple((words.hypothesis(name), p, False) for name, p in ranked[:LISTED] if p >= 0.001))


def sizes(document: Document) -> Iterator[str]:
    """Estimates of the named effects, one sentence each."""
    for effect, meaning, value, span, unit in words.estimates(document):
        yield f"{effect}, {meaning}: {value} {unit}".rstrip() + (f" (95 %: {span})" if span else "")


def own(document: Document) -> Iterator[str]:
    """The simulator's own parameters before and after, one sentence each, and in N; none where it is right as it is."""
    if document["verdict"]["kind"] == "none" and not words.foreign(document):
        return
    for name, nominal, _, diagnosed, unit in words.own_parameters(document):
        yield f"{name}: {diagnosed} {unit}".rstrip() + ("" if words.foreign(document) else f" (as it is {nominal})")
    for name, value, span, unit in words.in_newton(document):
        yield f"{name}: {value} {unit} (95 %: {span})"


def gap_table(document: Document) -> Table:
    """Error of every run, before and after."""
    shown = (*words.simulators(document), "floor")
    rows = [
        (run["run"], *(words.length(run[name], run["unit"]) for name in shown)) for run in document["where"]["runs"]
    ]
    return Table(("run", *(COLUMNS[name] for name in shown)), tuple(rows))
