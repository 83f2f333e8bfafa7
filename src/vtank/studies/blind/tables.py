"""The score as tables, in Markdown and CSV."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from ...present import Block, Heading, Paragraph, Picture, Table
from ...present.document import csv_text
from .measures import Measure
from .questions import CLOSED, OVERLAP, QUESTIONS
from .rows import FAINT, VISIBLE, Row

Groups = Mapping[str, Mapping[str, Mapping[str, Measure]]]
TITLE = "Score of the blind trials"
BARS = {q.name: q.bar for q in QUESTIONS} | {CLOSED: ">= 0.90", "miscalibration": "<= 0.015"}
RULES = (
    "Cells: value [95 % interval] (cases); interval of a proportion: Wilson. d is the "
    "signal-to-noise ratio that the best refit of the nominal's own parameters leaves; a gap is visible from "
    f"{VISIBLE:g}. Unknown causes count by what the best two known effects leave as well, where that was computed; of "
    f"known ones those fainter than {FAINT:g} count as not there. "
    f"Windows are right where at least {100 * OVERLAP:.0f} % of their time is named, and at least as much of the time "
    "named is theirs. Shares of the budget are true for the runs that were given, foretold as the diagnosis does. "
)
MEASURES = ("group", "member", "measure", "value", "low95", "high95", "n")
CASES = ("case", "kind", "truth", "causes", "d", "vehicle", "noise", "turbulence", "runs", "rate_hz", "duration_s",
         "verdict", "channel", "probability", "answer", "p_truth", "class", "wrong", "windows_named", "windows_true",
         "gap_refit_m", "gap_oracle_m", "gap_diagnosed_m", "refused")  # fmt: skip


def tables(groups: Groups, bars: Mapping[str, str] = BARS) -> list[Table]:
    """The bars first, then one table for every group: members down, the questions that arise across."""
    return [
        _bars(groups["all"]["all"], bars),
        *(_group(name, some) for name, some in groups.items() if name != "all" and some),
    ]


def page(
    some: Sequence[Table], rules: str, sources: str, checked: Iterable[str], pictures: Iterable[Picture]
) -> list[Block]:
    """What was checked, all tables and the pictures in one document."""
    how = rules + f"Answers were given by the program with the sources {sources[:16]}."
    return [Heading(TITLE, 1), Paragraph(how), *map(Paragraph, checked), *some, *pictures]


def _bars(every: Mapping[str, Measure], bars: Mapping[str, str]) -> Table:
    rows = tuple((name, m.text(), bars.get(name, "")) for name, m in every.items() if m.n)
    return Table(("measure", "reached", "bar"), rows, name="all", title="All cases")


def _group(name: str, some: Mapping[str, Mapping[str, Measure]]) -> Table:
    asked = [q for q in next(iter(some.values())) if any(m[q].n for m in some.values())]
    rows = tuple((member, *(m[q].brief() for q in asked)) for member, m in some.items())
    return Table((name, *asked), rows, name=name, title=f"By {name}")


def measures_csv(groups: Groups) -> str:
    """Every measure of every group on a line."""
    lines = [
        (group, member, name, m.value, m.low, m.high, m.n)
        for group, some in groups.items() for member, found in some.items() for name, m in found.items() if m.n
    ]  # fmt: skip
    return csv_text(MEASURES, lines, blank=True)


def cases_csv(rows: Sequence[Row]) -> str:
    """One line per case."""
    lines = []
    for r in rows:
        e = r.truth["experiment"]
        made = (e[key] for key in ("vehicle", "noise", "turbulence", "runs", "rate_hz", "duration_s"))
        causes = " ".join(c["name"] for c in r.truth["causes"])
        said = (
            r.said,
            r.verdict.get("channel"),
            f"{r.probability:.4f}",
            r.answer,
            f"{r.chances.get(r.label, 0.0):.4f}",
        )
        windows = r.windows_found() or (None, None)
        lines.append((r.case, r.kind, r.label, causes, f"{r.d:.4g}", *made, *said, " ".join(r.named), r.wrong, *windows,
                      r.closed.refit, r.closed.oracle, r.closed.diagnosed, r.refused))  # fmt: skip
    return csv_text(CASES, lines, blank=True)
