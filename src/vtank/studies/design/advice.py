"""For effects that a plan cannot tell apart, or hardly sees: the one run more that helps most."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...diagnose import with_channels
from ...estimate import RANGE, SPEED
from .candidates import Candidate, candidates
from .flown import SPEED_SD, Flown
from .information import Information
from .study import Study
from .verdicts import CLEAR, JUDGED, SEEN, Pair, Verdict, doubles, pairs, separation, slots_of

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


@dataclass(frozen=True, eq=False)
class Option:
    """A run that could be added, and what it tells."""

    words: str
    information: Information
    sensor: bool = False


def options(
    study: Study, some: Sequence[Candidate], advance: Callable[[str], None] = lambda note: None
) -> list[Option]:
    """New runs, and the plan's own again with a sensor of speed on board; `advance` is called after each new one."""
    found = []
    for c in some:
        found.append(Option(c.words, study.of(c.flown)))
        advance(c.words)
    for f in study.flown:
        words = f"{f.run.name} again with a speed sensor of {SPEED_SD:g} m/s on board"
        found.append(Option(words, study.of(with_speed(f)), sensor=True))
    return found


def library(study: Study) -> list[Candidate]:
    """Experiments that fit the tank, like the plan's first."""
    return candidates(study.flown[0].scenario, study.truth, study.seed, len(study.flown))


def with_speed(flown: Flown) -> Flown:
    """The run with a sensor of speed beside the sonar."""
    run = with_channels(flown.run, (RANGE, SPEED))
    value = np.interp(run.time_s, flown.run.time_s, flown.run.value)
    speed = run.kind == SPEED
    value[speed] = np.interp(run.time_s[speed], flown.scenario.time_s, flown.surge_m_s)
    return replace(flown, run=replace(run, value=value))


def remedies(study: Study, some: Sequence[Option]) -> list[Remedy]:
    """For effects that are hardly seen, at least the weakest, then for the closest pairs, at least a few."""
    by_name = {v.effect.name: v for v in study.verdicts}
    twins = doubles(study.verdicts)
    judged = [v for v in study.verdicts if v.standing in JUDGED and v.effect.name not in twins]
    judged.sort(key=lambda v: v.left)
    weak = [v for i, v in enumerate(judged) if v.left < CLEAR or i == 0][:MOST]
    found = [_remedy(study, some, None, v, _seen_by(v, study.free)) for v in weak]
    close = pairs(study.information, study.verdicts, study.free)
    near = [pair for i, pair in enumerate(close) if pair.separation < CLEAR or i < FEWEST][:MOST]
    return found + [_remedy(study, some, pair, by_name[pair.a.name], _apart(pair, study.free)) for pair in near]


def _seen_by(v: Verdict, free: Sequence[str]) -> Callable[[Information], float]:
    return lambda info: info.separation(slots_of(v.effect, info.quantities), free)


def _apart(pair: Pair, free: Sequence[str]) -> Callable[[Information], float]:
    return lambda info: separation(info, pair.a, pair.b, free)


def _remedy(
    study: Study, some: Iterable[Option], pair: Pair | None, v: Verdict, size: Callable[[Information], float]
) -> Remedy:
    """The best option; one with another sensor only where none without it tells the two apart."""
    total = study.information
    worth = [(size(total + o.information), o) for o in some]
    plain = max((w for w in worth if not w[1].sensor), key=lambda w: w[0], default=None)
    best = max(worth, key=lambda w: w[0])
    after, option = plain if plain and plain[0] >= SEEN else best
    repeat = max(size(total + single) for single in study.single)
    return Remedy(pair, v, size(total), repeat, after, option.words, option.sensor)
