"""What is asked of the cases of whole vehicles, and the tables that come of it."""

from __future__ import annotations

from collections.abc import Sequence

from ....present.document import csv_text
from ..measures import Measure, quantile, share
from ..questions import SURE, Question, alarm, called_unknown, denied, kind_right, named_first, unknown
from ..rows import VISIBLE
from ..scheme import Scheme
from .rows import WholeRow, row

CLOSED, COVERED = "gap closed against the oracle, median", "coverage of 95 % intervals"
RULES = (
    "Cells: value [95 % interval] (cases); interval of a proportion: Wilson. d is the signal-to-noise ratio that the "
    "best refit of the vehicle's own parameters leaves, against the same flights without the cause; a gap is visible "
    f"from {VISIBLE:g}. Names of one law count as one: a clock that is ahead is a late instrument, a wrong unit or "
    "sign is a factor. The oracle is the true effect fitted to the same runs; gaps are those of free simulation, in "
    "deviations of the channels' noise. An interval counts where it is below half of its prior's, and the cause right. "
)
CASES = ("case", "kind", "truth", "place_kind", "d", "vehicle", "runs", "verdict", "probability", "answer", "p_truth",
         "class", "wrong", "gap_refit", "gap_oracle", "gap_diagnosed", "covered", "intervals", "refused")  # fmt: skip


def place(r: WholeRow) -> bool | None:
    """The place of a visible effect right, where the effect is."""
    return r.place_right if r.kind == "single" and r.visible and r.effect_right else None


def unknown_place(r: WholeRow) -> bool | None:
    """The axis of a visible cause of no catalogue right, where it is called unknown."""
    if unknown(r) is not True:
        return None
    return any(str(name).endswith(f"@{p}") for name in r.truth["effects"] for p in r.verdict.get("places", ()))


def invented(r: WholeRow) -> bool | None:
    """An effect, or an unknown cause, seen where there is none."""
    return r.said not in ("none", "parameters", "undecided") if r.label in ("none", "parameters") else None


QUESTIONS = (
    Question("effect and place first", ">= 0.90", named_first("single")),
    Question("place right given the effect", ">= 0.95", place),
    Question("wrong class at 0.95", "<= 0.01", lambda r: r.wrong and r.probability >= SURE),
    Question("false alarm", "0.005 to 0.02", alarm),
    Question("effect seen where there is none", "", invented),
    Question("unknown called unknown", ">= 0.85", unknown),
    Question("its axis", "", unknown_place),
    Question("known called unknown", "", called_unknown),
    Question("none or parameters over a visible gap", "", denied),
    Question("kind right", "", kind_right),
    Question("undecided", "", lambda r: r.said == "undecided"),
    Question("visible", "", lambda r: r.visible if r.label != "none" else None),
    Question("refused", "", lambda r: bool(r.refused)),
)


def measures(rows: Sequence[WholeRow]) -> dict[str, Measure]:
    """Every question's share of yes, the gap closed, and the coverage."""
    fractions = [r.closed.fraction for r in rows if r.kind == "single" and r.visible and r.closed.reducible]
    intervals = [hit for r in rows if r.class_right for hit in r.covered_each]
    return {q.name: q.of(rows) for q in QUESTIONS} | {CLOSED: quantile(fractions, 0.5), COVERED: share(intervals)}


def cases_csv(rows: Sequence[WholeRow]) -> str:
    """One line per case."""
    lines = [
        (r.case, r.kind, r.label, r.place_kind, f"{r.d:.4g}", r.truth["vehicle"], r.truth["given"], r.said,
         f"{r.probability:.4f}", r.answer, f"{r.chances.get(r.label, 0.0):.4f}", " ".join(r.named), r.wrong,
         r.closed.refit, r.closed.oracle, r.closed.diagnosed, sum(r.covered_each), len(r.covered_each), r.refused)
        for r in rows
    ]  # fmt: skip
    return csv_text(CASES, lines, blank=True)


def _drawn(rows: Sequence[WholeRow]) -> dict[str, tuple[str, bytes]]:
    from ..figures import draw_all  # matplotlib takes a while to load

    return draw_all(rows, ("reliability.png",))


WHOLE = Scheme(
    row=row,
    groups={
        "family": lambda r: r.kind,
        "vehicle": lambda r: str(r.truth["vehicle"]),
        "kind of place": lambda r: r.place_kind,
        "effect": lambda r: r.label.partition("@")[0] if r.kind == "single" else "",
    },
    measures=measures,
    bars={q.name: q.bar for q in QUESTIONS} | {CLOSED: ">= 0.95", COVERED: "0.93 to 0.97"},
    rules=RULES,
    csv=cases_csv,
    draw=_drawn,
)
