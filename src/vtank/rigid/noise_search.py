"""The likeliest noise of recordings beside parameters that stay: Fisher scoring in the logarithms of all its parts.

What is coloured passes for motion and motion for what is coloured: no part of a noise is likelier alone than together
with the others, so that all of them move at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..lanes import WIDTH
from .filtered import FAR, Filtered, Left, Noise, share
from .fit import Fit, log_likelihood
from .noise import ENOUGH, KEPT, LEAST_SIGMA, SURELY, cut, rounding
from .recorded import Recorded
from .slow import likelihoods
from .thinned import scatter
from .trials import tried

Array = NDArray[np.float64]
ALL = 40000  # measurements that the noise is sought on at last; a choice
PROMISE = 1.0  # log-likelihood that another step has to bring
STEPS = 30  # at most, of a search
MEMORIES_S = (0.3, 60.0)  # memories between what sensors see at all and a run's length; choices
SLOW = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)  # slow errors looked for, as a variance over the white; a choice
SLOW_S = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # [s] memories of slow errors looked for; a choice
COLOURED = 0.6  # share of a white error, as a variance, whose place a slow one may take; a choice
BARE = 0.04  # of the least white error, what is left of one beside a slow one, which alone may be all; a choice
BEGINNING, LEAST_SLOW = 0.1, 1e-4  # of a white error, as a variance: a slow one at first, and at least; choices
ASIDE = 0.1  # of a logarithm, over which the likelihood is differenced; a choice
DAMPING, LIMITS = (0.0, 0.03, 0.3, 3.0, 30.0), (1.4, 3.4)  # of steps tried at once, and the longest of each; choices
VAGUE = 0.01  # information on a logarithm beforehand, a deviation of 10; a choice
TIMINGS = (1e-5, 1.0)  # share of the time between rows by which inputs may turn early or late; choices
LEAP = 2.1  # of a logarithm, by which memories leap where no step leads on; a choice
EARLY = (TIMINGS[0], 0.03, 0.1, 0.3)  # shares of the time between rows to which the turn of inputs leaps; choices
SIGMAS = (1e-3, 1e-2, 0.1, 1.0)  # [m/s2, rad/s2] to which disturbances leap; choices


class Tried(NamedTuple):
    """A noise, its likelihood, and what filters at it leave."""

    noise: Noise
    likelihood: float
    found: Sequence[Left]


def settle(
    fit: Fit,
    p: Array,
    floor: Array,
    least: Array | float = 0.0,
    *,
    near: bool = False,
    alone: bool = False,
    longest_s: float = MEMORIES_S[1],
) -> tuple[Noise, list[Filtered]]:
    """The likeliest noise beside the parameters p, and the filter at it.

    Sought on a part of the recordings, from the fit's and from white errors alone, each to its end: between what is
    coloured and what moves there may be a hill. All of them say which it is.

    floor: variances of the first noise; of these, or of what is fastest in the innovations where that is less because
    the motion itself is fast, a share is always left. least: variances, (C,), below which none is believed whatever the
    innovations are. near: whether the likeliest is near the fit's, and sought on all of the recordings. alone:
    whether it is sought from the fit's alone. longest_s: memory of a disturbance, at most.
    """
    part = replace(fit, runs=cut(fit.runs, ALL if near else ENOUGH))
    descend = partial(_descended, part, p, floor, np.maximum(least, KEPT * rounding(fit.runs)), longest_s, near)

    def likely(noise: Noise) -> float:
        return sum(map(log_likelihood, replace(fit, noise=noise).filter(p)))

    if near or alone:
        best = descend(fit.noise)
    else:
        best = max(share([partial(descend, noise) for noise in (fit.noise, _all_white(part, p))]), key=likely)
    return best, replace(fit, noise=best).filter(p)


@dataclass(frozen=True, eq=False)
class Parts:
    """The parts of a noise that a search moves, in logarithms.

    White variances, slow ones and their memories of the columns that have any, disturbances as variances and their
    memories of the axes that have any, and when inputs turn, as a variance. low, high: bounds of these.
    """

    noise: Noise
    slow: NDArray[np.intp]
    axes: NDArray[np.intp]
    low: Array
    high: Array

    @classmethod
    def of(cls, noise: Noise, enough: Array, least: Array, longest_s: float) -> Parts:
        """Of a noise; enough: least white variances where nothing is coloured, (C,); least: least ones of any."""
        slow, axes = np.flatnonzero(noise.slow > 0.0), np.flatnonzero(noise.sigma > 0.0)
        enough = np.where(noise.slow > 0.0, np.maximum(BARE * enough, least), enough)
        any_slow, any_axis, large = np.ones(slow.size), np.ones(axes.size), np.inf
        low = (enough, LEAST_SLOW * noise.errors[slow], SLOW_S[0] * any_slow,
               LEAST_SIGMA**2 * any_axis, MEMORIES_S[0] * any_axis, [TIMINGS[0] ** 2])  # fmt: skip
        high = (np.full(enough.size, large), large * any_slow, SLOW_S[-1] * any_slow,
                large * any_axis, longest_s * any_axis, [TIMINGS[1] ** 2])  # fmt: skip
        return cls(noise, slow, axes, np.log(np.concatenate(low)), np.log(np.concatenate(high)))

    @property
    def place(self) -> Array:
        """Where its noise is, within the bounds, (N,)."""
        noise, slow, axes = self.noise, self.slow, self.axes
        parts = (noise.variance, noise.slow[slow] ** 2, noise.slow_s[slow],
                 noise.sigma[axes] ** 2, noise.memory_s[axes], [max(noise.timing, TIMINGS[0]) ** 2])  # fmt: skip
        return self.within(np.log(np.concatenate(parts)))

    def within(self, x: Array) -> Array:
        """Within the bounds."""
        return np.asarray(np.clip(x, self.low, self.high))

    def at(self, x: Array) -> Noise:
        """The noise of a place."""
        n, s, a = self.noise.variance.size, self.slow.size, self.axes.size
        variance, slow, slow_s, sigma, memory_s, timing = np.split(np.exp(x), np.cumsum([n, s, s, a, a]))
        now = self.noise
        found = replace(now, variance=variance, slow=now.slow.copy(), slow_s=now.slow_s.copy(),
                        sigma=now.sigma.copy(), memory_s=now.memory_s.copy(),
                        timing=float(np.sqrt(timing[0])))  # fmt: skip
        found.slow[self.slow], found.slow_s[self.slow] = np.sqrt(slow), slow_s
        found.sigma[self.axes], found.memory_s[self.axes] = np.sqrt(sigma), memory_s
        return found

    def leaps(self, near: bool) -> Iterator[Array]:
        """Places far off: other disturbances of an axis, longer or shorter slow errors, inputs that turn so far off.

        near: whether disturbances are remembered as they were.
        """
        here, n, s, a = self.place, self.noise.variance.size, self.slow.size, self.axes.size

        def leap(part: int, to: float, memory: int, longer: float = 0.0) -> Array:
            x = here.copy()
            x[part] = to
            x[memory] += longer
            return self.within(x)

        for size in range(n + 2 * s, n + 2 * s + a):
            yield leap(size, self.low[size], size + a)
            for sigma in SIGMAS:
                for longer in (0.0,) if near else (LEAP, 0.0, -LEAP):
                    yield leap(size, 2.0 * np.log(sigma), size + a, longer)
        for memory in range(n + s, n + 2 * s):
            for longer in (LEAP, -LEAP):
                yield leap(memory, here[memory], memory, longer)
        for early in EARLY:
            yield leap(-1, 2.0 * np.log(early), -1)


def _descended(fit: Fit, p: Array, floor: Array, least: Array, longest_s: float, near: bool, noise: Noise) -> Noise:
    """The noise that no step makes likelier, without slow errors that do not earn their place.

    One at which the filter itself loses its way, whatever was foreseen of it, is none.
    """
    before = noise
    for n in range(STEPS):
        try:
            found = replace(fit, noise=noise).filter(p)
        except InputError:
            if n == 0:
                raise
            noise = before
            break
        start = Tried(noise, sum(map(log_likelihood, found)), found)
        floor = np.minimum(floor, _fastest(fit.runs, start))
        enough = np.maximum(KEPT * floor, least)
        parts = Parts.of(_slower(fit.runs, start, enough), enough, least, longest_s)
        best = max((start, *_scored(fit.runs, found, parts)), key=_likelihood)
        if best.likelihood - start.likelihood < PROMISE:
            parts = Parts.of(best.noise, enough, least, longest_s)
            best = max((best, *_tried(fit.runs, found, [parts.at(x) for x in parts.leaps(near)])), key=_likelihood)
        before, noise = noise, best.noise
        if not best.likelihood - start.likelihood >= PROMISE:
            break
    return _earning(fit, p, noise)


def _scored(runs: Sequence[Recorded], about: Sequence[Filtered], parts: Parts) -> list[Tried]:
    """Steps of Fisher scoring from the place of the parts, more or less damped, linear about the path of a filter.

    Information of Gaussian innovations e of variance S: de/dx de/dx' / S + dS/dx dS/dx' / (2 S^2), summed. Harvey,
    Forecasting, Structural Time Series Models and the Kalman Filter (1989), section 3.4.5.
    """
    x = parts.place
    aside = np.where(x + ASIDE <= parts.high, ASIDE, -ASIDE)
    here, *there = _tried(runs, about, [parts.at(x), *(parts.at(row) for row in x + np.diag(aside))])
    gradient = (np.array([t.likelihood for t in there]) - here.likelihood) / aside
    e, S = _told(here)
    moved = [((a - e) / by, (b - S) / by) for (a, b), by in zip(map(_told, there), aside, strict=True)]
    counts = np.minimum(1.0, FAR / np.maximum(np.abs(e) / np.sqrt(S), FAR))
    tells = np.array([np.append(np.sqrt(counts / S) * de, dS / (np.sqrt(2.0) * S)) for de, dS in moved])
    free = np.flatnonzero(((x > parts.low) | (gradient > 0.0)) & ((x < parts.high) | (gradient < 0.0)))
    information = tells[free] @ tells[free].T
    steps = []
    for damping in DAMPING:
        step = np.zeros(x.size)
        more = damping * np.diag(information) + VAGUE
        step[free] = np.linalg.solve(information + np.diag(more), gradient[free])
        steps += [parts.within(x + np.clip(step, -most, most)) for most in LIMITS]
    return [here, *_tried(runs, about, [parts.at(to) for to in steps])]


def _told(tried: Tried) -> tuple[Array, Array]:
    """Innovations and their variances, the wall where they have it, (M,) each."""
    S = np.concatenate([left.variance for left in tried.found])
    return np.concatenate([left.z for left in tried.found]) * np.sqrt(S), S


def _earning(fit: Fit, p: Array, noise: Noise) -> Noise:
    """The noise without the slow errors that are not surely likelier than white ones, or none, in their place."""
    while (slow := np.flatnonzero(noise.slow > 0.0)).size:
        found = replace(fit, noise=noise).filter(p)
        less = []
        for c in slow:
            without = np.where(np.arange(noise.slow.size) == c, 0.0, noise.slow)
            less += [replace(noise, slow=without, variance=v) for v in
                     (noise.variance, np.where(without == noise.slow, noise.variance, noise.errors))]  # fmt: skip
        best = max(_tried(fit.runs, found, less), key=_likelihood)
        if best.likelihood < sum(map(log_likelihood, found)) - SURELY:
            break
        noise = best.noise
    return noise


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


def _fastest(runs: Sequence[Recorded], tried: Tried) -> Array:
    """Variance of what is faster than a parabola in the innovations of each column, (C,)."""
    variance = np.full(tried.noise.variance.size, np.inf)
    for c in range(variance.size):
        each = [scatter(f.innovation[run.column == c]) for run, f in zip(runs, tried.found, strict=True)
                if (run.column == c).any()]  # fmt: skip
        variance[c] = np.median(each) ** 2 if each else np.inf
    return variance


def _slower(runs: Sequence[Recorded], start: Tried, enough: Array) -> Noise:
    """The noise with a small slow error more of each column whose innovations surely hold one, white errors aside.

    enough: least white variances, (C,). What holds one, with its white error as it is or less, likes some grid of sizes
    and memories better than none.
    """
    noise = start.noise if start.noise.slow.size == start.noise.variance.size else start.noise.even
    found = replace(noise, slow=noise.slow.copy(), slow_s=noise.slow_s.copy())
    spare = np.minimum(COLOURED * noise.variance, np.maximum(noise.variance - enough, 0.0))
    shares, memories = (grid.ravel() for grid in np.meshgrid(SLOW, SLOW_S))
    for c in np.flatnonzero(noise.slow == 0.0):
        each = [(run.time_s, f.innovation, f.told.apart, run.column == c)
                for run, f in zip(runs, start.found, strict=True) if (run.column == c).any()]  # fmt: skip
        if not each:
            continue
        time_s, e, variance = (np.concatenate([part[i][part[-1]] for part in each]) for i in range(3))
        first = np.concatenate([np.arange(part[-1].sum()) == 0 for part in each])
        gains = np.empty((2, shares.size))
        for less, row in zip((0.0, spare[c]), gains, strict=True):
            likelihoods(time_s, e, variance, first, less, np.sqrt(shares * noise.variance[c]), memories, row)
        if gains.max() > SURELY:
            found.slow[c] = np.sqrt(BEGINNING * noise.variance[c])
            found.slow_s[c] = memories[int(np.argmax(gains)) % shares.size]
    return found
