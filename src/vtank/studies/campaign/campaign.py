"""A campaign: many runs described by one file, each of them planned from its number alone."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...experiment import Plan, Scenario, plan_run, read_scenario
from ...plant import Truth
from ...record import Table, parse
from .axes import Axis, Draw

# Keys of [grid] and [draw] beside those of scenarios
SCENARIO, TRUTH, SEED = "scenario", "truth", "seed"
BESIDE = ("vehicle", "walls")  # keys of scenarios that may name a file, which lies beside the one that names it
LUMPED = ("lumped.alpha_per_m", "lumped.beta_m_per_rev2")  # in place of the truth's; gamma and tau are effects


@dataclass(frozen=True)
class Campaign:
    """Runs 0, 1, ... of a campaign: every combination of the grid, the last key fastest, each `repeats` times.

    It holds the text of all files it needs, so that it can be sent to another machine.

    Attributes:
        name: the file's.
        text: of the file.
        model: "tank" or "surge".
        seed: of the draws, and of the noise where the grid has no seeds.
        repeats: runs of each combination of the grid.
        grid, draws: what varies.
        scenarios: scenario as named in the campaign -> text of its file.
        truths: truth preset as named in the campaign or in a scenario -> the preset.
        files: vehicle or walls file as named in the campaign or in a scenario -> its path.
        samples: of the longest run among those tried.
        periods: of a tick, of all runs [s].
        slots: of the parameter vector that are not null in every run.
    """

    name: str
    text: str
    model: str
    seed: int
    repeats: int
    grid: tuple[Axis, ...]
    draws: tuple[Draw, ...]
    scenarios: Mapping[str, str]
    truths: Mapping[str, Truth]
    files: Mapping[str, str] = field(default_factory=dict)
    samples: int = 0
    periods: frozenset[float] = frozenset()
    slots: frozenset[int] = frozenset()

    def __len__(self) -> int:
        """Number of runs."""
        return self.repeats * math.prod(len(axis.values) for axis in self.grid)

    @property
    def varied(self) -> tuple[str, ...]:
        """Keys that the campaign sets."""
        return tuple([axis.key for axis in self.grid] + [draw.key for draw in self.draws])

    def choice(self, number: int) -> dict[str, Any]:
        """Key -> value of a run."""
        places = np.unravel_index(number // self.repeats, [len(axis.values) for axis in self.grid])
        chosen = {axis.key: axis.values[place] for axis, place in zip(self.grid, places, strict=True)}
        return chosen | {draw.key: draw.value(self.seed, number) for draw in self.draws}

    def plan(self, number: int, choice: Mapping[str, Any]) -> Plan:
        """The plan of a run; InputError where its values do not go together, or lead into a wall."""
        return self.renumbered(plan_run(self.scenario(choice), truth=self.truth(choice)), number, choice)

    def renumbered(self, plan: Plan, number: int, choice: Mapping[str, Any]) -> Plan:
        """The plan with the name and the noise of another run that has the same values.

        Every run has noise of its own, except that runs of one seed share it where the grid has seeds.
        """
        shared = SEED in choice
        return replace(plan, seed=choice.get(SEED, self.seed), run=0 if shared else number, name=self.run_name(number))

    def run_name(self, number: int) -> str:
        """Name of a run: run_007 of up to 1000."""
        return f"run_{number:0{len(str(len(self) - 1))}d}"

    def scenario(self, choice: Mapping[str, Any]) -> Scenario:
        """The scenario of a run; InputError names scenario and key."""
        name = choice[SCENARIO]
        entries = _parsed(self.scenarios[name])
        for key, value in choice.items():
            if key not in (SCENARIO, TRUTH, SEED, *LUMPED):
                entries = _laid_over(entries, key.split("."), value)
        beside = {key: self.files[entries[key]] for key in BESIDE if str(entries.get(key)) in self.files}
        return read_scenario(Table(Path(f"{Path(name).stem}.toml"), "", entries | beside))

    def truth(self, choice: Mapping[str, Any]) -> Truth:
        """The truth preset of a run, with the campaign's own alpha and beta."""
        own = _parsed(self.scenarios[choice[SCENARIO]]).get("truth", "paper-ii")
        preset = self.truths[choice.get(TRUTH, own)]
        alpha, beta = choice.get(LUMPED[0], preset.alpha_per_m), choice.get(LUMPED[1], preset.beta_m_per_rev2)
        return replace(preset, alpha_per_m=float(alpha), beta_m_per_rev2=float(beta))


@functools.lru_cache(maxsize=64)
def _parsed(text: str) -> dict[str, Any]:
    return parse(text, "scenario")


def _laid_over(entries: dict[str, Any], path: list[str], value: Any) -> dict[str, Any]:
    """A copy of nested tables with one entry set; what is not on its path is shared."""
    name, *rest = path
    if not rest:
        return entries | {name: value}
    inner = entries.get(name, {})
    if not isinstance(inner, dict):
        raise InputError(f"{name}: is a value and not a table")
    return entries | {name: _laid_over(inner, rest, value)}
