"""The page of findings: what holds, what does not, each sentence filled from the results."""

from __future__ import annotations

from ...present import Block, Heading, Paragraph, Table
from .calibration import Calibration
from .central import CENTRAL, size
from .claims import CLAIMS, printed_q
from .evidence import (
    FAILS,
    HIGH_DRAG,
    HOLDS,
    LOW_DRAG,
    NAMES,
    Results,
    band,
    compatible,
    filled,
    implied_medians,
    interval,
    span,
)
from .published import brutzman_a_per_ft, published
from .records import CASES
from .study import Study


def page(r: Results) -> list[Block]:
    """The whole page."""
    return [
        Heading("Findings: the published drag and the paper's estimator", 1),
        Paragraph(summary(r)),
        Heading("What the estimator does"),
        *(finding(r).block for finding in CENTRAL),
        parts_table(r.study),
        implied_table(r.calibration),
        Heading("What the data does not support, or only in part"),
        *(finding(r).block for finding in CLAIMS),
        Heading("How this was found"),
        Paragraph(method(r)),
    ]


def summary(r: Results) -> str:
    """The answer in one paragraph."""
    implied, other = (implied_medians(r.calibration, "least_squares", base) for base in (LOW_DRAG, HIGH_DRAG))
    return filled(
        "summary",
        printed=span(published()[2].values["a"] / brutzman_a_per_ft(), 0),
        compatible=compatible(r.calibration, "kalman", LOW_DRAG),
        implied=span(implied, 0),
        other=span(other, 0),
        steadiness="speaks against" if printed_q(r).verdict == FAILS else "does not rule out",
        reach="is large enough to explain" if size(r).verdict == HOLDS else "does not reach",
    )


PARTS = {
    "exact": "time step alone",
    "filter u": "sonar filter on u",
    "filter u,n": "sonar filter on u and n",
    "noise": "noise in u alone",
    "recorded": "all, as recorded",
}


def parts_table(s: Study) -> Table:
    """Medians and bands of a for every part of the error."""
    rows = []
    for method in ("least_squares", "kalman"):
        for case in CASES:
            bands = (band(s.band(t, s.level("part", case, method), "a"), 3) for t in s.truths)
            rows.append((NAMES[method], PARTS[case], *bands))
    header = ("a [1/ft], Model II", "what acts", *(f"{t} (truth {v[0]:.3f})" for t, v in s.truths.items()))
    return Table(header, tuple(rows), ("Median and 10-90 % over seeds and data sets 1 to 4, T = 0.5 s.",), left=2)


def implied_table(c: Calibration) -> Table:
    """True drag behind each published value."""
    rows = []
    for number, method in ((2, "kalman"), (4, "two_stage"), (2, "least_squares")):
        for data_set, a in enumerate(published()[number].values["a"].tolist()):
            cells = [interval(*c.implied(base, method, data_set, a)) for base in (LOW_DRAG, HIGH_DRAG)]
            name, word = f"Table {number} as if by {NAMES[method]}", f"{a / brutzman_a_per_ft():.0f}"
            rows.append((name, str(data_set + 1), word, *cells))
    with_base = (f"with thrust and lag of {base}" for base in (LOW_DRAG, HIGH_DRAG))
    note = (
        "True drag over Brutzman's behind the published a: where the median of the estimate equals it and, in "
        f"brackets, all true drags whose 10-90 % band holds it, of {c.multiples[0]:g} to {c.multiples[-1]:g} that "
        "were tried. A dash: none does."
    )
    return Table(("published", "data set", "at its word", *with_base), tuple(rows), (note,), left=2)


def method(r: Results) -> str:
    """What was simulated."""
    ways = len({level.key for level in r.study.levels})
    return filled("method", seeds=r.study.seeds, seed=r.study.seed, truths=len(r.study.truths), ways=ways)
