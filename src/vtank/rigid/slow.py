"""Slow errors of instruments, as innovations of a filter tell them that takes all errors for white."""

from __future__ import annotations

import math

from ..compiled import law
from .filtered import FAR


@law
def likelihoods(time_s, e, variance, first, less, slow, slow_s, out):
    """Log-likelihood of one column's innovations at each of G slow errors, over that without one, into `out`, (G,).

    variance: of the innovations without a slow error, (M,); less: what of it is white no more beside one. first:
    whether a sample is the first of its run, (M,).
    """
    for g in range(slow.size):
        x, P, last, total, step, held = 0.0, 0.0, 0.0, 0.0, 0.0, 1.0
        for m in range(e.size):
            if time_s[m] - last != step:
                step = time_s[m] - last
                held = math.exp(-step / slow_s[g])
            keep = 0.0 if first[m] else held
            x *= keep
            P = slow[g] ** 2 + keep**2 * (P - slow[g] ** 2)
            white = variance[m] - less
            left, new = white + P, e[m] - x
            z, z0 = abs(new) / math.sqrt(left), abs(e[m]) / math.sqrt(variance[m])
            total -= 0.5 * (bent(z) - bent(z0) + math.log(left / variance[m]))
            if z <= FAR:
                x += P / left * new
                P *= white / left
            last = time_s[m]
        out[g] = total


@law
def bent(z):
    """Huber's measure of a deviation: its square, beyond FAR growing with it alone."""
    return z * z if z <= FAR else FAR * (2.0 * z - FAR)
