"""One row per case: what was true and what was answered, ready to be counted."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from .case import tied
from .ceiling import Ceiling, ceiling, leftover
from .closed import Closed
from .measures import first

# Strata of the signal-to-noise ratio d
STRATA = {
    "<3": (0.0, 3.0),
    "3-10": (3.0, 10.0),
    "10-30": (10.0, 30.0),
    "30-100": (30.0, 100.0),
    ">100": (100.0, math.inf),
}


@dataclass(frozen=True)
class Row:
    """A scored case.

    Attributes:
        case, kind, label: name, kind of case, right answer.
        d: signal-to-noise ratio by which it is counted: post-refit, of the weaker effect of a pair, of what the best
            two known effects leave where the right answer is "unknown", of the parameters' change where only those
            are wrong.
        d_single: the same where only single effects are tried on an unknown cause.
        unseen, coloured: excitation other than closed-loop sinusoids; coloured turbulence or sonar noise.
        decoy: whether an effect was withheld that is not the cause.
        chances: stated probabilities, summing to one, under the names that are scored.
        verdict: kind, class and probability as stated.
        refused: the message, or nothing.
        baselines: stated probabilities of simpler methods.
        ceiling: of the ideal observer, where it was computed.
        closed: held-out gaps.
    """

    case: str
    kind: str
    label: str
    d: float
    d_single: float
    unseen: bool
    coloured: bool
    decoy: bool
    chances: dict[str, float]
    verdict: dict[str, Any]
    refused: str
    baselines: dict[str, dict[str, float]]
    ceiling: Ceiling | None
    closed: Closed

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
        kind = self.verdict.get("kind")
        if kind in ("none", "parameters", "unknown"):
            return (str(kind),)
        if kind == "effects":
            return (canonical_name("+".join(self.verdict.get("effects", ()))),)
        names = dict.fromkeys(canonical_name(name) for name in self.verdict.get("class", ()))
        return tuple(names) or (self.answer,)

    @property
    def class_right(self) -> bool:
        """Whether the truth is in the class that was named."""
        return self.label in self.named


def canonical_name(name: str) -> str:
    """The name under which it is scored: tied effects share one, the two of a pair stand in alphabetical order."""
    return "+".join(sorted({tied(part) for part in name.split("+")}))


def chances_of(stated: Mapping[str, float] | Iterable[str]) -> dict[str, float]:
    """Probabilities that sum to one under the names that are scored; a ranking puts everything on its first."""
    if not isinstance(stated, Mapping):
        return {canonical_name(name): 1.0 for name in list(stated)[:1]}
    out: dict[str, float] = {}
    for name, p in stated.items():
        number = float(p) if isinstance(p, int | float) and math.isfinite(p) else 0.0
        out[canonical_name(name)] = out.get(canonical_name(name), 0.0) + max(number, 0.0)
    total = sum(out.values())
    return {name: p / total for name, p in out.items()} if total > 0.0 else {"undecided": 1.0}


def row(case: str, truth: Mapping[str, Any], answer: Mapping[str, Any], closed: Closed) -> Row:
    """The row of one case."""
    document, experiment = answer["document"], truth["experiment"]
    rivals = truth.get("rivals")
    baselines = {name: chances_of(stated) for name, stated in (document.get("baselines") or {}).items() if stated}
    return Row(
        case=case,
        kind=truth["kind"],
        label=truth["label"],
        d=_difficulty(truth),
        d_single=leftover(rivals) if rivals and truth["label"] == "unknown" else _difficulty(truth),
        unseen=bool(experiment["unseen"]),
        coloured=experiment["turbulence"] == "coloured" or experiment["sonar_memory_s"] > 0.0,
        decoy=bool(truth["withheld"]) and truth["kind"] != "left_out",
        chances=chances_of(document["probabilities"]),
        verdict=dict(document["verdict"]),
        refused=str(answer.get("refused", "")),
        baselines=baselines,
        ceiling=ceiling(rivals, truth["d"]) if rivals and truth["kind"] == "single" else None,
        closed=closed,
    )


def _difficulty(truth: Mapping[str, Any]) -> float:
    if truth["label"] == "none":
        return 0.0
    if truth["label"] == "parameters":
        return float(truth["d_parameters"])
    if truth["label"] == "unknown":
        return float(truth["pair"]["d"] if "pair" in truth else truth["d"])
    return float(min(truth["d_each"]))
