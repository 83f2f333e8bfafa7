"""Propeller speeds that stand alone, once what the controller heard is taken off.

In closed loop the propeller truly jumps from tick to tick, since the sonar's noise goes through the controller. But
the controller hears the very ranges that are on record: its demand is a linear filter of them and of a smooth command,
and the propeller speed the blunted square root of the demand. That filter is fitted here, to every run together, on
what is left after smoothing; nothing of the controller need be known. What the ranges foretell is then no spike,
however far it jumps, and what they do not foretell stands out. In open loop nothing is foretold and nothing taken off.

The filter is a sum of Laguerre functions (Wahlberg, IEEE Trans. Automatic Control 36, 1991), fitted by iteratively
reweighted least squares (Huber, Robust Statistics, 1981).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import median_filter
from scipy.optimize import minimize_scalar

from ..estimate.observed import RANGE, Observed
from . import outliers
from .smoothing import first_order, local_polynomial

LEAST = 0.01  # share of the largest input below which nothing is flagged; a choice
POLE, ORDER = 0.75, 10  # of the Laguerre functions: memories up to some 3 s at 10 Hz; choices
SMOOTH = (15, 3)  # samples and order of the local polynomials that stand for the command (Savitzky and Golay)
BLUNT = (0.0, 0.1, 0.2, 0.35, 0.6, 1.0, 3.0)  # bluntness tried, over the largest input; a grid, then refined
CLEAR = 0.97  # share of a limit from which the limiter may have cut the demand; a choice
LIMITED, CLOSE = 0.02, 0.01  # share of the readings that lie this close to a limit, where there is one; choices
BEYOND = (0.99, 0.98, 0.97, 0.96, 0.95)  # ranks at which a limit is looked for: one in twenty may be spiked
TURNS, ACCURACY = 6, 0.02  # rounds of reweighting, and of the bluntness; choices
HUBER = 1.5  # robust deviations from which an equation counts less
LAST_MISS = 12  # ticks after which a missed ping is forgotten; until then the controller's own guess stood in
FORETELL = 6  # ranges from which a missed one is foretold
ROUNDS = 3  # looks at the same readings; a choice
LIMITER = -1  # group of the readings that a limiter has cut
EXPLAINED = 0.7  # share of the roughness that a controller may leave to count as one; a choice
ALIKE = 0.3  # share of their distance by which three readings in a row, or both beside them, differ at most; a choice
FEWEST = 200  # samples of a run from which a controller is looked for
MANY = 40  # samples from which a spread of their own is taken


def with_lone_speeds(runs: Sequence[Observed]) -> tuple[Observed, ...]:
    """The runs with `lone` filled in: how far the readings of the input that stand alone lie off."""
    return tuple(replace(run, lone=lone) for run, lone in zip(runs, lone_speeds(runs), strict=True))


def lone_speeds(runs: Sequence[Observed]) -> list[np.ndarray]:
    """How far each reading of the input that stands alone lies off, per run, shape (I,); 0 where it does not.

    What was found is taken off and the rest looked at anew, since a spike smears over its neighbours.
    """
    able = [k for k, run in enumerate(runs) if run.input.size >= FEWEST and np.sum(run.kind == RANGE) >= FEWEST]
    pilot = _Pilot([runs[k] for k in able]) if able else None
    lone = [np.zeros(run.input.size) for run in runs]
    for _ in range(ROUNDS):
        clean = [run.input - part for run, part in zip(runs, lone, strict=True)]
        looks = [_plain(n) for n in clean]
        answered = pilot.look([clean[k] for k in able]) if pilot else []
        for k, look in zip(able, answered, strict=True):
            if look.spread < EXPLAINED * looks[k].spread:
                looks[k] = look
        lone = [look.alone(part, run.input) for run, part, look in zip(runs, lone, looks, strict=True)]
    return lone


@dataclass(frozen=True)
class _Look:
    """An input less what is foretold of it.

    Attributes:
        rough: what smoothing leaves, shape (I,).
        away: how lone each reading is, shape (I,).
        group: readings of one group are alike in how well they are foretold; LIMITER not at all, shape (I,).
    """

    rough: np.ndarray
    away: np.ndarray
    group: np.ndarray

    @property
    def spread(self) -> float:
        """Of all readings that are foretold."""
        return outliers.spread(self.rough[self.group != LIMITER])

    def alone(self, known: np.ndarray, n: np.ndarray) -> np.ndarray:
        """Distances, with what was known of them before, that are larger than the roughness makes likely; else 0."""
        limit = np.full(n.size, self.spread)
        for which in np.unique(self.group[self.group != LIMITER]):
            chosen = self.group == which
            if np.sum(chosen) >= MANY:
                limit[chosen] = outliers.spread(self.rough[chosen])
        off = known + self.away
        return np.where(
            np.abs(off) > np.maximum(outliers.THRESHOLD * limit, LEAST * np.max(np.abs(n), initial=0.0)), off, 0.0
        )


def _plain(n: np.ndarray) -> _Look:
    """An input of which nothing is foretold: a lone reading sticks out of a slope, and neither end of a step does."""
    rough = _rough(n)
    raw, off = _away(n), _away(rough)
    return _Look(rough, np.where(raw * np.sign(off) > 0.5 * np.abs(off), off, 0.0), np.zeros(n.size, dtype=np.int64))


def _away(values: np.ndarray) -> np.ndarray:
    """Distance of each value from the median of itself and two neighbours on either side: none in a step or a slope.

    Of three in a row that are off alike, between two at one level, the distance from these.
    """
    away = np.asarray(values - median_filter(values, size=5, mode="nearest"))
    if values.size < 5:
        return away
    five = sliding_window_view(values, 5)
    off = five[:, 1:4] - 0.5 * (five[:, :1] + five[:, 4:])
    limit = ALIKE * np.min(np.abs(off), axis=1)
    alike = (np.ptp(off, axis=1) < limit) & (np.abs(five[:, 4] - five[:, 0]) < limit)
    for first in np.flatnonzero(alike):
        away[first + 1 : first + 4] = off[first]
    return away


def _rough(values: np.ndarray) -> np.ndarray:
    """What is left of samples, shape (I,) or (I, K), after smoothing along time; 0 where there are too few."""
    if values.shape[0] < SMOOTH[0]:
        return np.zeros_like(values)
    return np.asarray(values - local_polynomial(values, *SMOOTH))


class _Pilot:
    """The controller of some runs, found from what it heard and did."""

    def __init__(self, runs: Sequence[Observed]) -> None:
        n = np.concatenate([run.input for run in runs])
        self.top = float(np.quantile(np.abs(n), 0.99)) or 1.0
        self.limit = _limit(np.abs(n))
        ranges, self.since = zip(*(_heard(run) for run in runs), strict=True)
        self.columns = np.concatenate([_rough(_laguerre(r)) for r in ranges])
        self.share = self._bluntness([run.input for run in runs])

    def _bluntness(self, inputs: Sequence[np.ndarray]) -> float:
        """Bluntness over the largest input that leaves least."""
        spreads = [self.left(inputs, share)[0] for share in BLUNT]
        i = int(np.argmin(spreads))
        low, high = BLUNT[max(i - 1, 0)], BLUNT[min(i + 1, len(BLUNT) - 1)]
        found = minimize_scalar(lambda share: self.left(inputs, share)[0], bounds=(low, high), method="bounded",
                                options={"xatol": ACCURACY * high})  # fmt: skip
        return float(found.x) if found.fun < spreads[i] else BLUNT[i]

    def look(self, inputs: Sequence[np.ndarray]) -> list[_Look]:
        """The inputs of the runs, shape (I,) each, less what the ranges foretell."""
        rough, blunt = self.left(inputs, self.share)[1], self.share * self.top
        parts, out = np.split(rough, np.cumsum([n.size for n in inputs])[:-1]), []
        for n, rest, since in zip(inputs, parts, self.since, strict=True):
            away = n - _input(_demand(n, blunt) - _away(rest * self.slope(n, blunt)), blunt)
            limited = np.abs(n) >= CLEAR * self.limit
            beyond = np.abs(n) > self.limit  # no propeller turns faster than its limiter allows
            away = np.where(limited, np.where(beyond, n - np.copysign(self.limit, n), 0.0), away)
            out.append(_Look(rest, away, np.where(limited, LIMITER, since)))
        return out

    def left(self, inputs: Sequence[np.ndarray], share: float) -> tuple[float, np.ndarray]:
        """Robust spread of what the ranges do not foretell at a bluntness over the largest input, and that itself."""
        blunt, n = share * self.top, np.concatenate(inputs)
        slope, free = self.slope(n, blunt), np.abs(n) < CLEAR * self.limit
        A = self.columns / slope[:, None]
        b = np.concatenate([_rough(_demand(n, blunt)) for n in inputs]) / slope
        A /= np.linalg.norm(A, axis=0) + 1e-300
        weight = free.astype(float)
        for _ in range(TURNS):
            H = A.T @ (A * weight[:, None])
            H[np.diag_indices_from(H)] += 1e-12 * np.trace(H) + 1e-300
            rest = b - A @ np.linalg.solve(H, A.T @ (b * weight))
            spread = outliers.spread(rest[free])
            weight = free * np.minimum(1.0, HUBER * spread / np.maximum(np.abs(rest), 1e-300))
        return spread, rest

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")  # of inputs that are next to nothing
    def slope(self, n: np.ndarray, blunt: float) -> np.ndarray:
        """Change of the demand with the input, kept off zero, shape (I,)."""
        step = 1e-4 * self.top
        rise = (_demand(np.abs(n) + step, blunt) - _demand(np.abs(n), blunt)) / step
        return np.asarray(np.maximum(rise, 0.05 * 2.0 * self.top))


def _limit(size: np.ndarray) -> float:
    """Where a limiter cuts inputs of these sizes, shape (I,): many are alike there, and few, if spiked, lie beyond."""
    alike = [np.abs(size - value) < CLOSE * value for value in np.quantile(size, BEYOND)]
    most = max(alike, key=np.mean)
    return float(np.median(size[most])) if np.mean(most) > LIMITED else np.inf


def _demand(n: np.ndarray, blunt: float) -> np.ndarray:
    """The demand c behind an input n = c/sqrt(|c| + blunt^2) [unit of the input, squared]."""
    square = n * n
    return np.asarray(np.sign(n) * 0.5 * (square + np.sqrt(square * square + 4.0 * square * blunt * blunt)))


def _input(demand: np.ndarray, blunt: float) -> np.ndarray:
    """The input that answers a demand, the inverse of `_demand`."""
    return np.asarray(demand / np.sqrt(np.maximum(np.abs(demand) + blunt * blunt, 1e-300)))


def _heard(run: Observed) -> tuple[np.ndarray, np.ndarray]:
    """Ranges at the stamps of the input [m], missed ones foretold from those before, and ticks since the last miss."""
    own = run.kind == RANGE
    time, value = run.time_s[own], run.value[own]
    tick = float(np.median(np.diff(run.input_time_s)))
    last = np.searchsorted(time, run.input_time_s + 0.01 * tick, side="right") - 1
    fresh = (last >= 0) & (run.input_time_s - time[np.maximum(last, 0)] < 0.5 * tick)
    heard = np.where(fresh, value[np.maximum(last, 0)], np.nan)
    heard[: FORETELL + 1] = np.where(np.isnan(heard[: FORETELL + 1]), value[0], heard[: FORETELL + 1])
    missed = np.isnan(heard)
    steps = np.arange(heard.size)
    if np.any(missed):
        even = np.interp(steps, steps[~missed], heard[~missed])
        past = np.column_stack([even[FORETELL - 1 - j : even.size - 1 - j] for j in range(FORETELL)])
        change = past[:, 1:] - past[:, :1]
        weights = np.linalg.lstsq(change, even[FORETELL:] - past[:, 0], rcond=None)[0]
        for k in np.flatnonzero(missed):
            before = heard[k - FORETELL : k][::-1]
            heard[k] = before[0] + (before[1:] - before[0]) @ weights
    since = steps - np.maximum.accumulate(np.where(missed, steps, -LAST_MISS))
    return heard, np.minimum(since, LAST_MISS)


def _laguerre(heard: np.ndarray) -> np.ndarray:
    """The ranges themselves and their Laguerre filters, at rest before the run, shape (I, ORDER + 1)."""
    start = heard - heard[0]
    columns = [start, first_order(start, np.sqrt(1.0 - POLE**2), 0.0, POLE)]
    for _ in range(ORDER - 1):
        columns.append(first_order(columns[-1], -POLE, 1.0, POLE))
    return np.column_stack(columns)
