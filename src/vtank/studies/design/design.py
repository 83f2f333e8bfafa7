"""A better plan: of the experiments that fit the tank, those with the smallest bounds for the same time.

What is made small is the sum of the squared relative bounds in the time that a given plan takes, rest between runs
included. The search starts from the given plan too, so that it never ends worse.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from pathlib import Path

import numpy as np

from ...experiment import as_toml, plan_run, simulate_tank
from ..stage import Stage, silent
from .candidates import clearance_m, library
from .flown import Array, Flown
from .information import Information, information
from .search import Search
from .sensitivity import sensitivity
from .study import Study

REST_MIN = 1.0  # [min] between runs, for the water to come to rest and the vehicle to its place; a guess
LENGTHS_MIN = (0.5, 1.0, 2.0, 4.0)  # of a run
STARTS = 20  # random plans from which a search starts, beside the given plan and none


@dataclass(frozen=True, eq=False)
class Item:
    """A run that may be part of a plan."""

    words: str
    flown: Flown
    information: Information

    @property
    def minutes(self) -> float:
        """With the rest after it [min]."""
        return self.information.minutes + REST_MIN


@dataclass(frozen=True, eq=False)
class Design:
    """A plan that was found beside the one that was given, in no more time.

    Attributes:
        items: its runs.
        given: the runs of the given plan.
        free: parameters whose bounds are made small.
    """

    items: tuple[Item, ...]
    given: tuple[Item, ...]
    free: tuple[str, ...]

    def relative(self, items: Sequence[Item]) -> Array:
        """Relative bounds of the parameters by these runs, shape (P,)."""
        return np.asarray(np.sqrt(np.diag(summed(items).covariance(self.free))))

    @property
    def gain(self) -> Array:
        """Bounds of the given plan over those of the new one, shape (P,)."""
        return self.relative(self.given) / self.relative(self.items)

    @property
    def gain_per_minute(self) -> Array:
        """The same at equal time, since a bound falls with the root of the time, shape (P,)."""
        return self.gain * np.sqrt(minutes(self.given) / minutes(self.items))

    def counted(self) -> list[tuple[int, Item]]:
        """How often each run is made."""
        counts = Counter(item.words for item in self.items)
        first = {item.words: item for item in reversed(self.items)}
        return [(count, first[words]) for words, count in counts.items()]


def summed(items: Sequence[Item]) -> Information:
    """Information of these runs together."""
    return reduce(add, (item.information for item in items))


def minutes(items: Sequence[Item]) -> float:
    """Time in the tank, rests included [min]."""
    return sum(item.minutes for item in items)


def given(study: Study) -> tuple[Item, ...]:
    """The runs of the plan itself."""
    return tuple(Item(f.run.name, f, single) for f, single in zip(study.flown, study.single, strict=True))


def pool(study: Study, stage: Stage = silent) -> list[Item]:
    """Runs to choose from: the plan's, and all that fit the tank in several lengths."""
    items, some = list(given(study)), library(study, 60.0 * LENGTHS_MIN[-1])
    with stage("runs to choose from", len(some)) as advance:
        for flown in some:
            whole = sensitivity(flown, study.quantities)
            sweep = flown.scenario.excitation.kind == "chirp"  # a short one is not the beginning of a long one
            for length in LENGTHS_MIN[-1:] if sweep else LENGTHS_MIN:
                seen, cut = int(np.sum(flown.run.time_s <= 60.0 * length + 1e-9)), _cut(flown, length)
                info = information(study.quantities, whole.shortened(seen), length)
                items.append(Item(cut.scenario.description, cut, info))
            advance(flown.scenario.description)
    return items


def _cut(flown: Flown, length_min: float) -> Flown:
    seconds = 60.0 * length_min
    name, words = f"{flown.scenario.name}-{seconds:g}s", f"{flown.scenario.description}, {length_min:g} min"
    cut = replace(flown.scenario, name=name, path=Path(f"{name}.toml"), description=words, duration_s=seconds)
    return replace(flown, scenario=cut)


def design(study: Study, items: Sequence[Item]) -> Design:
    """The best plan in no more time than the study's; items: as by `pool`."""
    own = given(study)
    budget = minutes(own)
    at = study.information.index(study.free)
    matrix = np.array([item.information.matrix[np.ix_(at, at)] for item in items])
    search = Search(matrix, np.array([item.minutes for item in items]))
    words = [item.words for item in items]
    start = [words.index(item.words) for item in own if item.words in words]
    chance = np.random.default_rng(study.seed)
    starts = [start, [], *([int(k)] for k in chance.integers(len(items), size=STARTS))]
    plans = [search.exchanged(search.filled(plan, budget), budget) for plan in starts]
    best = min(plans, key=search.cost)
    return Design(tuple(items[k] for k in sorted(best)), own, study.free)


def confirmed(study: Study, items: Sequence[Item], threads: int = 1) -> Design:
    """The best plan whose runs keep clear of the walls in the MuJoCo tank as well, with all its degrees of freedom."""
    while True:
        found = design(study, items)
        plans = [
            plan_run(item.flown.scenario, k, study.seed, study.truth) for k, (_, item) in enumerate(found.counted())
        ]
        results = zip(found.counted(), simulate_tank(plans, threads), strict=True)
        hit = {item.words for (_, item), result in results if clearance_m(result) <= 0.0}
        if not hit:
            return found
        items = [item for item in items if item.words not in hit]


def scenario_texts(found: Design) -> dict[str, str]:
    """One scenario file for every run of the plan, numbered in the order in which they may be flown."""
    return {
        f"{k:02d}-{item.flown.scenario.name}.toml": as_toml(item.flown.scenario, f"Run {k} of a designed plan")
        for k, item in enumerate(found.items, 1)
    }
