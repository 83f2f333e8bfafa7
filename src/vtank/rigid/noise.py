"""The noise of recordings: white errors of the columns, and the disturbance of each axis, where they are likeliest.

White errors start from what is faster than any hull and follow from the innovations; the disturbance of each axis, one
at a time since they hardly touch each other, and the memory of all are sought by likelihood, on a part of the recording
that tells enough of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from .filtered import FAR, Filtered, Noise, refiltered, share
from .fit import Fit, log_likelihood
from .recorded import Recorded, scatter
from .slow import likelihoods

Array = NDArray[np.float64]
FIRST_SIGMA = np.array([0.02, 0.02, 0.02, 0.05, 0.05, 0.02])  # [m/s2, rad/s2] from which the search starts; guesses
LEAST_SIGMA = 1e-5  # [m/s2, rad/s2] below which a disturbance is none
ENOUGH, ALL = 6000, 40000  # measurements that the noise is sought on first, and at last; choices
FACTORS, FURTHEST = (4.0, 1.6), 5  # by which a size is tried larger and smaller, and how often in one direction
PROMISE = 1.0  # log-likelihood that another step has to bring
ROUNDS = 12  # at most, in which all of it is sought at one factor
MEMORIES_S = (0.3, 60.0)  # memory between what sensors see at all and a run's length; choices
SLOW = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0)  # slow errors of an instrument, as a variance over its white error; a choice
SLOW_S = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # [s] memory of slow errors; a choice
SURELY = 4.6  # log-likelihood from which an instrument has a slow error: odds of a hundred
KEPT = 0.25  # share of its fastest scatter, as a variance, below which a white error is not believed; a choice


def first_noise(runs: Sequence[Recorded]) -> Noise:
    """White errors from what is faster than any hull, and disturbances to start from."""
    columns = runs[0].layout.columns
    found = [
        np.median([scatter(run.value[run.column == c]) for run in runs if (run.column == c).any()])
        for c in range(len(columns))
    ]
    variance = np.maximum(np.array(found) ** 2, _rounding(runs))
    return Noise(variance, np.where(runs[0].moves, FIRST_SIGMA, 0.0)).even


def _rounding(runs: Sequence[Recorded]) -> Array:
    """Variance of rounding to the smallest step that each column takes, a twelfth of its square, (C,)."""
    return np.array([_resolution(runs, c) ** 2 / 12.0 for c in range(len(runs[0].layout.columns))])


def _resolution(runs: Sequence[Recorded], c: int) -> float:
    """Smallest step that a column's values take [its unit]."""
    values = np.unique(np.concatenate([run.value[run.column == c] for run in runs]))
    gaps = np.diff(values)
    gaps = gaps[gaps > 1e-9 * max(float(np.abs(values).max(initial=0.0)), 1e-12)]
    return float(gaps.min()) if gaps.size else 1e-9


def settle(
    fit: Fit,
    p: Array,
    floor: Array,
    enough: int = ENOUGH,
    least: Array | float = 0.0,
    *,
    near: bool = False,
    longest_s: float = MEMORIES_S[1],
) -> tuple[Noise, list[Filtered]]:
    """The likeliest noise beside the parameters p, and the filter at it.

    floor: variances of the first noise; of these, or of what is fastest in the innovations where that is less because
    the motion itself is fast, a share is always left. enough: measurements to seek it on. least: variances, (C,), below
    which none is believed whatever the innovations are. near: whether the likeliest is near the fit's. longest_s:
    memory of the disturbance, at most.
    """
    runs, least = cut(fit.runs, enough), np.maximum(least, KEPT * _rounding(fit.runs))
    begins = [fit.noise, *([] if near else [_all_white(replace(fit, runs=runs), p)])]
    for factor in FACTORS[1:] if near else FACTORS:
        for _ in range(ROUNDS):
            rounds = [
                _round(replace(fit, runs=runs, noise=noise), p, floor, least, factor, longest_s) for noise in begins
            ]
            before, best = max(rounds, key=lambda pair: pair[1].likelihood)
            floor, begins = np.minimum(floor, _fastest(runs, best)), [best.noise]
            if best.likelihood - before < PROMISE:
                break
    return best.noise, replace(fit, noise=best.noise).filter(p)


def _round(fit: Fit, p: Array, floor: Array, least: Array, factor: float, longest_s: float) -> tuple[float, Tried]:
    """Each part of a noise once about the filter at it: the likelihood before, and the likeliest noise.

    factor: by which sizes are tried larger and smaller. floor, least, longest_s: as of `settle`.
    """
    runs, noise = fit.runs, fit.noise
    trials = partial(_tried, runs, fit.filter(p))
    best = start = trials([noise])[0]
    for axis in np.flatnonzero(noise.sigma > 0.0):
        for _ in range(FURTHEST):
            before = best.likelihood
            best = max((best, *trials(_sizes(best.noise, int(axis), factor))), key=_likelihood)
            if best.likelihood - before < PROMISE:
                break
    best = max((best, *trials(_memories(best.noise, factor, longest_s))), key=_likelihood)
    enough = np.maximum(KEPT * np.minimum(floor, _fastest(runs, best)), least)
    best = max((best, *trials([replace(best.noise, variance=np.maximum(_white(runs, best), enough))])), key=_likelihood)
    for _ in range(FURTHEST):
        before = best.likelihood
        best = max((best, *trials([_slower(runs, best)])), key=_likelihood)
        if best.likelihood - before < PROMISE:
            break
    return start.likelihood, best


@dataclass(frozen=True, eq=False)
class Tried:
    """A noise, its likelihood, and the filters at it."""

    noise: Noise
    likelihood: float
    found: list[Filtered]


def _all_white(fit: Fit, p: Array) -> Noise:
    """All that a still water leaves taken for white errors: where the search may begin as well.

    Known motion brings its own noise into an accelerometer, which from below looks like a disturbance.
    """
    still = replace(fit.noise, sigma=np.where(fit.noise.sigma > 0.0, LEAST_SIGMA, 0.0)).even
    found = replace(fit, noise=still).filter(p)
    column = np.concatenate([run.column for run in fit.runs])
    e = np.concatenate([f.innovation for f in found])
    variance = still.variance.copy()
    for c in range(variance.size):
        if (column == c).any():
            variance[c] = max(variance[c], float(np.mean(e[column == c] ** 2)))
    return replace(still, variance=variance)


def _likelihood(tried: Tried) -> float:
    return tried.likelihood


def _tried(runs: Sequence[Recorded], about: Sequence[Filtered], trials: Sequence[Noise]) -> list[Tried]:
    """Several noises tried, linear about the path of a filter."""

    def one(noise: Noise) -> Tried:
        found = [refiltered(run, f, noise) for run, f in zip(runs, about, strict=True)]
        return Tried(noise, sum(map(log_likelihood, found)), found)

    return share([partial(one, noise) for noise in trials])


def cut(runs: Sequence[Recorded], enough: int = ENOUGH) -> tuple[Recorded, ...]:
    """Enough of the recordings, in measurements: runs from the first on, the last of them cut short."""
    found: list[Recorded] = []
    for run in runs:
        left = enough - sum(other.time_s.size for other in found)
        if left < enough // 4 and found:
            break
        found.append(run.until(run.time_s[min(left, run.time_s.size) - 1]))
    return tuple(found)


def _sizes(noise: Noise, axis: int, factor: float) -> list[Noise]:
    trials = []
    for size in (noise.sigma[axis] * factor, noise.sigma[axis] / factor):
        sigma = noise.sigma.copy()
        sigma[axis] = max(size, LEAST_SIGMA)
        trials.append(replace(noise, sigma=sigma))
    return trials


def _memories(noise: Noise, factor: float, longest_s: float) -> list[Noise]:
    """A longer and a shorter memory, with the size that leaves what is slow as it is, and with the same."""
    longer, shorter = min(noise.memory_s * factor, longest_s), max(noise.memory_s / factor, MEMORIES_S[0])
    return [replace(noise, memory_s=memory) for memory in (longer, shorter)]


def _fastest(runs: Sequence[Recorded], tried: Tried) -> Array:
    """Variance of what is faster than a parabola in the innovations of each column, (C,)."""
    variance = np.full(tried.noise.variance.size, np.inf)
    for c in range(variance.size):
        each = [scatter(f.innovation[run.column == c]) for run, f in zip(runs, tried.found, strict=True)
                if (run.column == c).any()]  # fmt: skip
        variance[c] = np.median(each) ** 2 if each else np.inf
    return variance


def _white(runs: Sequence[Recorded], tried: Tried) -> Array:
    """White errors that agree with the innovations, (C,).

    What an innovation e and the analysis residual share, E[(e - H K e) e], is the white error's variance (Desroziers,
    Berre, Chapnik, Poli, Q. J. R. Meteorol. Soc. 131 (2005)).
    """
    column = np.concatenate([run.column for run in runs])
    e, S, known = (
        np.concatenate([getattr(f.told, part) for f in tried.found]) for part in ("innovation", "variance", "explained")
    )
    keep, variance = np.abs(e) < FAR * np.sqrt(S), tried.noise.variance.copy()
    for c in range(variance.size):
        mine = keep & (column == c)
        if mine.any():
            variance[c] = np.mean(e[mine] ** 2 * (1.0 - known[mine] / S[mine]))
    return variance


def _slower(runs: Sequence[Recorded], tried: Tried) -> Noise:
    """The noise with the slow error of each column that is likeliest in what its filter leaves beside it, or none.

    That holds the slow error itself, however much of it was foreseen.
    """
    slow, slow_s = np.zeros(tried.noise.variance.size), np.ones(tried.noise.variance.size)
    shares, memories = (grid.ravel() for grid in np.meshgrid(SLOW, SLOW_S))
    for c, white in enumerate(tried.noise.variance):
        each = [(run.time_s, f.innovation + f.told.slow, f.told.apart, run.column == c)
                for run, f in zip(runs, tried.found, strict=True) if (run.column == c).any()]  # fmt: skip
        if not each:
            continue
        time_s, e, variance = (np.concatenate([part[i][part[-1]] for part in each]) for i in range(3))
        first = np.concatenate([np.arange(part[-1].sum()) == 0 for part in each])
        sizes, gains = np.sqrt(shares * white), np.empty(shares.size)
        likelihoods(time_s, e, variance, first, sizes, memories, gains)
        best = int(np.argmax(gains))
        if gains[best] > SURELY:
            slow[c], slow_s[c] = sizes[best], memories[best]
    return replace(tried.noise, slow=slow, slow_s=slow_s)
