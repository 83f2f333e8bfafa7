"""`vtank blind score`: verify every hash, score every case, and write tables, figures and one JSON file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...present import Picture
from ...present.document import html, markdown
from ...record import Kind, results_folder
from ..processes import processes
from ..stage import Stage, silent
from .calibration import corp
from .closed import closed
from .measures import Measure
from .questions import by, measures
from .rows import Row, row
from .scheme import Scheme
from .tables import BARS, RULES, TITLE, cases_csv, measures_csv, page, tables
from .verify import Opened, open_all

RESULTS = Kind("results of vtank blind score", "score.json", "vtank.blind-score/2")
Groups = dict[str, dict[str, dict[str, Measure]]]  # group -> member -> measure


def scheme_of(vehicles: bool) -> Scheme:
    """The scheme of single-axis trials, or of whole vehicles."""
    if vehicles:
        from .whole.scheme import WHOLE

        return WHOLE
    return SINGLE


def score(
    folder: Path, truth: Path, answers: Path, count: int = 2, stage: Stage = silent, published: str | None = None
) -> dict[str, Any]:
    """Rows, measures and what was checked; InputError where a hash does not hold, `published` among them if given."""
    opened = open_all(folder, truth, answers, published)
    rows, scheme = [], scheme_of(opened.vehicles)
    with processes(count) as work, stage("scoring", len(opened.truths)) as advance:
        for one in work(partial(_row, opened, truth), list(opened.truths)):
            rows.append(one)
            advance(one.case)
    found = {"rows": rows, "sources": opened.sources, "checked": opened.checked, "measures": grouped(rows, scheme)}
    return found | {"scheme": scheme}


def _row(opened: Opened, truth: Path, case: str) -> Any:
    scheme = scheme_of(opened.vehicles)
    try:
        found = scheme.row(opened, truth, case)
        grouped([found], scheme), scheme.csv([found])  # all that is asked of it
        return found
    except InputError as reason:
        raise InputError(f"{case}: {reason}") from None
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        what = f"{type(error).__name__}: {error}"
        raise InputError(f"{case}: truth or answer is not as vtank writes it ({what})") from error


def _single_row(opened: Opened, truth: Path, case: str) -> Row:
    sealed, answer = opened.truths[case], opened.answers[case]
    return row(case, sealed, answer, closed(case, sealed, answer, truth))


def grouped(rows: Sequence[Any], scheme: Scheme | None = None) -> Groups:
    """All measures of all cases, and of those of every family, law, noise and so on."""
    scheme = scheme or SINGLE
    out: Groups = {"all": {"all": scheme.measures(rows) | calibration(rows)}}
    for name, key in scheme.groups.items():
        out[name] = {member: scheme.measures(some) for member, some in by(rows, key).items() if member}
    return out


def calibration(rows: Sequence[Row]) -> dict[str, Measure]:
    """CORP miscalibration of the most probable name, with what chance alone would show."""
    fair = [(r.chances[r.answer], float(r.right)) for r in rows if r.fair]
    if not fair:
        return {}
    found = corp(*np.array(fair).T)
    values = {"miscalibration": found.miscalibration, "miscalibration by chance": found.expected, "brier": found.brier}
    return {name: Measure(value, found.n, math.nan, math.nan) for name, value in values.items()}


def write_score(out: Path, scored: dict[str, Any]) -> None:
    """Write the score as Markdown, HTML and JSON, the cases and tables as CSV, and the figures into a folder."""
    groups, rows, scheme = scored["measures"], scored["rows"], scored["scheme"]
    drawn = scheme.draw(rows)
    pictures = [Picture(name, caption) for name, (caption, _) in drawn.items()]
    blocks = page(tables(groups, scheme.bars), scheme.rules, scored["sources"], scored["checked"], pictures)
    files: dict[str, str | bytes] = {
        "score.md": markdown(blocks),
        "score.html": html(TITLE, blocks),
        "cases.csv": scheme.csv(rows),
        "measures.csv": measures_csv(groups),
        **{name: png for name, (_, png) in drawn.items()},
    }
    about = {"sources": scored["sources"], "checked": scored["checked"], "cases": len(rows), "measures": groups}
    with results_folder(out, RESULTS, about) as folder:
        for name, content in files.items():
            (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)


def _drawn(rows: Sequence[Row]) -> dict[str, tuple[str, bytes]]:
    from .figures import draw_all  # matplotlib takes a while to load

    return draw_all(rows)


SINGLE = Scheme(
    row=_single_row,
    groups={
        "family": lambda r: r.kind,
        "law": lambda r: r.truth["causes"][0]["name"] if r.label in ("unknown", "varying") else "",
        "noise": lambda r: r.truth["experiment"]["noise"],
        "turbulence": lambda r: r.truth["experiment"]["turbulence"],
        "vehicle": lambda r: r.truth["experiment"]["vehicle"],
        "excitation": lambda r: r.truth["experiment"]["family"],
        "rate": lambda r: f"{r.truth['experiment']['rate_hz']} Hz",
        "runs": lambda r: str(r.truth["experiment"]["runs"]),
    },
    measures=measures,
    bars=BARS,
    rules=RULES,
    csv=cases_csv,
    draw=_drawn,
)
