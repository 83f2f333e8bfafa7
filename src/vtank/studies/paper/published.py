"""The paper's printed numbers, with what is doubtful about them, from published.toml beside this file."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ...estimate.paper import Array, Model
from ...record import open_table

FILE = Path(__file__).with_name("published.toml")
SETS = 4  # data sets of the paper
PARAMETERS = ("a", "b", "gamma", "tau")
OF_MODEL: dict[str, tuple[str, ...]] = {"I": ("a", "b"), "II": ("a", "b", "tau"), "III": PARAMETERS}
RESIDUALS = ("mean", "deviation", "mean_absolute")
UNITS = {"a": "1/ft", "b": "ft/rev2", "gamma": "1/rev", "tau": "s"} | {name: "ft/s" for name in RESIDUALS}


@dataclass(frozen=True)
class Doubt:
    """Printed numbers that are no target, and why; sets count from 1; "*" is the paper's own mark, "?" ours."""

    quantities: tuple[str, ...]
    sets: tuple[int, ...]
    mark: str
    reason: str


@dataclass(frozen=True)
class PublishedTable:
    """One table of the paper, in its feet: quantity -> values of data sets 1 to 4, shape (4,); NaN: not printed."""

    number: int
    title: str
    model: Model
    values: dict[str, Array]
    doubts: tuple[Doubt, ...]
    notes: tuple[str, ...]

    @property
    def quantities(self) -> tuple[str, ...]:
        """Rows of the table, in the paper's order, without q_ii."""
        return tuple(name for name in (*PARAMETERS, *RESIDUALS) if name in self.values)

    def mark(self, quantity: str, data_set: int) -> str:
        """ "*", "?" or nothing, for a number of a data set counted from 1."""
        return next((d.mark for d in self.doubts if quantity in d.quantities and data_set in d.sets), "")


@cache
def published() -> dict[int, PublishedTable]:
    """Tables 1 to 4 by number."""
    content = open_table(FILE).entries
    return {number: _table(number, content[f"table-{number}"]) for number in (1, 2, 3, 4)}


@cache
def brutzman_a_per_ft() -> float:
    """Quadratic drag over moving mass in Brutzman's model of the same vehicle [1/ft]."""
    return float(open_table(FILE).entries["brutzman"]["a"])


def _table(number: int, content: dict[str, Any]) -> PublishedTable:
    values = {name: np.array(content[name]) for name in ("q_ii", *PARAMETERS, *RESIDUALS) if name in content}
    doubts = tuple(Doubt(tuple(d["quantities"]), tuple(d["sets"]), d["mark"], d["reason"]) for d in content["doubts"])
    return PublishedTable(number, content["title"], content["model"], values, doubts, tuple(content.get("notes", ())))
