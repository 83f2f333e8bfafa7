"""Slow errors of instruments: what a filter that takes errors for white leaves of them in its innovations, taken out.

An instrument that drifts a little errs by an Ornstein-Uhlenbeck process beside its white error. The innovations of its
column then go on from one sample to the next; a Kalman filter of one state for each column, which follows them, makes
them white again. It is linear in them, so that what a change of the model does to them goes through it alike.
Farrell, Aided Navigation (2008), ch. 4: errors of inertial instruments as white noise and Gauss-Markov processes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compiled import law

Array = NDArray[np.float64]
FAR = 4.0  # deviations beyond which a measurement counts less and less, and tells nothing of a slow error; a choice


class Tint(NamedTuple):
    """The filters of the columns of one run, for M measurements.

    column: (M,); keep: share of the slow error that is left since the sample before, gain: what of an innovation goes
    on, (M,); variance: of what is left of the innovations, (M,) [unit squared]; any: whether there is a slow error.
    """

    column: NDArray[np.int64]
    keep: Array
    gain: Array
    variance: Array
    any: bool

    def without(self, e: Array) -> Array:
        """Innovations, or changes of them, (M,) or (M, L), without what goes on from the samples before."""
        if not self.any:
            return e
        left = e[:, None].copy() if e.ndim == 1 else e.copy()
        self.take(left)
        return left[:, 0] if e.ndim == 1 else left

    def take(self, e: Array) -> None:
        """As `without`, in place on changes of innovations, (M, L)."""
        if self.any:
            separate(self.column, self.keep, self.gain, e)


def tint_of(column: NDArray[np.int64], time_s: Array, e: Array, variance: Array, slow: Array, slow_s: Array) -> Tint:
    """For innovations e of a variance, in order of time; slow, slow_s: deviation and memory of each column's, (C,)."""
    if not slow.any():
        none = np.zeros(e.size)
        return Tint(column, none, none, variance, False)
    keep, gain, left = np.zeros((3, e.size))
    follow(column, time_s, e, variance, slow, slow_s, keep, gain, left)
    return Tint(column, keep, gain, left, True)


@law
def follow(column, time_s, e, variance, slow, slow_s, keep, gain, left):
    """Fill keep, gain and the variance left of a `Tint`. A spike is no slow error's."""
    size = slow.size
    x, P, last = np.zeros(size), slow * slow, np.full(size, -np.inf)
    for m in range(e.size):
        c = column[m]
        left[m] = variance[m]
        if slow[c] > 0.0:
            keep[m] = math.exp((last[c] - time_s[m]) / slow_s[c])
            x[c] *= keep[m]
            P[c] = slow[c] ** 2 + keep[m] ** 2 * (P[c] - slow[c] ** 2)
            left[m] = variance[m] + P[c]
            new = e[m] - x[c]
            if abs(new) <= FAR * math.sqrt(left[m]):
                gain[m] = P[c] / left[m]
                x[c] += gain[m] * new
                P[c] *= 1.0 - gain[m]
            last[c] = time_s[m]


@law
def separate(column, keep, gain, e):
    """`Tint.without`, in place on e, (M, L)."""
    x = np.zeros((column.max() + 1, e.shape[1]))
    for m in range(e.shape[0]):
        c = column[m]
        for w in range(e.shape[1]):
            on = keep[m] * x[c, w]
            e[m, w] -= on
            x[c, w] = on + gain[m] * e[m, w]


@law
def likelihoods(time_s, e, variance, first, slow, slow_s, out):
    """Log-likelihood of one column's innovations at each of G slow errors, over that without one, into `out`, (G,).

    first: whether a sample is the first of its run, (M,).
    """
    for g in range(slow.size):
        x, P, last, total = 0.0, 0.0, 0.0, 0.0
        for m in range(e.size):
            keep = 0.0 if first[m] else math.exp((last - time_s[m]) / slow_s[g])
            x *= keep
            P = slow[g] ** 2 + keep**2 * (P - slow[g] ** 2)
            left, new = variance[m] + P, e[m] - x
            z, z0 = abs(new) / math.sqrt(left), abs(e[m]) / math.sqrt(variance[m])
            total -= 0.5 * (bent(z) - bent(z0) + math.log(left / variance[m]))
            if z <= FAR:
                x += P / left * new
                P *= variance[m] / left
            last = time_s[m]
        out[g] = total


@law
def bent(z):
    """Huber's measure of a deviation: its square, beyond FAR growing with it alone."""
    return z * z if z <= FAR else FAR * (2.0 * z - FAR)
