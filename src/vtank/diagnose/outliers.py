"""Readings that stand alone: lone long ranges (multipath), and readings of the propeller that the ranges give the lie.

A range is flagged when it lies off what its neighbours on both sides say by more than six robust deviations. All
hypotheses see the same flags: flagged ranges do not steer the filter, and a background of outliers from nowhere is
granted to everybody, so that multipath wins only by explaining what the background explains badly.

A propeller may well do what a lone reading says. Whether the tachometer spiked is therefore left to the other sensor,
by the innovations of the range with the spikes taken off and left on; `lone_speeds` finds the readings to ask about.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..effects.effect import Effect
from ..estimate.observed import CHANNELS, Observed
from ..estimate.problem import Filtered

THRESHOLD = 6.0  # robust deviations; one false flag in 1e9 Gaussian readings
BACKGROUND = 1e-3  # [-] probability of an outlier from nowhere, granted to every hypothesis; a guess
SPAN_M = 10.0  # [m] width over which such an outlier may fall; a guess, the order of the tank
SPIKE_RANKS = (0.2, 0.5, 0.8)  # sizes tried: these quantiles of how far lone readings lie off, by square; choices
UNSEEN_SHARE = 0.3  # size of spikes that nobody saw, over the root mean square of the input; a guess
HIDDEN, ROUNDS = (2.5, 3.5, 5.0), 15  # deviations of hidden late pings that a fit begins at, and its rounds; choices
FEWEST = 3  # flags from which an outlier effect is considered
NEIGHBOURS = 3  # pairs of neighbours, before and after, that are asked
CUT, SHRUNK = 0.92, 1.03  # quantile at which deviations are cut off, and what that leaves of white noise (simulated)


def _away(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """How far each reading lies from the median of the chords between neighbours, shape (M,); 0 in steady motion."""
    t, x = (np.pad(v, NEIGHBOURS, mode="reflect", reflect_type="odd") for v in (time, values))
    here, chords = slice(NEIGHBOURS, -NEIGHBOURS), []
    for j in range(1, NEIGHBOURS + 1):
        before, after = slice(NEIGHBOURS - j, -NEIGHBOURS - j), slice(NEIGHBOURS + j, x.size - NEIGHBOURS + j)
        share = (t[here] - t[before]) / (t[after] - t[before])
        chords.append(x[before] + share * (x[after] - x[before]))
    return np.asarray(values - np.median(chords, axis=0))


def _stands_alone(time: np.ndarray, values: np.ndarray, floor: float) -> np.ndarray:
    if values.size <= NEIGHBOURS:
        return np.zeros(values.size, dtype=bool)
    away = np.abs(_away(time, values))
    spread = float(np.sqrt(np.mean(np.minimum(away, np.quantile(away, CUT)) ** 2))) / SHRUNK
    limit = max(THRESHOLD * spread, floor)
    alone = away > limit
    if np.any(alone):  # a good reading whose neighbours stand alone is not far from the other good ones
        alone[alone] = np.abs(values[alone] - np.interp(time[alone], time[~alone], values[~alone])) > limit
    return alone


def long_ranges(run: Observed) -> np.ndarray:
    """Which measurements of a run are lone outliers, shape (M,) of bool."""
    flags = np.zeros(run.time_s.size, dtype=bool)
    for kind in np.unique(run.kind[run.placed]):
        chosen = run.kind == kind
        values = run.value[chosen]
        resolution = _resolution(values)
        flags[chosen] = _stands_alone(run.time_s[chosen], values, 4.0 * resolution)
    return flags


def _resolution(values: np.ndarray) -> float:
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
    effect: Effect,
    p: np.ndarray,
    runs: Sequence[Observed],
    filtered: Sequence[Filtered],
    flags: Sequence[np.ndarray],
) -> tuple[float, dict[str, float]]:
    """Log evidence of an outlier effect beside the innovations, and what the outliers tell of it, by slot.

    p: its fitted parameters, shape (K,); flags: per run, which measurements are lone outliers, shape (M,).
    """
    gain, *found = multipath(effect, filtered, flags) if effect.place in CHANNELS else spikes(effect, p, runs)
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


def rate_evidence(count: int, total: int) -> float:
    """Log evidence of `count` outliers of any size among `total` readings against the background's rate."""
    if count < FEWEST:
        return 0.0
    p = count / total
    return float(count * np.log(p / BACKGROUND) + (total - count) * np.log1p(-p) - np.log(total))


def multipath(effect: Effect, filtered: Sequence[Filtered], flags: Sequence[np.ndarray]) -> tuple[float, float, float]:
    """Log evidence of multipath against the background, its probability per ping [-] and its excess path [m].

    Each innovation is a mixture of a good ping and a late one, fitted by expectation and maximisation (Dempster, Laird,
    Rubin, J. Royal Statistical Society B 39, 1977). Flagged pings are compared with the background, the others with
    the Gaussian that all hypotheses grant them.
    """
    (_, most), (least_m, _) = (q.bounds for q in effect.parameters)
    late = np.concatenate([f.innovation[flag] for f, flag in zip(filtered, flags, strict=True)])
    wide = np.concatenate([_spread(f, flag) for f, flag in zip(filtered, flags, strict=True)])
    e = np.concatenate([f.innovation[~flag] for f, flag in zip(filtered, flags, strict=True)])
    S = np.concatenate([f.variance[~flag] for f, flag in zip(filtered, flags, strict=True)])
    total, usual = e.size + late.size, float(np.sqrt(np.median(S))) if S.size else 0.0
    starts = [float(np.median(late))] if late.size >= FEWEST else [usual * k for k in HIDDEN]
    best = none_seen(total), 0.0, 0.0
    for extra in (x for x in starts if x > 0.0):  # an echo by way of the surface is late, never early
        p = 0.01
        for _ in range(ROUNDS):
            odds = np.exp(np.minimum((e - 0.5 * extra) * extra / S, 700.0))
            near = np.exp(-0.5 * (late - extra) ** 2 / wide) / np.sqrt(2.0 * np.pi * wide)
            share, lone = p * odds / (1.0 - p + p * odds), p * near / (p * near + BACKGROUND / SPAN_M)
            count = max(float(np.sum(share) + np.sum(lone)), 1e-9)
            p = min(count / total, most)
            extra = float((share / S) @ e + (lone / wide) @ late) / float(
                np.sum(share / S) + np.sum(lone / wide) + 1e-30
            )
        gain = np.sum(np.log(1.0 - p + p * odds)) + np.sum(np.log1p(p * near * SPAN_M / BACKGROUND))
        gain -= np.log(total) + 0.5 * np.log(max(count, 1.0)) + np.log(len(starts))
        if count >= FEWEST and extra > least_m and gain > best[0]:
            best = float(gain), p, extra
    return best


def _spread(f: Filtered, flag: np.ndarray) -> np.ndarray:
    """Variance of what a flagged ping should have read, from the neighbours that were not flagged [m2]."""
    usual = float(np.median(f.variance[~flag])) if np.any(~flag) else 1e-4
    return np.full(int(flag.sum()), 4.0 * usual)
