"""The score as tables, in Markdown and CSV."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from ...present import Block, Heading, Paragraph, Picture, Table
from ...present.document import csv_text
from .measures import Measure
from .rows import Row

Groups = Mapping[str, Mapping[str, Mapping[str, Measure]]]
TITLE = "Score of the blind trials"
TITLES = {
    "single": "Single effects, by post-refit signal-to-noise ratio d",
    "pair": "Pairs of effects, by d of the weaker",
    "subsets": "Single effects with d >= 10, by noise and excitation",
    "none": "No gap",
    "parameters": "Parameters only, by d of their change",
    "unknown": "Unmodelled cause, by d of what the best two known effects leave",
    "unknown_single": "Unmodelled cause, by d of what the best single known effect leaves",
    "outside": "Unmodelled cause, a law that no catalogue has, leftover d >= 10",
    "left_out": "Unmodelled cause, an effect left out of the catalogue, leftover d >= 10",
    "known": "Known effects denied",
    "sure": "Wrong class at a stated probability of 0.95 or more",
    "closed": "Gap closed on held-out runs",
    "calibration": "Calibration: Brier score = miscalibration - discrimination + uncertainty",
}

# group, subset, measure, bar, in words (diagnosis design, section 4)
BARS = (
    ("single", ">=10", "top-1", ">= 0.80"),
    ("single", ">=10", "top-1 over ceiling", ">= 0.95"),
    ("single", ">=10", "class correct", ">= 0.97"),
    ("single", "10-30", "log score", "<= 0.45"),
    ("single", "10-30", "brier", "<= 0.25"),
    ("sure", "all", "wrong at 0.95", "<= 0.01"),
    ("none", "all", "false alarm", "0.005 to 0.02"),
    ("none", "coloured", "false alarm", "0.005 to 0.02"),
    ("none", "unseen excitation", "false alarm", "0.005 to 0.02"),
    ("unknown", ">=10", "called unknown", ">= 0.85"),
    ("known", "all", "false none-of-these", "<= 0.03"),
    ("closed", ">=10", "closed, median", ">= 0.95"),
    ("closed", ">=10", "closed, 10th percentile", ">= 0.80"),
    ("closed", "all", "coverage of 90 %", "0.86 to 0.94"),
    ("calibration", "most probable name", "miscalibration", "<= 0.015"),
)
MEASURES = ("subset", "measure", "value", "low95", "high95", "n")
CASES = ("case", "kind", "truth", "d", "unseen", "coloured", "verdict", "answer", "p_answer", "p_truth", "class",
         "class_right", "top1_ceiling", "gap_refit_m", "gap_oracle_m", "gap_diagnosed_m", "refused")  # fmt: skip


def tables(groups: Groups) -> list[Table]:
    """The bars first, then one table for every group: measures down, strata or subsets across."""
    return [_bars(groups), *(_group(name, groups[name]) for name in TITLES if groups.get(name))]


def page(groups: Groups, sources: str, pictures: Iterable[Picture]) -> list[Block]:
    """All tables and the pictures in one document."""
    how = (
        "Every hash was verified. Cells: value [95 % interval] (cases). Interval of a proportion: Wilson. "
        f"Answers were given by the program with the sources {sources[:16]}."
    )
    return [Heading(TITLE, 1), Paragraph(how), *tables(groups), *pictures]


def measures_csv(groups: Groups) -> dict[str, str]:
    """A file for every table, by its name: subset, measure, value, low, high, n on one line per measure."""
    listed = {"bars": [(f"{group}; {subset}", name, m) for group, subset, name, _, m in _with_bar(groups)]}
    for group in TITLES:
        if some := groups.get(group):
            listed[group] = [
                (subset, name, m[name]) for subset, m in some.items() for name in _order(some) if name in m
            ]
    return {
        file: csv_text(MEASURES, [(subset, name, m.value, m.low, m.high, m.n) for subset, name, m in rows], blank=True)
        for file, rows in listed.items()
    }


def _with_bar(groups: Groups) -> list[tuple[str, str, str, str, Measure]]:
    """Group, subset, measure, bar, and what was reached."""
    found = [(*bar, groups.get(bar[0], {}).get(bar[1], {}).get(bar[2])) for bar in BARS]
    return [(group, subset, name, bar, m) for group, subset, name, bar, m in found if m is not None]


def _bars(groups: Groups) -> Table:
    rows = [(f"{name}: {TITLES[group].lower()}; {subset}", m.text(), bar)
            for group, subset, name, bar, m in _with_bar(groups)]  # fmt: skip
    return Table(("measure", "reached", "bar"), tuple(rows), name="bars", title="Measures that have a bar")


def _order(some: Mapping[str, Mapping[str, Measure]]) -> list[str]:
    """Measures of a group, each followed by what it is compared with."""
    names = list(dict.fromkeys(name for summary in some.values() for name in summary))
    return sorted(names, key=lambda name: names.index(name.split(",")[0]) if name.split(",")[0] in names else 99)


def _group(name: str, some: Mapping[str, Mapping[str, Measure]]) -> Table:
    rows = [(row, *(m[row].text() if row in m else "-" for m in some.values())) for row in _order(some)]
    return Table(("", *some), tuple(rows), name=name, title=TITLES[name])


def cases_csv(rows: Sequence[Row]) -> str:
    """One line per case."""
    lines = []
    for r in rows:
        chances = (f"{r.chances.get(name, 0.0):.4f}" for name in (r.answer, r.label))
        gaps = (r.ceiling.top1 if r.ceiling else math.nan, r.closed.refit, r.closed.oracle, r.closed.diagnosed)
        lines.append((r.case, r.kind, r.label, f"{r.d:.4g}", r.unseen, r.coloured, r.verdict.get("kind"), r.answer,
                      *chances, " ".join(r.named), r.class_right, *gaps, r.refused))  # fmt: skip
    return csv_text(CASES, lines, blank=True)
