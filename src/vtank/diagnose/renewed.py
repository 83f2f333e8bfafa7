"""What a budget would be on new data of which the truth is known, and what it should be: the error of a budget.

Every run is made once more, by a cause drawn by its probability, with parameters that the data leave possible, and
with turbulence and noise anew (`new_data.py`). The models that share the gap out foretell the new parts as they did the
old ones. The true share of a step is what it takes off the mean square of the distance to the true model; products of
that distance with the disturbance average out in the long run, but not over a few runs, where both are slow.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .holdout import Overlaid
from .new_data import Cause, NewData
from .shrink import Parts

SETS = 64  # of new runs


def renewed(
    new: NewData, parts: Parts, steps: Sequence[Sequence[Overlaid]], seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Sums of squares after each step on SETS sets of new data, as stated and in truth, shapes (S, SETS).

    steps: per part, the models entering it, the nominal first.
    """
    stated, true = np.zeros((2, len(steps[0]), SETS))
    for own, cause, rngs in new.drawn([(seed, i) for i in range(SETS)]):
        thetas = [cause.draw(rng) for rng in rngs]
        for run in range(len(new.targets)):
            truths, value = cause.new_runs(thetas, run, rngs)
            for k in (k for k, parent in enumerate(parts.parent) if parent == run):
                fed, here = parts.inside(k)
                known = _repeating(cause, steps[k][0], run, fed, here).errors(value[here], truths)
                for i, step in enumerate(steps[k]):
                    errors = step.errors(value[here])
                    stated[i, own] += np.sum(errors**2, axis=0)
                    last = i == len(steps[k]) - 1
                    true[i, own] += np.sum(known**2 + (0.0 if last else (errors - known) ** 2), axis=0)
    return stated, true


def _repeating(cause: Cause, entered: Overlaid, run: int, fed: np.ndarray, here: np.ndarray) -> Overlaid:
    """The cause entering a part, without what would not come again: that is a disturbance."""
    free = cause.free and cause.free.repeating()
    return cause.entering(entered.prediction.target, run, fed, here, free)
