"""A better plan: of the experiments that fit the tank, those with the smallest bounds for the same time.

What is made small is the sum of the squared relative bounds in the time that a given plan takes, rest between runs
included. The search starts from the given plan too, so that it never ends worse.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...experiment import as_toml, clearances, plan_run, simulate_tank
from .candidates import Candidate, candidates
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
    def information(self) -> Information:
        """Of the whole plan."""
        return summed(self.items)

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
    return sum((item.information for item in items[1:]), items[0].information)


def minutes(items: Sequence[Item]) -> float:
    """Time in the tank, rests included [min]."""
    return sum(item.minutes for item in items)


def given(study: Study) -> tuple[Item, ...]:
    """The runs of the plan itself."""
    return tuple(Item(f.run.name, f, single) for f, single in zip(study.flown, study.single, strict=True))


def longest(study: Study) -> list[Candidate]:
    """All experiments that fit the tank, in the greatest length."""
    like = replace(study.flown[0].scenario, duration_s=60.0 * LENGTHS_MIN[-1])
    return candidates(like, study.truth, study.seed, len(study.flown))


def pool(study: Study, some: Sequence[Candidate], advance: Callable[[str], None] = lambda note: None) -> list[Item]:
    """Runs to choose from: the plan's, and these in several lengths; `advance` is called after each of them."""
    items = list(given(study))
    for candidate in some:
        whole = sensitivity(candidate.flown, study.quantities)
        sweep = candidate.flown.scenario.excitation.kind == "chirp"  # a short one is not the beginning of a long one
        for length in LENGTHS_MIN[-1:] if sweep else LENGTHS_MIN:
            seen = int(np.sum(candidate.flown.run.time_s <= 60.0 * length + 1e-9))
            info = information(study.quantities, whole.shortened(seen), length)
            items.append(Item(f"{candidate.words}, {length:g} min", _cut(candidate.flown, length), info))
        advance(candidate.words)
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
    start = [items.index(next(i for i in items if i.words == item.words)) for item in own]
    chance = np.random.default_rng(study.seed)
    starts = [start, [], *([int(k)] for k in chance.integers(len(items), size=STARTS))]
    plans = [search.exchanged(search.filled(s, budget) if s != start else s, budget) for s in starts]
    best = min(plans, key=search.cost)
    return Design(tuple(items[k] for k in sorted(best)), own, study.free)


def confirmed(study: Study, items: Sequence[Item], threads: int = 1) -> Design:
    """The best plan whose new runs keep clear of the walls in the tank as well, with all its degrees of freedom."""
    while True:
        found = design(study, items)
        new = [item for _, item in found.counted() if item not in found.given]
        hit = {item.words for item, keeps in zip(new, in_tank(new, study.seed, threads), strict=True) if not keeps}
        if not hit:
            return found
        items = [item for item in items if item.words not in hit]


def in_tank(items: Sequence[Item], seed: int, threads: int = 1) -> list[bool]:
    """Whether each run keeps clear of the walls in the MuJoCo tank."""
    plans = [plan_run(item.flown.scenario, k, seed, item.flown.truth) for k, item in enumerate(items)]
    out = []
    for result in simulate_tank(plans, threads):
        x = result.true["position_m"]
        out.append(min(clearances(result.plan.scenario, float(x.max()), float(x.min()))) > 0.0)
    return out


def scenario_texts(found: Design) -> dict[str, str]:
    """One scenario file for every run of the plan, numbered in the order in which they may be flown."""
    return {
        f"{k:02d}-{item.flown.scenario.name}.toml": as_toml(item.flown.scenario, f"Run {k} of a designed plan")
        for k, item in enumerate(found.items, 1)
    }
