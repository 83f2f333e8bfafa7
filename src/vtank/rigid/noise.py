"""The noise of recordings: white errors of the columns, and the disturbance of each axis, where they are likeliest.

White errors start from what is faster than any hull and follow from the innovations; the disturbance of each axis and
its memory are sought by likelihood, on a part of the recording that tells enough of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..lanes import WIDTH
from ..record.repeats import smallest_step
from .filtered import FAR, STILL, Filtered, Left, Noise, share
from .fit import Fit, log_likelihood
from .recorded import Recorded
from .slow import likelihoods
from .thinned import scatter
from .trials import tried

Array = NDArray[np.float64]
Move = Callable[[Noise, int], Noise]
FIRST_SIGMA = np.array([0.02, 0.02, 0.02, 0.05, 0.05, 0.02])  # [m/s2, rad/s2] from which the search starts; guesses
LEAST_SIGMA = 1e-5  # [m/s2, rad/s2] below which a disturbance is none
ENOUGH, ALL = 6000, 40000  # measurements that the noise is sought on first, and at last; choices
FACTORS, FURTHEST = (4.0, 1.6), 4  # by which a size is tried larger and smaller, and how often at once
PROMISE = 1.0  # log-likelihood that another step has to bring
ROUNDS = 12  # at most, in which all of it is sought at one factor
MEMORIES_S = (0.3, 60.0)  # memories between what sensors see at all and a run's length; choices
SPECTRUM = (0.5, -0.5)  # powers of its memory's with which a size goes: what is fast is kept, or what is slow
SLOW = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)  # slow errors, as a variance over the instrument's white; a choice
COLOURED = 0.6  # share of a white error, as a variance, whose place a slow one may take at once; a choice
SLOW_S = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # [s] memory of slow errors; a choice
SURELY = 4.6  # log-likelihood from which an instrument has a slow error: odds of a hundred
LASTS = 0.5  # of the longest run, over which a disturbance that is remembered stands for a steady force; a choice
ERRORS, MEMORY = {"white", "slow", "coloured"}, "memory"  # parts of a noise: instruments', and those of disturbances
KEPT = 0.25  # share of its fastest scatter, as a variance, below which a white error is not believed; a choice


def first_noise(runs: Sequence[Recorded]) -> Noise:
    """White errors from what is faster than any hull, and disturbances to start from."""
    columns = runs[0].layout.columns
    found = [
        np.median([scatter(run.value[run.column == c]) for run in runs if (run.column == c).any()])
        for c in range(len(columns))
    ]
    variance = np.maximum(np.array(found) ** 2, _rounding(runs))
    return Noise(variance, np.where(_disturbed(runs), FIRST_SIGMA, 0.0)).even


def against(fit: Fit) -> float:
    """Log odds, beforehand, against as many slow errors as a noise has, and disturbances that are steady forces.

    What lasts over most of every run is no more turbulence than an instrument's bias is its noise.
    """
    noise, lasts_s = fit.noise, LASTS * max(float(np.ptp(run.time_s)) for run in fit.runs)
    steady = (noise.sigma > STILL) & (noise.memory_s > lasts_s)
    return SURELY * float(np.count_nonzero(noise.slow) + np.count_nonzero(steady))


def _disturbed(runs: Sequence[Recorded]) -> NDArray[np.bool_]:
    """Axes that are disturbed in some run, (6,)."""
    return np.any([run.disturbed for run in runs], axis=0)


def _rounding(runs: Sequence[Recorded]) -> Array:
    """Variance of rounding to the smallest step that each column takes, a twelfth of its square, (C,)."""
    return np.array([resolution(runs, c) ** 2 / 12.0 for c in range(len(runs[0].layout.columns))])


def resolution(runs: Sequence[Recorded], c: int) -> float:
    """Smallest step that a column's values take [its unit]."""
    return smallest_step(np.concatenate([run.value[run.column == c] for run in runs]))


def settle(
    fit: Fit,
    p: Array,
    floor: Array,
    least: Array | float = 0.0,
    *,
    near: bool = False,
    longest_s: float = MEMORIES_S[1],
) -> tuple[Noise, list[Filtered]]:
    """The likeliest noise beside the parameters p, and the filter at it.

    Sought on a part of the recordings, from the fit's and from white errors alone, each to its end: what is coloured
    passes for motion and motion for what is coloured, with a hill between. All of them say which it is.

    floor: variances of the first noise; of these, or of what is fastest in the innovations where that is less because
    the motion itself is fast, a share is always left. least: variances, (C,), below which none is believed whatever the
    innovations are. near: whether the likeliest is near the fit's, and sought on all of the recordings. longest_s:
    memory of a disturbance, at most.
    """
    runs, least = cut(fit.runs, ALL if near else ENOUGH), np.maximum(least, KEPT * _rounding(fit.runs))

    def descended(noise: Noise, floor: Array) -> Noise:
        for factor in FACTORS:
            for _ in range(ROUNDS):
                here = replace(fit, runs=runs, noise=noise)
                before, best = _round(here, p, floor, least, factor, longest_s)
                floor, noise = np.minimum(floor, _fastest(runs, best)), best.noise
                if best.likelihood - before < PROMISE:
                    break
        return noise

    def likely(noise: Noise) -> float:
        return sum(map(log_likelihood, replace(fit, noise=noise).filter(p)))

    if near:
        best = descended(fit.noise, floor)
    else:
        begins = [fit.noise, _all_white(replace(fit, runs=runs), p)]
        best = max(share([partial(descended, noise, floor) for noise in begins]), key=likely)
    return best, replace(fit, noise=best).filter(p)


def _round(fit: Fit, p: Array, floor: Array, least: Array, factor: float, longest_s: float) -> tuple[float, Tried]:
    """A noise moved in every direction that makes it likelier, about the filter at it: likelihood before, and the best.

    Parts of a noise hardly touch each other: each is moved alone first, then all whose move was good together, also
    farther. factor: by which sizes are tried larger and smaller. floor, least, longest_s: as of `settle`.
    """
    found = fit.filter(p)
    start = Tried(fit.noise, sum(map(log_likelihood, found)), found)
    moves = _moves(fit.runs, start, floor, least, factor, longest_s)
    alone = _tried(fit.runs, found, [move(fit.noise, 1) for _, move in moves])
    good = dict[str, Move]()
    for (part, move), there in sorted(zip(moves, alone, strict=True), key=lambda pair: pair[1].likelihood):
        if there.likelihood > start.likelihood:
            good[part] = move
    if not good:
        return start.likelihood, start
    together = []
    for left in (set(), {MEMORY}, ERRORS, {MEMORY, *ERRORS}):
        for power in range(1, FURTHEST + 1):
            noise = fit.noise
            for part, move in good.items():
                noise = noise if part.partition(" ")[0] in left else move(noise, power)
            together.append(noise)
    return start.likelihood, max((start, *alone, *_tried(fit.runs, found, together)), key=_likelihood)


def _moves(
    runs: Sequence[Recorded], start: Tried, floor: Array, least: Array, factor: float, longest_s: float
) -> list[tuple[str, Move]]:
    """Each part of a noise by name, and a move of it: so many times by a factor, or to what its filter says."""
    enough = np.maximum(KEPT * np.minimum(floor, _fastest(runs, start)), least)
    white = np.maximum(_white(runs, start), enough)
    spare = np.minimum(COLOURED * start.noise.variance, np.maximum(start.noise.variance - enough, 0.0))
    slower = dict(zip(("slow", "coloured"), _slower(runs, start, spare), strict=True))
    sigma, ways = start.noise.sigma, (factor, 1.0 / factor)
    moves = [(str(axis), partial(_sized, axis=int(axis), factor=by))
             for axis in np.flatnonzero(sigma > 0.0) for by in ways]  # fmt: skip
    moves += [(f"{MEMORY} {axis}", partial(_remembering, axis=int(axis), factor=by, power=of, longest_s=longest_s))
              for axis in np.flatnonzero(sigma > STILL) for by in ways for of in SPECTRUM]  # fmt: skip
    return [
        *moves,
        ("white", lambda noise, power: replace(noise, variance=white)),
        *((name, partial(_erring, other=other)) for name, other in slower.items()),
    ]


def _sized(noise: Noise, power: int, axis: int, factor: float) -> Noise:
    """With another disturbance of an axis."""
    sigma = noise.sigma.copy()
    sigma[axis] = max(sigma[axis] * factor**power, LEAST_SIGMA)
    return replace(noise, sigma=sigma)


def _erring(noise: Noise, power: int, other: Noise) -> Noise:
    """With the errors of another."""
    return replace(other, sigma=noise.sigma, memory_s=noise.memory_s)


def _remembering(noise: Noise, often: int, axis: int, factor: float, power: float, longest_s: float) -> Noise:
    """With another memory of an axis, by the factor however often the rest is moved, and its size by a power of it."""
    memory_s, sigma = noise.memory_s.copy(), noise.sigma.copy()
    memory_s[axis] = min(max(noise.memory_s[axis] * factor, MEMORIES_S[0]), longest_s)
    sigma[axis] = max(sigma[axis] * (memory_s[axis] / noise.memory_s[axis]) ** power, LEAST_SIGMA)
    return replace(noise, memory_s=memory_s, sigma=sigma)


@dataclass(frozen=True, eq=False)
class Tried:
    """A noise, its likelihood, and what filters at it leave."""

    noise: Noise
    likelihood: float
    found: Sequence[Left]


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
    some = [trials[i : i + WIDTH] for i in range(0, len(trials), WIDTH)]
    parts = share([partial(tried, run, f, noises) for noises in some for run, f in zip(runs, about, strict=True)])
    found = list[Tried]()
    for i, noises in enumerate(some):
        of_run = parts[i * len(runs) : (i + 1) * len(runs)]
        found += [Tried(noise, sum(map(log_likelihood, left)), list(left))
                  for noise, left in zip(noises, zip(*of_run, strict=True), strict=True)]  # fmt: skip
    return found


def cut(runs: Sequence[Recorded], enough: int = ENOUGH) -> tuple[Recorded, ...]:
    """Enough of the recordings, in measurements: runs from the first on, the last of them cut short."""
    found: list[Recorded] = []
    for run in runs:
        left = enough - sum(other.time_s.size for other in found)
        if left < enough // 4 and found:
            break
        found.append(run.until(run.time_s[min(left, run.time_s.size) - 1]))
    return tuple(found)


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


def _slower(runs: Sequence[Recorded], tried: Tried, spare: Array) -> list[Noise]:
    """The noise with the slow error of each column that is likeliest in what its filter leaves beside it, or none.

    That holds the slow error itself, however much of it was foreseen. With white errors as they are; and where these
    may be less at once by the variance spare, (C,), or more by that of the slow error.
    """
    lesser = (np.zeros_like(spare), spare, -(tried.noise.slow**2))
    found = [replace(tried.noise.even, variance=tried.noise.variance.copy()) for _ in range(2)]
    shares, memories = (grid.ravel() for grid in np.meshgrid(SLOW, SLOW_S))
    for c, white in enumerate(tried.noise.variance):
        each = [(run.time_s, f.innovation + f.told.slow, f.told.apart, run.column == c)
                for run, f in zip(runs, tried.found, strict=True) if (run.column == c).any()]  # fmt: skip
        if not each:
            continue
        time_s, e, variance = (np.concatenate([part[i][part[-1]] for part in each]) for i in range(3))
        first = np.concatenate([np.arange(part[-1].sum()) == 0 for part in each])
        sizes, even = np.sqrt(np.append(0.0, shares) * white), np.append(1.0, memories)
        gains = np.empty((len(lesser), sizes.size))
        for less, row in zip(lesser, gains, strict=True):
            likelihoods(time_s, e, variance, first, less[c], sizes, even, row)
        gains[:, 0] += SURELY
        for noise, some in zip(found, (gains[:1], gains), strict=True):
            which, best = divmod(int(np.argmax(some)), sizes.size)
            noise.slow[c], noise.slow_s[c] = sizes[best], even[best]
            noise.variance[c] -= lesser[which][c]
    return found
