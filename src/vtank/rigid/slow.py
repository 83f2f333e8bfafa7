"""Slow errors of instruments, as innovations of a filter tell them that takes all errors for white."""

from __future__ import annotations

import math

from ..compiled import law
from .filtered import FAR


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
