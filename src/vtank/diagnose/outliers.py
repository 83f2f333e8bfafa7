"""Readings that stand alone: lone long ranges (multipath), and readings of the propeller that the ranges give the lie.

A range is flagged when it lies off what its neighbours on both sides say by more than six robust deviations. All
hypotheses see the same flags: flagged ranges do not steer the filter.

Outliers as such are noise: any error that is as often early as late is granted to everybody, and so is one that is
uneven but falls away to either side. Multipath is late, never early, by a path of its own, and wins by that alone: it
must beat an even noise of free shape, an uneven one with a single peak, and echoes on both sides of the wall.

A propeller may well do what a lone reading says. Whether the tachometer spiked is therefore left to the other sensor,
by the innovations of the range with the spikes taken off and left on; `lone_speeds` finds the readings to ask about.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..compiled import law
from ..effects.effect import Effect
from ..estimate.observed import CHANNELS, Observed
from ..estimate.problem import Filtered

THRESHOLD = 6.0  # robust deviations; one false flag in 1e9 Gaussian readings
SPIKE_RANKS = (0.2, 0.5, 0.8)  # sizes tried: these quantiles of how far lone readings lie off, by square; choices
UNSEEN_SHARE = 0.3  # size of spikes that nobody saw, over the root mean square of the input; a guess
HIDDEN = (2.5, 3.5, 5.0)  # deviations late at which a search for hidden late pings begins; choices
SHAPES = np.array([0.5, 1.0, 2.0, 6.0, 40.0])  # [deviations] normals that the noise is mixed of at first; choices
NOISE, LATE, EVEN = np.array([0.0]), np.array([0.0, 1.0]), np.array([0.0, 1.0, -1.0])  # sides: see `_mixed`
PEAKS = np.arange(-1.5, 1.6, 0.5)  # [deviations] where an uneven noise may have its peak; choices
FIRST_SHARE = 0.01  # [-] late pings at first; a choice
PER_DEVIATION = 4  # classes of innovations to a robust deviation; a choice
ROUNDS = 60  # of expectation and maximisation; a choice
FEWEST = 3  # flags from which an outlier effect is considered
NEIGHBOURS = 3  # pairs of neighbours, before and after, that are asked
LEADING = (1, 3), (2, 4)  # readings after the first, through which lines lead to it
PASSES = 5  # at most, through the readings: where many stand alone they hide each other; a choice
CUT, SHRUNK = 0.92, 1.03  # quantile at which deviations are cut off, and what that leaves of white noise (simulated)


def spread(values: np.ndarray) -> float:
    """Robust standard deviation about zero; zero of no values."""
    return 1.4826 * float(np.median(np.abs(values))) if values.size else 0.0


def _away(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """How far each reading lies from the median of the chords between neighbours, shape (M,); 0 in steady motion.

    A bent motion leaves its chords by the product of the times to both ends. Beside a pause in the readings that is
    more than usual, and the distance is cut down by as much.
    """
    t, x = (np.pad(v, NEIGHBOURS, mode="reflect", reflect_type="odd") for v in (time, values))
    x[:NEIGHBOURS] += 2.0 * (_end(time, values) - values[0])  # mirrored about what the end should be
    x[-NEIGHBOURS:] += 2.0 * (_end(time[::-1], values[::-1]) - values[-1])
    here, off = slice(NEIGHBOURS, -NEIGHBOURS), []
    for j in range(1, NEIGHBOURS + 1):
        before, after = slice(NEIGHBOURS - j, -NEIGHBOURS - j), slice(NEIGHBOURS + j, x.size - NEIGHBOURS + j)
        share = (t[here] - t[before]) / (t[after] - t[before])
        bend = (t[here] - t[before]) * (t[after] - t[here])
        chord = x[before] + share * (x[after] - x[before])
        off.append((values - chord) / np.maximum(bend / np.median(bend), 1.0))
    return np.asarray(np.median(off, axis=0))


def _end(time: np.ndarray, values: np.ndarray) -> float:
    """What the first reading should be: the median of it and of where lines through others lead."""
    lines = [values[a] + (values[b] - values[a]) * (time[0] - time[a]) / (time[b] - time[a]) for a, b in LEADING]
    return float(np.median([values[0], *lines]))


def _stands_alone(time: np.ndarray, values: np.ndarray, floor: float) -> np.ndarray:
    if values.size <= NEIGHBOURS + 1:
        return np.zeros(values.size, dtype=bool)
    away = np.abs(_away(time, values))
    spread = float(np.sqrt(np.mean(np.minimum(away, np.quantile(away, CUT)) ** 2))) / SHRUNK
    limit = max(THRESHOLD * spread, floor)
    alone = away > limit
    if np.any(alone):  # a good reading whose neighbours stand alone is not far from the other good ones
        alone[alone] = np.abs(values[alone] - np.interp(time[alone], time[~alone], values[~alone])) > limit
    return alone


def _alone(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Which readings stand alone, once those are gone that hid them; shape (M,) of bool."""
    alone, floor = np.zeros(values.size, dtype=bool), 4.0 * resolution(values)
    for _ in range(PASSES):
        rest = np.flatnonzero(~alone)
        new = _stands_alone(time[rest], values[rest], floor)
        if not new.any():
            break
        alone[rest[new]] = True
    return alone


def long_ranges(run: Observed) -> np.ndarray:
    """Which measurements of a run are lone outliers, shape (M,) of bool."""
    flags = np.zeros(run.time_s.size, dtype=bool)
    for kind in np.unique(run.kind[run.placed]):
        chosen = run.kind == kind
        flags[chosen] = _alone(run.time_s[chosen], run.value[chosen])
    return flags


def resolution(values: np.ndarray) -> float:
    """Least step between readings that differ, 0 where none do [their unit]."""
    steps = np.abs(np.diff(np.unique(values)))
    return float(np.min(steps[steps > 1e-9])) if np.any(steps > 1e-9) else 0.0


def spike_sizes(runs: Sequence[Observed]) -> list[float]:
    """Sizes of spikes to be tried [unit of the input], from the readings that stand alone."""
    away = np.abs(np.concatenate([run.lone for run in runs]))
    if np.sum(away > 0.0) < FEWEST:
        return [UNSEEN_SHARE * float(np.sqrt(np.mean(np.concatenate([run.input for run in runs]) ** 2)))]
    away = np.sort(away[away > 0.0])
    share = np.cumsum(away**2) / np.sum(away**2)  # a few large ones shake the hull more than many small ones
    return [float(away[np.searchsorted(share, rank)]) for rank in SPIKE_RANKS]


def judged(
    effect: Effect, p: np.ndarray, runs: Sequence[Observed], filtered: Sequence[Filtered]
) -> tuple[float, dict[str, float]]:
    """Log evidence of an outlier effect beside the innovations, and what the outliers tell of it, by slot.

    p: its fitted parameters, shape (K,).
    """
    if effect.place in CHANNELS:
        own = [f.innovation[run.kind == CHANNELS[effect.place]] for run, f in zip(runs, filtered, strict=True)]
        gain, *found = multipath(effect, np.concatenate(own))
    else:
        gain, *found = spikes(effect, p, runs)
    counted = (name for name, q in zip(effect.slots(), effect.parameters, strict=True) if q.counted)
    return gain, dict(zip(counted, found, strict=True))


def spikes(effect: Effect, p: np.ndarray, runs: Sequence[Observed]) -> tuple[float, float]:
    """Log evidence of having tried several sizes of spikes, and the share of readings that parameters p repair [-]."""
    assert effect.true_input
    away = np.concatenate([run.lone for run in runs])
    count = sum(effect.true_input(0.0, lone, *p) != 0.0 for lone in away[away != 0.0])
    return (-float(np.log(len(SPIKE_RANKS))), count / away.size) if count >= FEWEST else (none_seen(away.size), 0.0)


def none_seen(total: int) -> float:
    """Log evidence of an outlier effect when no outlier is seen: its rate, uniform up to 0.3, must be tiny."""
    return -float(np.log(0.3 * total + 1.0))


def multipath(effect: Effect, e: np.ndarray) -> tuple[float, float, float]:
    """Log evidence of multipath against noise, its probability per ping [-] and its excess path [m].

    e: innovations of the ranges of all runs, shape (M,) [m].
    The noise is a mixture of normals about zero, whose widths and shares are free: whatever its tails, it is even. It
    is fitted without echoes, with late ones, and with as many early as late, by expectation and maximisation
    (Dempster, Laird, Rubin, J. Royal Statistical Society B 39, 1977); and, without echoes, uneven about one peak.
    """
    (_, most), (least_m, _) = (q.bounds for q in effect.parameters)
    deviation, best = max(spread(e), 1e-9), (none_seen(e.size), 0.0, 0.0)
    late, classes = e[e > THRESHOLD * deviation], _classes(e, deviation)
    starts = [deviation * k for k in HIDDEN] + ([float(np.median(late))] if late.size >= FEWEST else [])
    even, uneven = _mixed(*classes, deviation, 0.0, NOISE)[0], -np.inf  # which takes long, and is seldom asked for

    def paid(p: float) -> float:
        """For where it was looked, and how well it is known."""
        return float(np.log(e.size) + 0.5 * np.log(max(p * e.size, 1.0)) + np.log(len(starts)))

    for start in starts:
        found, p, extra = _mixed(*classes, deviation, start, LATE)
        if found - even - paid(p) < best[0]:
            continue
        if uneven == -np.inf:
            uneven = _uneven(*classes, deviation, 0.0)[0]
        found, p, extra = max((found, p, extra), _uneven(*classes, deviation, start))
        gain = found - max(even, uneven) - paid(p)
        if gain > best[0] and p * e.size >= FEWEST and p < most and extra > least_m:
            both = _mixed(*classes, deviation, start, EVEN)[0]
            best = max(best, (min(gain, found - both), p, extra))
    return best


def _uneven(e: np.ndarray, count: np.ndarray, deviation: float, extra: float) -> tuple[float, float, float]:
    """As `_mixed`, of noise that falls away to either side of one peak, to each in a free shape; extra 0: no echoes.

    Each side is half of an even noise, as heavy as what lies there; the later one may have echoes, then on both sides
    of that noise.
    """

    def side(off: np.ndarray, weight: np.ndarray, late: float) -> tuple[float, float, float]:
        here = weight > 0.0
        there = float(np.sum(weight))
        likelihood, p, found = _mixed(off[here], weight[here], deviation, late, EVEN if late > 0.0 else NOISE)
        share = there / float(np.sum(count))
        return float(likelihood) + there * float(np.log(2.0 * share)), p * share, found

    width, best = deviation / PER_DEVIATION, (-np.inf, 0.0, 0.0)
    for peak in np.round(PEAKS * PER_DEVIATION) * width:
        off = e - peak
        half = np.where(np.abs(off) < 0.5 * width, 0.5, 1.0) * count  # of what lies at the peak, to each side
        later, earlier = (np.where(sign * off > -0.5 * width, half, 0.0) for sign in (1.0, -1.0))
        if min(np.sum(later), np.sum(earlier)) > 0.0:
            likelihood, p, found = side(np.abs(off), later, max(extra - peak, 0.0) if extra else 0.0)
            best = max(best, (likelihood + side(np.abs(off), earlier, 0.0)[0], p, found + peak))
    return best


def _classes(e: np.ndarray, deviation: float) -> tuple[np.ndarray, np.ndarray]:
    """Innovations in narrow classes: their middles [m] and how many there are in each, shapes (C,)."""
    width = deviation / PER_DEVIATION
    middle, count = np.unique(np.round(e / width), return_counts=True)
    return middle * width, count


@law
def _mixed(e, count, deviation, extra, sides):  # type: ignore[no-untyped-def]
    """Log-likelihood of innovations e, `count` times each, the share of echoes and their excess path [m].

    sides: 0 for the noise itself, then 1 for late echoes, -1 for early ones, as many of each, shape (K,).
    """
    S, K, likelihood, p = SHAPES.size, sides.size, 0.0, FIRST_SHARE * (sides.size > 1)
    sd, share, density = deviation * SHAPES, np.full(S, 1.0 / S), np.empty((K, S))
    for _ in range(ROUNDS):
        own, square, echoes, moved, likelihood = np.zeros(S), np.zeros(S), np.zeros(S), np.zeros(S), 0.0
        for c in range(e.size):
            for k in range(K):
                chance = p / (K - 1) if k > 0 else 1.0 - p
                for i in range(S):
                    off = (e[c] - extra * sides[k]) / sd[i]
                    density[k, i] = chance * share[i] / sd[i] * np.exp(-0.5 * off * off)
            total = np.sum(density) + 1e-300
            likelihood += count[c] * np.log(total)
            for k in range(K):
                for i in range(S):
                    part = density[k, i] * count[c] / total
                    own[i] += part
                    square[i] += part * (e[c] - extra * sides[k]) ** 2
                    echoes[i] += part * (k > 0)
                    moved[i] += part * e[c] * sides[k]
        share, sd = own / np.sum(count), np.sqrt(square / (own + 1e-300) + (0.1 * deviation) ** 2)
        p = np.sum(echoes) / np.sum(count)
        if K > 1:
            extra = np.sum(moved / sd**2) / (np.sum(echoes / sd**2) + 1e-300)
    return likelihood, p, extra
