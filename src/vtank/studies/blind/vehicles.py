"""The vehicles of the trials: their files, and the nominal simulators that the diagnosis is given."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ...plant import Truth, load_truth

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Craft:
    """A vehicle in the trials: its file and its nominal's, names or paths, and its share of the cases."""

    vehicle: str
    nominal: str
    share: float

    @property
    def truth(self) -> Truth:
        """The nominal simulator."""
        return nominal_truth(self.nominal)


nominal_truth = cache(load_truth)
FLEET = {
    "phoenix": Craft("phoenix", "paper-ii", 0.5),
    "bluerov2": Craft("bluerov2", "bluerov2", 0.25),
    "courier": Craft(str(HERE / "courier.toml"), str(HERE / "courier-truth.toml"), 0.25),
}
