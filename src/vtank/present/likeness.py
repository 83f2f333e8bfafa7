"""How like another's simulator the plant is that stands for it, in a sentence and in tables."""

from __future__ import annotations

from typing import Any

from .blocks import Paragraph, Table
from .numbers import number, percent

Document = dict[str, Any]


def sentence(document: Document) -> str:
    """What stands for the simulator, how much it misses of it, and what that leaves open."""
    found, many = document["against"], len(document["against"]["runs"])
    said = f"A plant fitted to {many} run{'s' * (many > 1)} in {found['folder']} stands for the simulator. It misses "
    said += f"{percent(found['share'])} of what the simulator does"
    if found["of_gap"] is not None:
        beside = f"{number(found['of_gap'], 2)} times" if found["of_gap"] > 1.0 else f"{percent(found['of_gap'])} of"
        said += f", a mean square of {beside} the gap"
        named = found["of_gap"] > 1.0 and document["verdict"]["kind"] in ("effect", "effects", "unknown")
        said += " in free runs, yet far less of it step by step" if named else "; what is smaller cannot be told"
    if found["refused"]:
        said += f". It misses too much of {', '.join(found['refused'])}: of what only these show, nothing is known"
    return said + "."


def tables(document: Document) -> tuple[Paragraph | Table, ...]:
    """Likeness by column, and what was fitted."""
    found = document["against"]
    columns = tuple(
        (name, number(c["error"]), number(c["moves"]), percent(c["error"] / c["moves"] if c["moves"] else 1.0))
        for name, c in found["columns"].items()
    )
    fitted = tuple(
        (p["name"], "" if p["before"] is None else number(p["before"]), number(p["fitted"]))
        for p in found["parameters"]
    )
    return (
        Paragraph(sentence(document)),
        Table(("column", "error of the plant", "what it does", "share"), columns,
              title="Root mean square against the simulator's own runs, each column in its unit"),
        Table(("fitted to the simulator", "before", "found"), fitted, title="The plant, in SI"),
    )  # fmt: skip
