"""One row per case: what was true and what was answered, ready to be counted."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .case import tied
from .closed import Closed
from .measures import first

VISIBLE = 10.0  # d from which the bars on naming and closing hold
FAINT = 3.0  # d below which nothing that is said is held against an answer
Span = tuple[int, float, float]  # run from 1, from, to [s]


@dataclass(frozen=True)
class Row:
    """A scored case.

    Attributes:
        case, label: its name and right answer.
        d: signal-to-noise ratio by which it is counted: post-refit, of the weakest of several effects, of what the best
            two known effects leave where the right answer is "unknown", of the parameters' change where only those
            are wrong.
        truth, document: as sealed and as answered.
        chances: stated probabilities, summing to one, under the names that are scored.
        refused: the message, or nothing.
        closed: held-out gaps.
    """

    case: str
    label: str
    d: float
    truth: Mapping[str, Any]
    document: Mapping[str, Any]
    chances: dict[str, float]
    refused: str
    closed: Closed

    @property
    def kind(self) -> str:
        """Kind of case: the family that it was drawn from."""
        return str(self.truth["kind"])

    @property
    def verdict(self) -> Mapping[str, Any]:
        """As stated."""
        return dict(self.document["verdict"])

    @property
    def said(self) -> str:
        """Kind of the verdict."""
        return str(self.verdict.get("kind"))

    @property
    def right_kind(self) -> str:
        """Kind of the verdict that would be right."""
        if self.label in ("none", "parameters", "varying", "unknown"):
            return self.label
        return "effects" if "+" in self.label else "effect"

    @property
    def probability(self) -> float:
        """Of the verdict."""
        return float(self.verdict.get("probability") or 0.0)

    @property
    def visible(self) -> bool:
        """Whether the bars on what is found hold."""
        return self.d >= VISIBLE

    @property
    def answer(self) -> str:
        """The most probable name."""
        return first(self.chances)

    @property
    def right(self) -> bool:
        """Whether the most probable name is the truth."""
        return self.answer == self.label

    @property
    def named(self) -> tuple[str, ...]:
        """The class that was named, under the names that are scored."""
        if self.said in ("none", "parameters", "varying", "unknown"):
            return (self.said,)
        if self.said == "effects":
            return (canonical_name("+".join(self.verdict.get("effects", ()))),)
        names = dict.fromkeys(canonical_name(name) for name in self.verdict.get("class", ()))
        return tuple(names) or (self.answer,)

    @property
    def class_right(self) -> bool:
        """Whether the truth is in the class that was named."""
        return self.label in self.named

    @property
    def fair(self) -> bool:
        """Whether an answer can be held right or wrong: not where all is too faint, or as good as known effects."""
        return self.label == "none" or self.d >= (VISIBLE if self.label == "unknown" else FAINT)

    @property
    def wrong(self) -> bool:
        """Whether something was said that is not so."""
        return self.fair and self.said != "undecided" and not self.class_right

    def windows_found(self) -> tuple[float, float] | None:
        """Share of the true windows' time that is named, and of the time named that is true; None without windows."""
        true = [tuple(span) for cause in self.truth["causes"] for span in cause.get("windows", ())]
        if not true:
            return None
        spans = (self.document.get("where") or {}).get("time_s") or ()
        found = [(int(str(s["run"]).rsplit("_", 1)[-1]), float(s["from"]), float(s["to"])) for s in spans]
        both = sum(max(min(a[2], b[2]) - max(a[1], b[1]), 0.0) for a in true for b in found if a[0] == b[0])
        return both / _length(true), both / max(_length(found), 1e-9)


def _length(spans: Sequence[Span]) -> float:
    return sum(end - start for _, start, end in spans)


def canonical_name(name: str) -> str:
    """The name under which it is scored: tied effects share one, several stand in alphabetical order."""
    return "+".join(sorted({tied(part) for part in name.split("+")}))


def chances_of(
    stated: Mapping[str, float] | Iterable[str], scored: Callable[[str], str] = canonical_name
) -> dict[str, float]:
    """Probabilities that sum to one under the names that are scored; a ranking puts everything on its first."""
    if not isinstance(stated, Mapping):
        return {scored(name): 1.0 for name in list(stated)[:1]}
    out: dict[str, float] = {}
    for name, p in stated.items():
        number = float(p) if isinstance(p, int | float) and math.isfinite(p) else 0.0
        out[scored(name)] = out.get(scored(name), 0.0) + max(number, 0.0)
    total = sum(out.values())
    return {name: p / total for name, p in out.items()} if total > 0.0 else {"undecided": 1.0}


def row(case: str, truth: Mapping[str, Any], answer: Mapping[str, Any], closed: Closed) -> Row:
    """The row of one case."""
    document = answer["document"]
    chances, refused = chances_of(document["probabilities"]), str(answer.get("refused", ""))
    return Row(case, *visible(truth), truth, document, chances, refused, closed)


def visible(truth: Mapping[str, Any]) -> tuple[str, float]:
    """The right answer as far as it can be seen, and d: an effect fainter than FAINT counts as not there."""
    label = truth["label"]
    if not isinstance(label, str):
        raise TypeError(f"label: expected text, found {label!r}")
    if label == "unknown":
        return label, float(truth["pair"]["d"] if "pair" in truth else truth["d"])
    if label == "varying":
        return label, float(min(truth["d_each"]))
    seen = {tied(c["name"]): float(d) for c, d in zip(truth["causes"], truth["d_each"], strict=True) if d >= FAINT}
    if seen:
        return canonical_name("+".join(seen)), min(seen.values())
    return ("parameters", float(truth["d_parameters"])) if label != "none" else ("none", 0.0)
