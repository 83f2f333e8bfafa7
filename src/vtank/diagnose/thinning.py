"""Long recordings, thinned: of the input, held from stamp to stamp, two levels stand for a few stamps.

An average alone would have its impulse, but not when: the vehicle would be off by a share of what the thrust changes.

A measured force may have been the record of a smooth signal instead: `straightened` says the same in held values.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..estimate.observed import Observed
from ..rigid.thinned import answered

SHORTEST_S = 0.02  # [s] period below which recordings are thinned: vehicles and drives answer more slowly; a choice
FOREIGN_SAMPLES = 3000  # of all runs together, where hypotheses grow one effect at a time; for the time it takes
MOST_SAMPLES = 12_000  # of all runs together, where a nominal is given; for the time it takes
CLOSED = 3  # times as many, where the input answers readings: it would tell of those left out; for the time it takes
BURST = 0.5  # of the mean step, below which the usual one is that within bursts; a choice
NEARLY = 1e-4  # of the mean step, within which two rows are one; a choice
ROUNDING = 1e-6  # share of a sample by which stamps may be off


def thinned(runs: Sequence[Observed], most: int = MOST_SAMPLES, levels: int = 2) -> tuple[Observed, ...]:
    """The runs with as few samples as there is time for, `most` of a channel; the same runs where they have no more.

    More where a controller answers the readings: what it answered to one that is left out moves the vehicle as a force
    would that knows the next one's error. levels: as of `thin`.
    """
    length = sum(float(run.time_s[-1] - run.time_s[0]) for run in runs)
    if any(map(_closed, runs)):
        most *= CLOSED
    return tuple(thin(run, max(SHORTEST_S, length / most), levels) for run in runs)


def thin(run: Observed, period: float, levels: int = 2) -> Observed:
    """The run at a period of at least so many seconds, on stamps of its own; the same run where it is no faster.

    A step holds two levels of what was held within it, of thrust (n|n|) where the input is no force, so that the
    impulse up to each stamp kept is exact, and how far it has moved a free body nearly; measurements are those at these
    stamps, or the first ones after. levels: 2, or 1 for the average, which acts a share of a step early.
    """
    tick = _tick(run.input_time_s)
    every = int(np.ceil(period / tick - ROUNDING))
    faster = [_tick(run.time_s[run.kind == kind]) < period * (1.0 - ROUNDING) for kind in run.first]
    if every < 2 and not any(faster):
        return run
    edges = run.input_time_s[::every] if every > 1 else np.arange(run.time_s[0], run.time_s[-1] + period, period)
    keep = np.zeros(run.time_s.size, dtype=bool)
    for kind in run.first:
        own = np.flatnonzero(run.kind == kind)
        after = np.searchsorted(run.time_s[own], edges - ROUNDING * period)
        keep[own[np.unique(after[after < own.size])]] = True
    square = run.input_name != "thrust_N"
    value = run.input * np.abs(run.input) if square else run.input
    stamps, level = run.input_time_s, value
    if every > 1 and levels == 1:
        first, held_s = np.arange(0, value.size, every), np.diff(run.input_time_s, append=run.input_time_s[-1] + tick)
        stamps, level = stamps[first], np.add.reduceat(value * held_s, first) / np.add.reduceat(held_s, first)
    elif every > 1:
        stamps, level = _two_levels(run.input_time_s, value, tick, every)
    return replace(
        run,
        input_time_s=stamps,
        input=np.sign(level) * np.sqrt(np.abs(level)) if square else level,
        lone=np.zeros(stamps.size),
        time_s=run.time_s[keep],
        value=run.value[keep],
        kind=run.kind[keep],
        thinned=run.thinned or not keep.all(),
    )


def _closed(run: Observed) -> bool:
    """Whether the input answers the noise of some channel."""
    own = [run.kind == kind for kind in run.first]
    return any(answered(run.time_s[k], run.value[k], run.input_time_s, run.input[:, None]) for k in own)


def _two_levels(time_s: np.ndarray, value: np.ndarray, tick: float, every: int) -> tuple[np.ndarray, np.ndarray]:
    """Stamps and levels that stand for so many held values each, of the same integral and the same moment.

    They change where the values differ the most before and after; and lie no farther out than these, which may leave a
    part of the moment out. What does not change has one level.
    """
    spare = -time_s.size % every
    held = np.append(np.diff(time_s), [tick, *np.zeros(spare)]).reshape(-1, every)
    given = np.append(value, np.repeat(value[-1], spare)).reshape(-1, every)
    until, impulse = np.cumsum(held, axis=1), np.cumsum(given * held, axis=1)
    whole, total = until[:, -1], impulse[:, -1]
    moment = np.sum(given * held * (until - 0.5 * held), axis=1)
    ahead = np.maximum(whole[:, None] - until, 1e-300)
    apart = (impulse / until - (total[:, None] - impulse) / ahead) ** 2 * until * ahead
    split = np.argmax(apart[:, :-1], axis=1)
    rows = np.arange(split.size)
    d1, d2 = until[rows, split], ahead[rows, split]
    low, high = given.min(axis=1), given.max(axis=1)
    second = 2.0 * (moment - 0.5 * total * d1) / (d2 * whole)
    second = np.clip(second, np.maximum(low, (total - high * d1) / d2), np.minimum(high, (total - low * d1) / d2))
    first = (total - second * d2) / d1
    changes = (high > low) & (d2 > 1e-300)
    first = np.where(changes, first, total / whole)
    stamps = np.column_stack((time_s[::every], time_s[np.minimum(rows * every + split + 1, time_s.size - 1)]))
    keep = np.column_stack((np.ones(split.size, bool), changes))
    return stamps[keep], np.column_stack((first, second))[keep]


def _tick(time_s: np.ndarray) -> float:
    """The usual step between stamps [s]; where they come in bursts, the mean one. Infinite for one stamp."""
    steps = np.diff(time_s)
    usual, mean = (float(of(steps)) if steps.size else np.inf for of in (np.median, np.mean))
    return mean if usual < BURST * mean else usual


def told_once(run: Observed) -> Observed:
    """The run without rows that all but repeat the one before, as loggers write them that flush twice."""
    fed, keep = _apart(run.input_time_s), np.ones(run.time_s.size, dtype=bool)
    for kind in run.first:
        keep[run.kind == kind] = _apart(run.time_s[run.kind == kind])
    if fed.all() and keep.all():
        return run
    return replace(
        run,
        input_time_s=run.input_time_s[fed],
        input=run.input[fed],
        lone=run.lone[fed],
        time_s=run.time_s[keep],
        value=run.value[keep],
        kind=run.kind[keep],
    )


def _apart(time_s: np.ndarray) -> np.ndarray:
    """Which stamps come a while after the one before, by the mean step; the first always does."""
    steps = np.diff(time_s, prepend=-np.inf)
    return np.asarray(steps > NEARLY * np.mean(steps[1:]) if time_s.size > 1 else steps > 0.0)


def straightened(run: Observed) -> Observed:
    """The run with an input that went straight from sample to sample: each step holds the mean over it."""
    return replace(run, input=0.5 * (run.input + np.append(run.input[1:], run.input[-1])), straight=True)
