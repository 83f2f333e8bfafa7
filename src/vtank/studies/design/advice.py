"""For effects that a plan cannot tell apart, or hardly sees: the one run more that helps most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...diagnose import with_channels
from ...estimate import RANGE, SPEED
from ..stage import Stage, silent
from .candidates import library
from .design import Item
from .flown import SPEED_SD, Flown
from .information import Information
from .study import Study
from .verdicts import CLEAR, JUDGED, SEEN, Pair, Verdict, doubles, pairs, separation

MOST = 6  # pairs that are looked at
FEWEST = 3  # pairs that are named even where all are far apart


@dataclass(frozen=True)
class Remedy:
    """What one run more does to a number of deviations.

    Attributes:
        pair: the two effects, or None where an effect is hardly seen at all.
        verdict: on the effect concerned.
        before, repeat, after: deviations by the plan, with its best run once more, and with the best new run.
        experiment: the new run in words.
        sensor: whether it needs a sensor of speed on board.
    """

    pair: Pair | None
    verdict: Verdict
    before: float
    repeat: float
    after: float
    experiment: str
    sensor: bool = False


def options(study: Study, stage: Stage = silent) -> list[Item]:
    """New runs that fit the tank, and the plan's own again with a sensor of speed on board."""
    some = library(study)
    words = [f.scenario.description for f in some]
    words += [f"{f.run.name} again with a speed sensor of {SPEED_SD:g} m/s on board" for f in study.flown]
    found = []
    with stage("runs that could be added", len(words)) as advance:
        for note, flown in zip(words, [*some, *map(with_speed, study.flown)], strict=True):
            found.append(Item(note, flown, study.of(flown)))
            advance(note)
    return found


def with_speed(flown: Flown) -> Flown:
    """The run with a sensor of speed beside the sonar."""
    run = with_channels(flown.run, (RANGE, SPEED))
    value = np.interp(run.time_s, flown.run.time_s, flown.run.value)
    speed = run.kind == SPEED
    value[speed] = np.interp(run.time_s[speed], flown.scenario.time_s, flown.surge_m_s)
    return replace(flown, run=replace(run, value=value))


def remedies(study: Study, some: Sequence[Item]) -> list[Remedy]:
    """For effects that are hardly seen, at least the weakest, then for the closest pairs, at least a few."""
    by_name = {v.effect.name: v for v in study.verdicts}
    twins = doubles(study.verdicts)
    judged = [v for v in study.verdicts if v.standing in JUDGED and v.effect.name not in twins]
    judged.sort(key=lambda v: v.left)
    weak = [v for i, v in enumerate(judged) if v.left < CLEAR or i == 0][:MOST]
    near = [pair for i, pair in enumerate(pairs(study.verdicts)) if pair.separation < CLEAR or i < FEWEST][:MOST]
    return [_remedy(study, some, v) for v in weak] + [_remedy(study, some, by_name[p.a.name], p) for p in near]


def _remedy(study: Study, some: Sequence[Item], v: Verdict, pair: Pair | None = None) -> Remedy:
    """The best item; one with another sensor only where none without it tells the two apart."""

    def size(more: Sequence[Information] = ()) -> float:
        return separation(sum(more, study.information), v.effect, pair.b if pair else None, study.free)

    worth = [(size([item.information]), SPEED in item.flown.run.kind, item.words) for item in some]
    after, sensor, words = max(worth, key=lambda w: w[0])
    if plain := [w for w in worth if not w[1] and w[0] >= SEEN]:
        after, sensor, words = max(plain, key=lambda w: w[0])
    return Remedy(pair, v, size(), max(size([single]) for single in study.single), after, words, sensor)
