"""Search for the plan with the least sum of squared relative bounds in a given time, by exchanging runs.

Information adds over runs, so a plan is a list of runs and its bound the inverse of a sum: A-optimality (Atkinson,
Donev, Tobias, Optimum Experimental Designs, with SAS, 2007), exchange (Fedorov, Theory of Optimal Experiments, 1972).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .flown import Array

SWAPS = 200  # most exchanges of a search; it ends far earlier


class Search:
    """Plans are lists of indices into the items."""

    def __init__(self, matrix: Array, minutes: Array) -> None:
        """matrix: information of each item, shape (J, P, P); minutes: its time with rest, shape (J,)."""
        self.matrix, self.minutes = matrix, minutes

    def cost(self, plan: Sequence[int]) -> float:
        """Sum of the squared relative bounds."""
        return float(_traces(self.matrix[list(plan)].sum(axis=0)[None])[0])

    def with_one_more(self, plan: Sequence[int]) -> Array:
        """Cost of the plan with each item added, shape (J,)."""
        return _traces(self.matrix[list(plan)].sum(axis=0) + self.matrix)

    def filled(self, plan: Sequence[int], budget: float) -> list[int]:
        """The plan with runs added, each time the one with the smallest bound per time, until none has room."""
        plan = list(plan)
        while True:
            used = float(self.minutes[plan].sum())
            room = self.minutes <= budget - used + 1e-9
            if not room.any():
                return plan
            per_time = self.with_one_more(plan) * (used + self.minutes)
            plan.append(int(np.argmin(np.where(room, per_time, np.inf))))

    def exchanged(self, plan: Sequence[int], budget: float) -> list[int]:
        """The plan improved by taking a run out and filling the room again, one other run or several."""
        plan = list(plan)
        for _ in range(SWAPS):
            trials = [trial for k in range(len(plan)) for trial in self._without(plan, k, budget)]
            best = min(trials, key=self.cost)
            if self.cost(best) >= self.cost(plan) * (1.0 - 1e-9):
                return plan
            plan = best
        return plan

    def _without(self, plan: Sequence[int], k: int, budget: float) -> list[list[int]]:
        rest = [*plan[:k], *plan[k + 1 :]]
        room = self.minutes <= budget - self.minutes[rest].sum() + 1e-9
        costs = np.where(room, self.with_one_more(rest), np.inf)
        return [self.filled([*rest, int(np.argmin(costs))], budget), self.filled(rest, budget)]


def _traces(information: Array) -> Array:
    """Trace of the inverse of each, infinite where there is none, shape (J, P, P) -> (J,)."""
    values = np.linalg.eigvalsh(information)
    with np.errstate(divide="ignore"):
        inverse = np.where(values > 1e-12 * values[:, -1:], 1.0 / values, np.inf)
    return np.asarray(inverse.sum(axis=1))
