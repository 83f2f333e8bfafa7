"""Lines: the frequencies at which the innovations of a fit are loudest, as finely as the recordings tell them apart.

A periodogram of all runs together names candidates, whatever the length of the recordings; the exact evidence is left
to those who ask. Bretthorst, Bayesian Spectrum Analysis and Parameter Estimation (1988), ch. 2: the periodogram as
what is enough to know of a single frequency.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..estimate.observed import Observed
from .evidence import Fitted

LINES = 24  # frequencies that are looked at; a choice
WIDE = (1, 2, 4, 8)  # half of a band, in what the longest run resolves; choices
FINER = 4  # points of the periodogram to what the longest run resolves, so that no line falls between two
BESIDE = (-2, -1, 1, 2)  # what a run resolves, off a line: where it hides nothing of what is beside it; a choice


@dataclass(frozen=True)
class Lines:
    """Frequencies, the loudest first.

    Attributes:
        rad_s: frequencies [rad/s], shape (L,).
        log_share: log probability beforehand of each among all that the recordings tell apart, shape (L,): no octave is
            likelier than another.
        level: power beside each over that of white innovations, shape (L,), at least 1: a line stands above it.
    """

    rad_s: np.ndarray
    log_share: np.ndarray
    level: np.ndarray

    def within(self, low: float, high: float) -> Lines:
        """Those from low to high [rad/s]."""
        inside = (self.rad_s >= low) & (self.rad_s <= high)
        return Lines(self.rad_s[inside], self.log_share[inside], self.level[inside])


def judging(fit: Fitted, k: int) -> tuple[np.ndarray, np.ndarray]:
    """By which measurements the readings of run k are judged, range before position before speed; all innovations.

    These over their deviations; shapes (M,).
    """
    run, f = fit.problem.runs[k], fit.filtered[k]
    return run.kind == np.min(run.kind), f.innovation / np.sqrt(f.variance)


def loudest(fit: Fitted, times: Sequence[np.ndarray] | None = None) -> Lines:
    """The loudest frequencies of all runs together, each with a phase of its own, from one period to a run upwards.

    times: of innovations multiplied by something, per run shape (M,), with which what is sought goes.
    """
    runs, usual = [], 1.0 if times is None else float(np.sqrt(np.mean(np.concatenate(times) ** 2))) + 1e-300
    for k, run in enumerate(fit.problem.runs):
        own, off = judging(fit, k)
        counts = own & fit.problem.used(k)
        runs.append((run.time_s[counts], (off if times is None else off * times[k] / usual)[counts]))
    runs = [(t, e) for t, e in runs if t.size > 1]
    step = max((float(np.median(np.diff(t))) for t, _ in runs), default=1.0)
    size = max((int(np.ptp(t) / step) + 1 for t, _ in runs), default=1)
    even = [np.interp(np.arange(t[0], t[-1], step), t, e) for t, e in runs]
    each = np.empty((len(even), FINER * size // 2 + 1))
    for e, row in zip(even, each, strict=True):
        row[:] = np.abs(np.fft.rfft(e, FINER * size)) ** 2
    power = each.sum(axis=0)
    peak = np.flatnonzero((power[1:-1] >= power[:-2]) & (power[1:-1] > power[2:])) + 1
    peak = peak[peak >= FINER]
    peak = peak[np.argsort(-power[peak])][:LINES]
    left, top, right = (np.log(power[peak + i]) for i in (-1, 0, 1))
    bend = np.maximum(2.0 * top - left - right, 1e-12)
    periods = (peak + 0.5 * (right - left) / bend) / FINER  # in the longest run, at the top of a parabola
    level = np.array([_beside(each, [e.size for e in even], int(k)) for k in peak])
    return Lines(2.0 * np.pi * periods / (size * step), _log_share(periods, size // 2), np.maximum(level, 1.0))


def _log_share(periods: np.ndarray, most: int) -> np.ndarray:
    """Log probability beforehand of lines of so many periods in the longest run, which tells up to `most` apart."""
    return np.asarray(-np.log(periods * np.sum(1.0 / np.arange(1, max(most, 1) + 1))))


def bands(runs: Sequence[Observed], rad_s: float) -> list[tuple[np.ndarray, float]]:
    """Bands of frequencies about one, each as what the longest run resolves [rad/s], and its log probability."""
    longest = max(runs, key=lambda run: float(np.ptp(run.time_s)))
    apart = 2.0 * np.pi / max(float(np.ptp(longest.time_s)), 1e-9)
    share = float(_log_share(np.array([max(rad_s / apart, 1.0)]), longest.time_s.size // 2)[0])
    each = [rad_s + apart * np.arange(-wide, wide + 1) for wide in WIDE]
    return [(band, share) for band in each if band[0] > 0.0]


def _beside(power: np.ndarray, sizes: list[int], peak: int) -> float:
    """Mean power of runs of so many samples beside a line, over that of white innovations.

    power: of the runs, shape (R, F). A sine has no power at so many of what its run resolves off it; a resonance has.
    """
    longest, found = FINER * max(sizes), list[float]()
    for row, size in zip(power, sizes, strict=True):
        at = [peak + round(off * longest / size) for off in BESIDE]
        found += [float(row[k]) / size for k in at if 0 < k < row.size]
    return float(np.mean(found)) if found else 1.0
