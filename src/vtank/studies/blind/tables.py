"""The score as tables, in Markdown and CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .measures import Measure
from .rows import Row

Groups = Mapping[str, Mapping[str, Mapping[str, Measure]]]

TITLES = {
    "single": "Single effects, by post-refit signal-to-noise ratio d",
    "pair": "Pairs of effects, by d of the weaker",
    "subsets": "Single effects with d >= 10, by noise and excitation",
    "none": "No gap",
    "parameters": "Parameters only, by d of their change",
    "unknown": "Cause not in the catalogue, by d of what the best two known effects leave",
    "unknown_single": "Cause not in the catalogue, by d of what the best single known effect leaves",
    "outside": "Laws of no catalogue, leftover d >= 10",
    "left_out": "Effects left out of the catalogue, leftover d >= 10",
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


@dataclass(frozen=True)
class Table:
    """A table: file name without suffix, title, header, cells, and the measures behind them."""

    file: str
    title: str
    header: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]
    measures: tuple[tuple[str, str, Measure], ...] = ()

    def markdown(self) -> str:
        """As Markdown, the title as a heading."""
        rows = [self.header, tuple("---" for _ in self.header), *self.cells]
        return f"## {self.title}\n\n" + "\n".join("| " + " | ".join(row) + " |" for row in rows) + "\n"

    def csv(self) -> str:
        """One line per measure: subset, measure, value, low, high, n."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["subset", "measure", "value", "low95", "high95", "n"])
        for subset, name, m in self.measures:
            writer.writerow([subset, name, *(_number(v) for v in (m.value, m.low, m.high)), m.n])
        return text.getvalue()


def tables(groups: Groups) -> list[Table]:
    """The bars first, then one table for every group: measures down, strata or subsets across."""
    return [_bars(groups), *(_group(name, groups[name]) for name in TITLES if groups.get(name))]


def markdown(made: Sequence[Table], sources: str) -> str:
    """All tables in one document."""
    head = (
        "# Score of the blind trials\n\n"
        "Every hash was verified. Cells: value [95 % interval] (cases). Interval of a proportion: Wilson.\n"
        f"Answers were given by the program with the sources `{sources[:16]}`.\n"
    )
    return "\n".join([head, *(table.markdown() for table in made)])


def _bars(groups: Groups) -> Table:
    cells, found = [], []
    for group, subset, name, bar in BARS:
        m = groups.get(group, {}).get(subset, {}).get(name)
        if m is not None:
            cells.append((f"{name}: {TITLES[group].lower()}; {subset}", _text(m), bar))
            found.append((f"{group}; {subset}", name, m))
    return Table("bars", "Measures that have a bar", ("measure", "reached", "bar"), tuple(cells), tuple(found))


def _group(file: str, some: Mapping[str, Mapping[str, Measure]]) -> Table:
    names = list(dict.fromkeys(name for summary in some.values() for name in summary))
    order = sorted(names, key=lambda name: names.index(name.split(",")[0]) if name.split(",")[0] in names else 99)
    cells = [(name, *(_text(summary[name]) if name in summary else "-" for summary in some.values())) for name in order]
    listed = [(subset, name, summary[name]) for subset, summary in some.items() for name in order if name in summary]
    return Table(file, TITLES[file], ("", *some), tuple(cells), tuple(listed))


def cases_csv(rows: Sequence[Row]) -> str:
    """One line per case."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["case", "kind", "truth", "d", "unseen", "coloured", "verdict", "answer", "p_answer", "p_truth",
                     "class", "class_right", "top1_ceiling", "gap_refit_m", "gap_oracle_m", "gap_diagnosed_m",
                     "refused"])  # fmt: skip
    for r in rows:
        c = r.closed
        numbers = (r.ceiling.top1 if r.ceiling else math.nan, c.refit, c.oracle, c.diagnosed)
        writer.writerow([r.case, r.kind, r.label, f"{r.d:.4g}", r.unseen, r.coloured, r.verdict.get("kind"), r.answer,
                         f"{r.chances[r.answer]:.4f}", f"{r.chances.get(r.label, 0.0):.4f}", " ".join(r.named),
                         r.class_right, *map(_number, numbers), r.refused])  # fmt: skip
    return text.getvalue()


def _text(m: Measure) -> str:
    if m.n and math.isnan(m.low):
        return f"{m.value:.4f} ({m.n})"
    return m.text()


def _number(value: float) -> str:
    return f"{value:.6g}" if math.isfinite(value) else ""
