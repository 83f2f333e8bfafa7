"""How like a simulator a plant is that was fitted to its runs, and whether that is enough to say anything."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from ..errors import InputError

Said = TypeVar("Said", bound=Any)
POOR = 0.5  # share of what a column does that a plant may miss; a choice


@dataclass(frozen=True)
class Likeness:
    """A fitted plant held against the simulator's own runs.

    Attributes:
        folder: of the runs, or what stands for it. runs: their names.
        columns: `error` of the plant's simulation, and what the column `moves` by, root mean squares in its unit.
        share: of the motion that the plant misses, root mean square over the columns that tell something.
        parameters: name, number before the fit (None where there was none), and the fitted one, SI.
        of_gap: mean square that the plant misses of the simulator over that which it misses of the recordings, beyond
            their noise; None where that is nothing, or not known yet.
    """

    folder: str
    runs: tuple[str, ...]
    columns: Mapping[str, Mapping[str, float]]
    share: float
    parameters: tuple[tuple[str, float | None, float], ...]
    of_gap: float | None = None

    @property
    def refused(self) -> tuple[str, ...]:
        """Columns that the plant misses too much of; of what only they show, nothing is known."""
        return tuple(name for name, c in self.columns.items() if c["error"] > POOR * c["moves"])

    @property
    def hides(self) -> bool:
        """Whether what the plant misses of the simulator could be all of the gap."""
        return self.of_gap is None or self.of_gap > 1.0

    @property
    def document(self) -> dict[str, Any]:
        """As plain data."""
        fitted = [{"name": name, "before": before, "fitted": value} for name, before, value in self.parameters]
        return {"folder": self.folder, "runs": list(self.runs), "share": self.share, "of_gap": self.of_gap,
                "refused": list(self.refused), "columns": {name: dict(c) for name, c in self.columns.items()},
                "parameters": fitted}  # fmt: skip

    def beside(self, gap: Mapping[str, tuple[float, float]]) -> Likeness:
        """Beside the gap: by column the plant's error on the recordings, and their noise, root mean squares."""
        both = [(c["error"], *gap[name]) for name, c in self.columns.items() if name in gap]
        found = sum(max(e * e / (n * n) - 1.0, 0.0) for _, e, n in both)
        return replace(self, of_gap=sum(m * m / (n * n) for m, _, n in both) / found if found else None)

    def checked(self) -> Likeness:
        """Itself; InputError where the plant is too unlike the simulator to say anything."""
        if self.share > POOR:
            worst = max(self.columns.items(), key=lambda item: item[1]["error"] / (item[1]["moves"] or 1.0))[0]
            raise InputError(
                f"the simulator's runs in {self.folder}: the plant fitted to them misses {100.0 * self.share:.0f} % of "
                f"what they do, most of all of {worst}; up to {100.0 * POOR:.0f} % is borne. Nothing can be said of a "
                "gap relative to it. Are the inputs, units and signs of these runs right, and do they move as much as "
                "the recordings?"
            )
        return self


def doubted(verdict: Said, like: Likeness) -> Said:
    """A verdict, or that it is undecided: where the plant may miss more than the gap is, no cause is named."""
    if like.hides and verdict.kind in ("effect", "effects", "varying", "unknown"):
        return replace(verdict, kind="undecided", doubt="likeness")
    return verdict
