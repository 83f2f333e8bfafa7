"""Evidence for groups of free-form columns beside a linear model, one group after the other.

Coefficients of a group are normally distributed about zero at a size that is marginalised over; its gain of evidence is
that of a Gaussian linear model (Rasmussen and Williams (2006), ch. 2), less what looking at several groups costs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SIZES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)  # deviation of a function, as a share of what is usual at its place
GROUPS = 4  # that are taken together; a choice


def pursue(gram: Array, groups: Sequence[slice]) -> tuple[float, float, list[int], Array]:
    """What the best groups together gain of log evidence and of log likelihood; their numbers, the best first; and all
    coefficients, (L,).

    gram: inner products of innovations and columns, shape (1 + L, 1 + L); groups: their columns therein. The first
    group is taken whatever it gains.
    """
    K, total, look = gram.copy(), 0.0, float(np.log(max(len(groups), 1)))
    chosen, weight = list[int](), np.zeros(gram.shape[0])
    while len(chosen) < min(GROUPS, len(groups)):
        trials = [(*evidence(K, part), n) for n, part in enumerate(groups) if n not in chosen]
        gain, size, n = max(trials)
        if chosen and gain < look:
            break
        total += gain - look
        chosen.append(n)
        part = groups[n]
        weight[part] = size
        inner = K[part, part] + np.eye(part.stop - part.start) / size**2
        K -= K[:, part] @ np.linalg.solve(inner, K[part, :])
    used, coefficients = np.flatnonzero(weight), np.zeros(gram.shape[0])
    inner = gram[np.ix_(used, used)] + np.diag(weight[used] ** -2.0)
    coefficients[used] = np.linalg.solve(inner, -gram[used, 0])
    seen = -float(coefficients @ (gram[:, 0] + 0.5 * gram @ coefficients))
    return total, seen, chosen, coefficients[1:]


def evidence(gram: Array, part: slice) -> tuple[float, float]:
    """Gain of log evidence of one group, over sizes alike likely; and the likeliest size."""
    values, vectors = np.linalg.eigh(gram[part, part])
    values, b = np.maximum(values, 0.0), vectors.T @ gram[part, 0]
    s2 = np.array(SIZES)[:, None] ** 2
    gains = 0.5 * np.sum(s2 * b * b / (1.0 + s2 * values) - np.log1p(s2 * values), axis=1)
    top = float(gains.max())
    return top + float(np.log(np.mean(np.exp(gains - top)))), SIZES[int(np.argmax(gains))]
