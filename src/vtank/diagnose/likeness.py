"""How like a simulator a plant is that was fitted to its runs, and whether that is enough to say anything."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import InputError

POOR = 0.5  # share of what a column does that a plant may miss; a choice


@dataclass(frozen=True)
class Likeness:
    """A fitted plant held against the simulator's own runs.

    Attributes:
        folder: of the runs, or what stands for it. runs: their names.
        columns: `error` of the plant's simulation, and what the column `moves` by, root mean squares in its unit.
        share: of the motion that the plant misses, root mean square over the columns that tell something.
        parameters: name, number before the fit (None where there was none), and the fitted one, SI.
    """

    folder: str
    runs: tuple[str, ...]
    columns: Mapping[str, Mapping[str, float]]
    share: float
    parameters: tuple[tuple[str, float | None, float], ...]

    @property
    def refused(self) -> tuple[str, ...]:
        """Columns that the plant misses too much of; of what only they show, nothing is known."""
        return tuple(name for name, c in self.columns.items() if c["error"] > POOR * c["moves"])

    @property
    def document(self) -> dict[str, Any]:
        """As plain data."""
        fitted = [{"name": name, "before": before, "fitted": value} for name, before, value in self.parameters]
        return {"folder": self.folder, "runs": list(self.runs), "share": self.share, "refused": list(self.refused),
                "columns": {name: dict(c) for name, c in self.columns.items()}, "parameters": fitted}  # fmt: skip

    def checked(self) -> Likeness:
        """Itself; InputError where the plant is too unlike the simulator to say anything."""
        if self.share > POOR:
            worst = max(
                self.columns, key=lambda name: self.columns[name]["error"] / (self.columns[name]["moves"] or 1.0)
            )
            raise InputError(
                f"the simulator's runs in {self.folder}: the plant that was fitted misses {100.0 * self.share:.0f} % of "
                f"what they do, most of all of {worst}; up to {100.0 * POOR:.0f} % is borne. Nothing can be said of a "
                "gap relative to it. Are the inputs, units and signs of these runs right, and do they move as much as "
                "the recordings?"
            )
        return self
