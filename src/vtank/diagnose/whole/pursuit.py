"""Evidence for groups of free-form columns beside a linear model, one group after the other.

Coefficients of a group are normally distributed about zero at a size that is marginalised over; its gain of evidence is
that of a Gaussian linear model (Rasmussen and Williams (2006), ch. 2), less what looking at several groups costs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..freeform.pursuit import along, inside

Array = NDArray[np.float64]
SIZES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)  # deviation of a function, as a share of what is usual at its place
GROUPS = 8  # that are taken together; a choice


def pursue(
    gram: Array, groups: Sequence[slice], windows: Sequence[slice] = ()
) -> tuple[float, float, list[int], Array]:
    """What the best groups together gain of log evidence and of log likelihood; their numbers, the best first; and all
    coefficients, (L,).

    gram: inner products of innovations and columns, shape (1 + L, 1 + L); groups: their columns therein; windows: of
    bins of time in which something may be off by one amount from any bin to any, numbered after the groups. The first
    one is taken whatever it gains.
    """
    K, total, look = gram.copy(), 0.0, float(np.log(max(len(groups) + len(windows), 1)))
    chosen, parts, sizes = list[int](), list[Array](), list[Array]()
    while len(chosen) < min(GROUPS, len(groups) + len(windows)):
        trials = [(*evidence(K, part), n) for n, part in enumerate(groups) if n not in chosen]
        gain, size, n = max(trials, default=(-np.inf, 1.0, 0))
        part = np.eye(gram.shape[0])[:, groups[n]] if groups else np.empty((gram.shape[0], 0))
        for m, bins in enumerate(windows):
            there, suits, window = _window(K, bins)
            if there > gain:
                gain, size, n, part = there, suits, len(groups) + m, window
        if chosen and gain < look:
            break
        total += gain - look
        chosen.append(n)
        parts.append(part)
        sizes.append(np.full(part.shape[1], size**-2.0))
        pull = K @ part
        K -= pull @ np.linalg.solve(part.T @ pull + np.diag(sizes[-1]), pull.T)
    every = np.hstack(parts)
    coefficients = every @ np.linalg.solve(
        every.T @ gram @ every + np.diag(np.concatenate(sizes)), -every.T @ gram[:, 0]
    )
    seen = -float(coefficients @ (gram[:, 0] + 0.5 * gram @ coefficients))
    return total, seen, chosen, coefficients[1:]


def _window(gram: Array, bins: slice) -> tuple[float, float, Array]:
    """The window from some bin to some other that gains most: its gain, its likeliest size, and which bins it spans."""
    first, last = np.triu_indices(bins.stop - bins.start + 1, 1)
    square = np.maximum(inside(gram[bins, bins], first, last), 0.0)
    gains, sizes = _over_sizes(_gains(square, along(gram[bins, 0], first, last)))
    k = int(np.argmax(gains))
    spanned = np.zeros((gram.shape[0], 1))
    spanned[bins.start + first[k] : bins.start + last[k]] = 1.0
    return float(gains[k]) - float(np.log(gains.size)), float(sizes[k]), spanned


def evidence(gram: Array, part: slice) -> tuple[float, float]:
    """Gain of log evidence of one group, over sizes alike likely; and the likeliest size."""
    values, vectors = np.linalg.eigh(gram[part, part])
    values, b = np.maximum(values, 0.0), vectors.T @ gram[part, 0]
    gains, sizes = _over_sizes(np.sum(_gains(values, b), axis=1, keepdims=True))
    return float(gains[0]), float(sizes[0])


def _gains(values: Array, b: Array) -> Array:
    """Gain at each size of coefficients that do not touch each other, (sizes, C)."""
    s2 = np.array(SIZES)[:, None] ** 2
    return np.asarray(0.5 * (s2 * b * b / (1.0 + s2 * values) - np.log1p(s2 * values)))


def _over_sizes(gains: Array) -> tuple[Array, Array]:
    """Gains over sizes alike likely, and the likeliest size, (C,), of gains at each, (sizes, C)."""
    return np.logaddexp.reduce(gains, axis=0) - np.log(len(SIZES)), np.array(SIZES)[np.argmax(gains, axis=0)]
