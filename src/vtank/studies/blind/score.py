"""`vtank blind score`: verify every hash, score every case, and write tables, figures and one JSON file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...present import Picture
from ...present.document import html, markdown
from ...record import Kind, results_folder
from ..processes import processes
from ..stage import Stage, silent
from .calibration import corp
from .ceiling import unknown_ceiling
from .closed import closed
from .measures import NOTHING, Measure, brier, first, log_score, mean, quantile, share
from .rows import STRATA, Row, row
from .verify import Opened, open_all

RESULTS = Kind("results of vtank blind score", "score.json", "vtank.blind-score/1")
SURE = 0.95  # stated probability from which a wrong class is held against an answer
VISIBLE = 10.0  # d from which the bars on naming and closing hold
EFFECT = ("effect", "effects")
COUNTED = {  # measure -> kinds of verdict that count
    "false alarm": (*EFFECT, "unknown", "parameters"),
    "false effect": EFFECT,
    "false none-of-these": ("unknown",),
    "false no gap": ("none",),
    "undecided": ("undecided",),
    "called no gap": ("none",),
    "called parameters": ("parameters",),
    "called unknown": ("unknown",),
    "called unknown or undecided": ("unknown", "undecided"),
}
NO_GAP = ("false alarm", "false effect", "false none-of-these", "undecided", "top-1", "log score")
PARAMETERS_ONLY = ("top-1", "false effect", "false none-of-these", "called no gap", "log score")
UNKNOWN = ("called unknown", "called unknown or undecided", "top-1", "log score")
KNOWN = ("false none-of-these", "false no gap", "called parameters")

Summary = dict[str, Measure]


def score(folder: Path, truth: Path, answers: Path, count: int = 2, stage: Stage = silent) -> dict[str, Any]:
    """Rows and measures; InputError where a hash does not hold."""
    opened = open_all(folder, truth, answers)
    rows = []
    with processes(count) as work, stage("scoring", len(opened.truths)) as advance:
        for one in work(partial(_row, opened, truth), list(opened.truths)):
            rows.append(one)
            advance(one.case)
    return {"rows": rows, "sources": opened.sources, "measures": measures(rows)}


def _row(opened: Opened, truth: Path, case: str) -> Row:
    sealed, answer = opened.truths[case], opened.answers[case]
    return row(case, sealed, answer, closed(case, sealed, answer, truth))


def write_score(out: Path, scored: dict[str, Any]) -> None:
    """Write the score as Markdown, HTML and JSON, the cases and tables as CSV, and the figures into a folder."""
    from .figures import draw_all
    from .tables import TITLE, cases_csv, measures_csv, page

    groups, rows = scored["measures"], scored["rows"]
    pictures = draw_all(rows)
    blocks = page(groups, scored["sources"], [Picture(name, caption) for name, (caption, _) in pictures.items()])
    files: dict[str, str | bytes] = {
        "score.md": markdown(blocks),
        "score.html": html(TITLE, blocks),
        "cases.csv": cases_csv(rows),
        **{f"{name}.csv": text for name, text in measures_csv(groups).items()},
        **{name: png for name, (_, png) in pictures.items()},
    }
    about = {"sources": scored["sources"], "cases": len(rows), "measures": groups}
    with results_folder(out, RESULTS, about) as folder:
        for name, content in files.items():
            (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)


def measures(rows: Sequence[Row]) -> dict[str, dict[str, Summary]]:
    """Every group of measures by its name, per stratum or subset."""
    singles, pairs = _known(rows, "single"), _known(rows, "pair")
    labelled = {label: [r for r in rows if r.label == label] for label in ("none", "parameters", "unknown")}
    strange, named = labelled["unknown"], [r for r in rows if r.label != "unknown"]

    def visible(kind: str) -> Summary:
        return unknown(_visible([r for r in rows if r.kind == kind]))

    return {
        "single": _each(naming, by_stratum(singles)),
        "pair": _each(naming, by_stratum(pairs)),
        "subsets": _each(naming, _subsets(_visible(singles))),
        "none": _each(partial(said, NO_GAP), _subsets(labelled["none"])),
        "parameters": _each(partial(said, PARAMETERS_ONLY), by_stratum(labelled["parameters"])),
        "unknown": _each(unknown, by_stratum(strange)),
        "unknown_single": _each(unknown, by_stratum([replace(r, d=r.d_single) for r in strange])),
        "outside": {"visible": visible("outside")},
        "left_out": {"visible": visible("left_out")},
        "known": _each(partial(said, KNOWN), {"all": singles + pairs, "visible": _visible(singles + pairs)}),
        "sure": {"all": {"wrong at 0.95": _sure(named), "wrong at 0.95, cause unknown": _sure(strange)}},
        "closed": _each(shrinkage, by_stratum(singles + pairs)),
        "calibration": calibration(rows),
    }


def _each(measure: Callable[[Sequence[Row]], Summary], groups: dict[str, list[Row]]) -> dict[str, Summary]:
    return {name: measure(some) for name, some in groups.items()}


def by_stratum(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """The rows of each stratum of d, all from VISIBLE on, and all."""
    out = {name: [r for r in rows if low <= r.d < high] for name, (low, high) in STRATA.items()}
    return out | {">=10": _visible(rows), "all": list(rows)}


def naming(rows: Sequence[Row]) -> Summary:
    """How well the cause is named, with the ceiling and simpler methods beside it."""
    size, own = [float(len(r.chances)) for r in rows], _scores([(r.chances, r.label) for r in rows])
    out = {
        "top-1": own["top-1"],
        "class correct": share([r.class_right for r in rows]),
        "class size": mean([float(len(r.named)) for r in rows]),
        **own,
        **said(["undecided"], rows),
        "refused": share([bool(r.refused) for r in rows]),
    }
    bound = [r.ceiling for r in rows if r.ceiling is not None]
    out |= {
        "top-1, ceiling": mean([c.top1 for c in bound]),
        "top-1 over ceiling": _over_ceiling(rows),
        "log score, ceiling": mean([c.log_score for c in bound]),
        "brier, ceiling": mean([c.brier for c in bound]),
        "top-1, random": mean([1.0 / n for n in size]),
        "log score, random": mean([math.log(n) for n in size]),
        "brier, random": mean([1.0 - 1.0 / n for n in size]),
    }
    for name in sorted({name for r in rows for name in r.baselines}):
        out |= _scores([(r.baselines[name], r.label) for r in rows if name in r.baselines], f", {name}")
    return out


def _scores(stated: Sequence[tuple[Mapping[str, float], str]], of: str = "") -> Summary:
    """Scores of stated probabilities, each with the right answer."""
    return {
        f"top-1{of}": share([first(p) == label for p, label in stated]),
        f"log score{of}": mean([log_score(p, label) for p, label in stated]),
        f"brier{of}": mean([brier(p, label) for p, label in stated]),
    }


def _over_ceiling(rows: Sequence[Row]) -> Measure:
    """Right answers over those that the ideal observer would give, on the cases whose ceiling is known."""
    some = [(r.right, r.ceiling.top1) for r in rows if r.ceiling is not None]
    if not some:
        return NOTHING
    hits, bound = share([right for right, _ in some]), sum(top1 for _, top1 in some) / len(some)
    return Measure(hits.value / bound, hits.n, hits.low / bound, hits.high / bound)


def said(names: Sequence[str], rows: Sequence[Row]) -> Summary:
    """Scores, and how often a verdict that counts was given, by the names of the measures."""
    kinds = [r.verdict.get("kind") for r in rows]
    counts = {name: share([kind in COUNTED[name] for kind in kinds]) for name in names if name in COUNTED}
    known = _scores([(r.chances, r.label) for r in rows]) | counts
    return {name: known[name] for name in names}


def unknown(rows: Sequence[Row]) -> Summary:
    """Whether a cause outside the catalogue is noticed."""
    return said(UNKNOWN, rows) | {"called unknown, ceiling": mean([unknown_ceiling(r.d) for r in rows])}


def shrinkage(rows: Sequence[Row]) -> Summary:
    """Gap closed on held-out runs against the oracle, and coverage of the stated interval."""
    fractions = [r.closed.fraction for r in rows if r.closed.reducible]
    covered = [r.closed.covered for r in rows if r.closed.covered is not None]
    widths = [r.closed.interval[1] - r.closed.interval[0] for r in rows if r.closed.interval is not None]
    return {
        "closed, median": quantile(fractions, 0.5),
        "closed, 10th percentile": quantile(fractions, 0.1),
        "coverage of 90 %": share([bool(c) for c in covered]),
        "interval, median width": quantile(widths, 0.5),
    }


def calibration(rows: Sequence[Row]) -> dict[str, Summary]:
    """CORP miscalibration of the most probable name, and of all names pooled, with what chance alone would show."""
    if not rows:
        return {}
    best = [(r.chances[r.answer], float(r.right)) for r in rows]
    every = [(p, float(name == r.label)) for r in rows for name, p in r.chances.items()]
    out: dict[str, Summary] = {}
    for name, pairs in (("most probable name", best), ("all names", every)):
        found = corp(*np.array(pairs).T)
        parts = {"miscalibration": found.miscalibration, "by chance": found.expected, "brier": found.brier,
                 "discrimination": found.discrimination, "uncertainty": found.uncertainty}  # fmt: skip
        out[name] = {key: Measure(value, found.n, math.nan, math.nan) for key, value in parts.items()}
    return out


def _known(rows: Sequence[Row], kind: str) -> list[Row]:
    return [r for r in rows if r.kind == kind and r.label not in ("none", "parameters", "unknown")]


def _visible(rows: Sequence[Row]) -> list[Row]:
    return [r for r in rows if r.d >= VISIBLE]


def _subsets(rows: Sequence[Row]) -> dict[str, list[Row]]:
    return {
        "all": list(rows),
        "white": [r for r in rows if not r.coloured],
        "coloured": [r for r in rows if r.coloured],
        "seen excitation": [r for r in rows if not r.unseen],
        "unseen excitation": [r for r in rows if r.unseen],
        "an effect withheld": [r for r in rows if r.decoy],
    }


def _sure(rows: Sequence[Row]) -> Measure:
    wrong = [float(r.verdict.get("probability") or 0.0) >= SURE and not r.class_right for r in rows]
    return share(wrong)
