"""Readings that stand alone: lone long ranges (multipath) and lone propeller readings (spikes), found without a model.

A reading is flagged when it differs from the running median of its neighbours by more than six robust deviations.
All hypotheses see the same flags: flagged ranges do not steer the filter, and a background of outliers from nowhere
is granted to everybody, so that multipath or spikes win only by explaining what the background explains badly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from ..effects.tachometer_spikes import SEEN
from ..identify.observed import SPEED, Observed
from ..identify.problem import Filtered

THRESHOLD = 6.0  # robust deviations; one false flag in 1e9 Gaussian readings
BACKGROUND = 1e-3  # [-] probability of an outlier from nowhere, granted to every hypothesis; a guess
SPAN_M = 10.0  # [m] width over which such an outlier may fall; a guess, the order of the tank
SPIKE_SHARES = (0.12, 0.18, 0.27, 0.4, 0.6)  # sizes tried, over the root mean square of the input
FEWEST = 3  # flags from which an outlier effect is considered


def _stands_alone(values: np.ndarray, width: int, floor: float) -> np.ndarray:
    away = np.abs(values - median_filter(values, size=width, mode="nearest"))
    spread = float(np.quantile(away, 0.8)) / 1.2816  # robust to one outlier in five, and to readings that stand still
    return away > max(THRESHOLD * spread, floor)


def long_ranges(run: Observed) -> np.ndarray:
    """Which measurements of a run are lone outliers, shape (M,) of bool."""
    flags = np.zeros(run.time_s.size, dtype=bool)
    for kind in np.unique(run.kind[run.kind != SPEED]):
        chosen = run.kind == kind
        values = run.value[chosen]
        resolution = _resolution(values)
        flags[chosen] = _stands_alone(values, 5, 4.0 * resolution)
    return flags


def _resolution(values: np.ndarray) -> float:
    steps = np.abs(np.diff(np.unique(values)))
    return float(np.min(steps[steps > 1e-9])) if np.any(steps > 1e-9) else 0.0


@dataclass(frozen=True)
class LoneReadings:
    """Lone propeller readings of all runs.

    Attributes:
        sizes: how far each stands from its neighbours [unit of the input], shape (count,).
        spread: robust deviation of the other readings about their neighbours [unit of the input].
        span: width over which a reading may fall [unit of the input].
        total: number of readings.
    """

    sizes: np.ndarray
    spread: float
    span: float
    total: int

    @property
    def size(self) -> float:
        """Typical size [unit of the input]; 0 where there are too few to speak of."""
        return float(np.median(self.sizes)) if self.sizes.size >= FEWEST else 0.0

    def evidence(self) -> float:
        """Log evidence of spikes of one size against a background of lone readings that are real."""
        count = self.sizes.size
        if count < FEWEST:
            return none_seen(self.total)
        p, sd = count / self.total, max(2.0 * self.spread, 0.02 * self.size)
        near = np.exp(-0.5 * ((self.sizes - self.size) / sd) ** 2) / (sd * np.sqrt(2.0 * np.pi))
        gain = np.log(p * near + BACKGROUND / self.span) - np.log(BACKGROUND / self.span)
        return float(np.sum(gain) + (self.total - count) * np.log1p(-p) - np.log(self.total) - 0.5 * np.log(count))


def lone_readings(runs: Sequence[Observed]) -> LoneReadings:
    """Propeller readings that stand alone, in all runs.

    They are looked for in n|n|: a controller that asks for a thrust makes n jump whenever it crosses zero.
    """
    sizes, moves, span = [], [], 0.0
    for run in (run for run in runs if run.input.size >= 5):
        deviation = run.input - median_filter(run.input, size=5, mode="nearest")
        thrust = run.input * np.abs(run.input)
        lone = _stands_alone(thrust, 5, 0.01 * float(np.max(np.abs(thrust))))
        lone &= ~np.roll(lone, 1) & ~np.roll(lone, -1)
        sizes.append(np.abs(deviation[lone]))
        moves.append(np.abs(deviation[~lone]))
        span = max(span, float(np.ptp(run.input)))
    spread = 1.4826 * float(np.median(np.concatenate(moves))) if moves else 0.0
    found = np.concatenate(sizes) if sizes else np.zeros(0)
    return LoneReadings(found, spread, span, sum(run.input.size for run in runs))


def spike_sizes(runs: Sequence[Observed]) -> list[float]:
    """Sizes of spikes to be tried [unit of the input]: that of the lone readings, and shares of the usual input."""
    lone = lone_readings(runs).size
    usual = float(np.sqrt(np.mean(np.concatenate([run.input for run in runs]) ** 2)))
    return ([lone] if lone > 0.0 else []) + [share * usual for share in SPIKE_SHARES]


def spikes(runs: Sequence[Observed], size: float) -> tuple[float, float]:
    """Log evidence of the readings themselves for spikes of a size, and their probability per reading [-].

    Spikes hidden in the usual scatter of the readings leave no trace there; only the range can tell them.
    """
    lone = lone_readings(runs)
    repaired = sum(int(np.sum(_repaired(run.input, size))) for run in runs)
    if repaired < FEWEST:
        return none_seen(lone.total), 0.0
    own = lone.evidence() if lone.sizes.size >= FEWEST else 0.0
    return own - float(np.log(len(SPIKE_SHARES) + 1)), repaired / lone.total


def _repaired(n: np.ndarray, size: float) -> np.ndarray:
    return np.abs(n - median_filter(n, size=3, mode="nearest")) > SEEN * size


def none_seen(total: int) -> float:
    """Log evidence of an outlier effect when no outlier is seen: its rate, uniform up to 0.3, must be tiny."""
    return -float(np.log(0.3 * total + 1.0))


def rate_evidence(count: int, total: int) -> float:
    """Log evidence of `count` outliers of any size among `total` readings against the background's rate."""
    if count < FEWEST:
        return 0.0
    p = count / total
    return float(count * np.log(p / BACKGROUND) + (total - count) * np.log1p(-p) - np.log(total))


def multipath(filtered: Sequence[Filtered], flags: Sequence[np.ndarray]) -> tuple[float, float, float]:
    """Log evidence of multipath against the background, its probability per ping [-] and its excess path [m]."""
    e = np.concatenate([f.innovation[flag] for f, flag in zip(filtered, flags, strict=True)])
    base = np.concatenate([_spread(f, flag) for f, flag in zip(filtered, flags, strict=True)])
    total = sum(flag.size for flag in flags)
    if e.size < FEWEST:
        return none_seen(total), 0.0, 0.0
    extra = float(np.median(e))
    p = e.size / total
    near = np.exp(-0.5 * (e - extra) ** 2 / base) / np.sqrt(2.0 * np.pi * base)
    mixture = np.log(p * near + BACKGROUND / SPAN_M) - np.log(BACKGROUND / SPAN_M)
    occam = np.log(total) + 0.5 * np.log(e.size)
    return float(np.sum(mixture) + (total - e.size) * np.log1p(-p) - occam), p, extra


def _spread(f: Filtered, flag: np.ndarray) -> np.ndarray:
    """Variance of what a flagged ping should have read, from the neighbours that were not flagged [m2]."""
    usual = float(np.median(f.variance[~flag])) if np.any(~flag) else 1e-4
    return np.full(int(flag.sum()), 4.0 * usual)
