"""What is asked of every case: a yes or no each, or nothing where the question does not arise."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .measures import Measure, quantile, share
from .rows import Row, canonical_name

SURE, CONFIDENT = 0.95, 0.8  # stated probabilities from which a wrong answer is held against it
VARYING_D = 15.0  # d from which own parameters that differ from run to run must be found
OVERLAP = 0.5  # share of the true windows' time to be named, and of the time named to be true, for windows to be right
EFFECT = ("single", "pair", "triple")


@dataclass(frozen=True)
class Question:
    """A question, the bar in words, and the answer for one case: a yes or no, or nothing."""

    name: str
    bar: str
    ask: Callable[[Any], bool | None]

    def of(self, rows: Sequence[Row]) -> Measure:
        """The share of yes."""
        return share([yes for row in rows if (yes := self.ask(row)) is not None])


def kind_right(r: Row) -> bool | None:
    """Of the kind that would be right, where there is no gap or a visible one."""
    return r.said == r.right_kind if r.visible or r.label == "none" else None


def denied(r: Row) -> bool | None:
    """No gap, or parameters alone, said of a visible gap that is more."""
    kinds = ("none",) if r.label == "parameters" else ("none", "parameters")
    return r.said in kinds if r.visible else None


def alarm(r: Row) -> bool | None:
    """A gap seen where there is none."""
    return r.said not in ("none", "undecided") if r.label == "none" else None


def unknown(r: Row) -> bool | None:
    """A visible cause of no catalogue called unknown."""
    return r.said == "unknown" if r.label == "unknown" and r.visible else None


def channel(r: Row) -> bool | None:
    """Its channel right, where it is called unknown."""
    return r.verdict.get("channel") in [c.get("channel") for c in r.truth["causes"]] if unknown(r) else None


def channel_told(r: Row) -> bool | None:
    """The same as far as it can be told: another channel in which something would do the very same is right, too."""
    alike = [name for c in r.truth["causes"] for name in c.get("channels", ())]
    return r.verdict.get("channel") in alike or channel(r) if unknown(r) else None


def windows(r: Row) -> bool | None:
    """Its windows right, where it is called unknown and acts in windows only."""
    found = r.windows_found() if unknown(r) else None
    return None if found is None else min(found) >= OVERLAP


def called_unknown(r: Row) -> bool | None:
    """A known effect called unknown."""
    return r.said == "unknown" if r.kind in EFFECT and r.right_kind in ("effect", "effects") else None


def named_first(kind: str) -> Callable[[Row], bool | None]:
    """The visible effects of that kind of case named first."""
    return lambda r: r.right if r.kind == kind and r.right_kind in ("effect", "effects") and r.visible else None


def triple(r: Row) -> bool | None:
    """Three visible effects all named, or nothing named confidently."""
    return r.class_right or r.probability < CONFIDENT if r.kind == "triple" and r.visible else None


def varying(r: Row) -> bool | None:
    """Own parameters that differ from run to run found, the right one among those named."""
    if r.kind != "varying" or r.d < VARYING_D or r.truth["experiment"]["runs"] < 2:
        return None
    found = r.verdict.get("varying") or ()
    return r.said == "varying" and all(c["name"] in found for c in r.truth["causes"])


def in_set(r: Row) -> bool | None:
    """The truth in the stated set of causes."""
    stated = r.document.get("cause_set")
    return None if stated is None or not r.fair else r.label in {canonical_name(str(name)) for name in stated}


def budget(line: str) -> Callable[[Row], bool | None]:
    """The true share of a line of the budget within its stated interval, where it is named and can be computed."""

    def ask(r: Row) -> bool | None:
        lines = [entry for entry in r.document.get("budget") or () if entry.get("kind") == line]
        true = (r.truth.get("budget") or {}).get("cause" if line in ("effect", "repeatable") else line)
        wanted = {"effect": ("effect",), "repeatable": ("unknown",)}.get(line, (r.right_kind,))
        if true is None or len(lines) != 1 or r.right_kind not in wanted or not lines[0].get("interval90"):
            return None
        low, high = lines[0]["interval90"]
        return bool(low <= true <= high)

    return ask


QUESTIONS = (
    Question("kind right", "", kind_right),
    Question("undecided", "", lambda r: r.said == "undecided"),
    Question("none or parameters over a visible gap", "<= 0.005", denied),
    Question("false alarm", "0.005 to 0.02", alarm),
    Question("unknown called unknown", ">= 0.90", unknown),
    Question("its channel", "", channel),
    Question("its channel, as far as it can be told", ">= 0.85", channel_told),
    Question("its windows", ">= 0.80", windows),
    Question("known called unknown", "<= 0.03", called_unknown),
    Question("single first", ">= 0.97", named_first("single")),
    Question("pair first", ">= 0.85", named_first("pair")),
    Question("triple first", "", named_first("triple")),
    Question("triple right or not confident", ">= 0.90", triple),
    Question("varying found", ">= 0.90", varying),
    Question("wrong at 0.95", "<= 0.01", lambda r: r.wrong and r.probability >= SURE),
    Question("wrong at 0.8", "", lambda r: r.wrong and r.probability >= CONFIDENT),
    Question("stated set holds the truth", ">= 0.95", in_set),
    Question("interval of the gap closed", "0.86 to 0.94", lambda r: r.closed.covered),
    *(Question(f"budget interval, {line}", "0.86 to 0.94", budget(line))
      for line in ("parameters", "effect", "repeatable", "disturbance", "noise")),
    Question("refused", "", lambda r: bool(r.refused)),
)  # fmt: skip
CLOSED = "gap closed, median"  # on held-out runs, where the oracle closes all of it


def measures(rows: Sequence[Row]) -> dict[str, Measure]:
    """Every question's share of yes, and the gap closed."""
    fractions = [r.closed.fraction for r in rows if r.closed.reducible and r.visible]
    return {q.name: q.of(rows) for q in QUESTIONS} | {CLOSED: quantile(fractions, 0.5)}


def by(rows: Sequence[Row], key: Callable[[Row], str]) -> Mapping[str, list[Row]]:
    """The rows of each group, in alphabetical order."""
    return {name: [r for r in rows if key(r) == name] for name in sorted({key(r) for r in rows})}
