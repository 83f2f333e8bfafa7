"""What a loop did and came to, as a table and sentences, and as plain data."""

from __future__ import annotations

from typing import Any

from ...present import Block, Paragraph, Table
from .loop import Explored, Step, answer_of
from .planner import Plan

ENDS = {
    "decided": "decided",
    "tied": "no run of these decides between what is left",
    "seen": "no run of these shows more",
    "minutes": "the minutes are spent",
}


def told(explored: Explored) -> list[Block]:
    """One line for each run, then the answer and what comes next."""
    header = ("run", "minutes", "expected [nats]", "answer", "probability")
    rows = tuple(_row(step) for step in explored.steps)
    return [Table(header, rows, left=1, name="explored"), Paragraph(_sentence(explored)), *_next(explored)]


def _row(step: Step) -> tuple[str, ...]:
    answer = answer_of(step.diagnosis)
    words = step.plan.candidate.words
    return words, f"{step.minutes:.1f}", f"{step.plan.drop:.2f}", answer, f"{step.diagnosis.verdict.probability:.2f}"


def _sentence(explored: Explored) -> str:
    minutes = explored.steps[-1].minutes
    return f"{explored.answer}, {100.0 * explored.chance:.0f} %, after {minutes:.1f} min: {ENDS[explored.ended]}."


def _next(explored: Explored) -> list[Block]:
    if explored.sensor:
        name, channels, apart = explored.sensor
        kind = name.removeprefix("added_").replace("_", " ")
        return [Paragraph(f"A sensor decides: {kind} ({', '.join(channels)}), {apart:.1f} deviations between the two.")]
    if explored.ended == "tied":
        return [Paragraph("No usual instrument decides between the two either.")]
    return [] if explored.ended == "decided" or explored.plan is None else [advice(explored.plan)]


def advice(plan: Plan) -> Paragraph:
    """The run that comes next, in words."""
    return Paragraph(
        f"Next: {plan.candidate.words}, {plan.candidate.minutes:.1f} min, from which a drop of the doubt of "
        f"{plan.drop:.2f} nats at least is expected."
    )


def document(explored: Explored) -> dict[str, Any]:
    """As plain data, schema vtank.explored/1."""
    return {
        "schema": "vtank.explored/1", "answer": explored.answer, "chance": explored.chance, "ended": explored.ended,
        "minutes": explored.steps[-1].minutes,
        "runs": [{"run": s.plan.candidate.words, "minutes": s.minutes, "expected_nats": s.plan.drop,
                  "answer": answer_of(s.diagnosis), "probability": s.diagnosis.verdict.probability}
                 for s in explored.steps],
        "sensor": None if explored.sensor is None else dict(zip(("name", "channels", "apart"), explored.sensor,
                                                                strict=True)),
        "next": None if explored.plan is None else explored.plan.candidate.text,
    }  # fmt: skip
