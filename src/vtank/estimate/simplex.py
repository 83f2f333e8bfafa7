"""The simplex of Nelder and Mead, J. Computing 7 (1965), as a walk: it asks for costs, so that many walk in step."""

from __future__ import annotations

from collections.abc import Generator, Sequence

import numpy as np

Walk = Generator[Sequence[np.ndarray], list[float], np.ndarray]


def simplex(corners: np.ndarray, evaluations: int, close: float, even: float) -> Walk:
    """Asks for the costs of points, shape (N,), and returns the best; corners: to begin with, shape (N + 1, N).

    It ends once the points are this close and their costs even, or after so many evaluations.
    """
    costs = np.array((yield list(corners)))
    spent, size = len(corners), corners.shape[1]
    while True:
        order = np.argsort(costs, kind="stable")
        corners, costs = corners[order], costs[order]
        flat = np.max(np.abs(corners[1:] - corners[0])) <= close and np.max(np.abs(costs[1:] - costs[0])) <= even
        if flat or spent >= evaluations:
            return np.asarray(corners[0])
        middle, worst = np.sum(corners[:-1], axis=0) / size, corners[-1]
        trial = 2.0 * middle - worst
        (cost,) = yield [trial]
        spent += 1
        if cost < costs[0] or cost >= costs[-2]:
            if spent >= evaluations:
                return np.asarray(corners[0])
            share = 3.0 if cost < costs[0] else 1.5 if cost < costs[-1] else 0.5
            other = share * middle + (1.0 - share) * worst
            (there,) = yield [other]
            spent += 1
            bar = cost if cost < costs[-1] else costs[-1]
            if there < bar or (share == 1.5 and there <= bar):
                trial, cost = other, there
            elif share < 3.0:
                corners[1:] = corners[0] + 0.5 * (corners[1:] - corners[0])
                renewed = slice(1, 1 + max(evaluations - spent, 0))
                if spent < evaluations:
                    costs[renewed] = yield list(corners[renewed])
                spent += size
                continue
        corners[-1], costs[-1] = trial, cost
