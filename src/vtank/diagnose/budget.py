"""The gap budget: what the nominal's mean-square error on data left out is made of.

Every part is left out in turn (`shrink.Parts`), models are fitted without it and simulate it open loop. Steps from one
model to the next are shares: own parameters, each named effect, and what a free-form model finds that comes again in
the part it has not seen. What then is left is sensor noise and what does not repeat, the disturbance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .evidence import Fitted
from .freeform import Freeform
from .holdout import Model, Overlaid, Prediction, targets_of
from .new_data import NewData
from .prior import calibration
from .renewed import renewed
from .selection import Selection
from .shrink import LeftOut, Parts, left_out
from .verdict import Verdict

REST = (
    ("repeatable, unnamed", "repeatable"),
    ("disturbance", "disturbance"),
    ("sensor noise", "noise"),
    ("not explained", "unexplained"),
    ("the verdict", "verdict"),
)
BY_RUN = ("own parameters of each run", "parameters")  # what their differences from run to run account for


@dataclass(frozen=True)
class Line:
    """One line of the budget.

    Attributes:
        name: "own parameters", an effect, "own parameters of each run" where they vary, "repeatable, unnamed",
            "disturbance" or "sensor noise".
        kind: parameters, effect, repeatable, disturbance or noise.
        share: of the nominal's mean-square error on data left out [-]; below zero where a step made it worse.
        interval90: where the share lies that such recordings would have in the long run, see `renewed.py`, and on open
            trials lay in 90 of 100 cases: widened by what that took, since causes may be others than were drawn.
    """

    name: str
    kind: str
    share: float
    interval90: tuple[float, float]

    def document(self) -> dict[str, Any]:
        """As plain data."""
        return {"name": self.name, "kind": self.kind, "share": self.share, "interval90": list(self.interval90)}


@dataclass(frozen=True)
class Budget:
    """Lines in the order in which they were taken off; shares add to one.

    Attributes:
        lines: the shares.
        unexplained: what neither own parameters nor a named effect nor sensor noise accounts for.
        verdict: what all that the verdict names accounts for together.
        unit: of the errors, "m" or "m/s".
        nominal: root mean square error of the nominal on data left out ["unit"].
        worse: parts that the last named model predicts worse than the refit does.
        gains: what all that the verdict names takes off the sum of squares of each part left out ["unit" squared].
    """

    lines: tuple[Line, ...]
    unexplained: Line
    verdict: Line
    unit: str
    nominal: float
    worse: tuple[str, ...]
    gains: tuple[float, ...]

    def share(self, kind: str) -> float:
        """Share of all lines of a kind."""
        return sum(line.share for line in self.lines if line.kind == kind)


def budget(selection: Selection, verdict: Verdict, seed: int = 0, found: LeftOut | None = None) -> Budget:
    """Share the gap out; verdict: whose effects are named; found: parts left out, where they are known already.

    An effect that is in the verdict's fit but not named there is part of what repeats without a name.
    """
    found = found or left_out(selection, verdict)
    parts, varying = found.parts, verdict.kind == "varying"
    chain = found.chain if verdict.effects or varying else found.chain[:2]
    free = next((f for f in selection.free if f.fit is (chain[-1] if varying else verdict.fit)), None)
    steps = [[*map(Overlaid, fold.chain[: len(chain)])] for fold in found.folds]
    beside = [_beside(free, parts, k, fold.chain[-1]) for k, fold in enumerate(found.folds)]
    squares = np.array([_squares(some) for some in (*zip(*steps, strict=True), beside)])
    targets = targets_of(parts.setting)
    noise = float(sum(np.sum((target.variance + target.coloured)[target.scored]) for target in targets))
    again = bool(squares[-1] < squares[-2])  # what does not come again in data it has not seen is not repeatable
    if again:
        steps = [[*some, last] for some, last in zip(steps, beside, strict=True)]
    renewals = renewed(NewData(selection, verdict), parts, steps, seed)
    shares, stated, true = (_shares(sums, noise, again) for sums in (squares[: len(chain) + again], *renewals))
    added = [BY_RUN] if varying else [(name, "effect") for name in _added(chain)]
    names = [("own parameters", "parameters"), *added, *REST]
    margin = _margins([kind for _, kind in names], shares, float(squares[len(chain) - 1] / squares[0]))
    ends = shares - np.quantile(stated - true, (0.95, 0.05), axis=1)
    low, high = np.minimum(ends[0], shares) - margin, np.maximum(ends[1], shares) + margin
    lines = [
        Line(*name, float(share), (float(a), float(b)))
        for name, share, a, b in zip(names, shares, low, high, strict=True)
    ]
    unit = "m" if any(run.has_position for run in parts.setting.runs) else "m/s"
    nominal = float(np.sqrt(squares[0] / sum(np.sum(target.scored) for target in targets)))
    pairs = zip(parts.setting.runs, *([some[i] for some in steps] for i in (1, len(chain) - 1)), strict=True)
    worse = tuple(part.name for part, refit, last in pairs if _squares([last]) > _squares([refit]))
    first = 0 if len(chain) < 3 else 1  # as the last of the shares
    gains = tuple(_squares([some[first]]) - _squares([some[len(chain) - 1]]) for some in steps)
    *shared, unexplained, named = lines
    return Budget(tuple(shared), unexplained, named, unit, nominal, worse, gains)


def _margins(kinds: Sequence[str], shares: np.ndarray, left: float) -> np.ndarray:
    """What widens each interval, shape (L,): a frozen part of what no name accounts for, left, and of the effects'.

    Steps before what is left are told from one another only, and their margins go with both.
    """
    named = float(np.sum(np.abs(shares[1 : kinds.index("repeatable")])))
    share = calibration().budget
    return np.array([share.get(kind, 0.0) * (left + named * (kind in ("parameters", "effect"))) for kind in kinds])


def _added(chain: Sequence[Fitted]) -> list[str]:
    """Effects that each step of the chain adds, joined by `+`."""
    sets = [[e.name for e in f.hypothesis.effects] for f in chain[1:]]
    return ["+".join(n for n in b if n not in a) for a, b in zip(sets, sets[1:], strict=False)]


def _beside(free: Freeform | None, parts: Parts, k: int, alone: Prediction) -> Overlaid:
    """A model entering part k with what it lacks and what comes again beside it; alone: the model itself."""
    free = free.without(~parts.rows[k]) if free else None
    if not free or not free.components:
        return Overlaid(alone)
    run, (fed, here), problem = parts.parent[k], parts.inside(k), free.fit.problem
    model = Model(problem.model(free.fit.optimum.theta + free.shift, run)[0], problem.per_run)
    return Overlaid(Prediction(model, alone.target), free.forces()[run][fed], free.errors()[run][here])


def _squares(steps: Sequence[Overlaid]) -> float:
    """Sum of squares of the errors of some predictions [m2 or m2/s2]."""
    return float(sum(np.sum(step.errors() ** 2) for step in steps))


def _shares(steps: np.ndarray, noise: float, again: bool) -> np.ndarray:
    """Shares from the sums of squares after each step, shape (S, ...), and of sensor noise; shape (L, ...).

    again: whether the last step is what has no name and comes again; else that has no share. Last, what is unexplained,
    and what the verdict accounts for: all after the refit, or the refit where that is all.
    """
    steps = steps if again else np.concatenate([steps, steps[-1:]])
    left, named, sensor = steps[-1], steps[-2], np.minimum(noise, steps[-1])
    before = steps[min(1, len(steps) - 3)]
    found = [*-np.diff(steps, axis=0), left - sensor, sensor, named - sensor, before - named]
    return np.array(found) / steps[0]
