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
from .holdout import Model, Prediction, Target, targets_of
from .selection import Selection
from .shrink import LeftOut, Parts, left_out
from .verdict import Verdict

DRAWS = 400  # resampled sets of blocks behind an interval
REST = (
    ("repeatable, unnamed", "repeatable"),
    ("disturbance", "disturbance"),
    ("sensor noise", "noise"),
    ("not explained", "unexplained"),
    ("the verdict", "verdict"),
)
BY_RUN = ("own parameters of each run", "parameters")  # what their differences from run to run account for
BLOCKS = 4  # blocks of a part, which are drawn together; errors of a simulation stay alike for long


@dataclass(frozen=True)
class Line:
    """One line of the budget.

    Attributes:
        name: "own parameters", an effect, "own parameters of each run" where they vary, "repeatable, unnamed",
            "disturbance" or "sensor noise".
        kind: parameters, effect, repeatable, disturbance or noise.
        share: of the nominal's mean-square error on data left out [-]; below zero where a step made it worse.
        interval90: over what else the blocks left out might have been.
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
    """

    lines: tuple[Line, ...]
    unexplained: Line
    verdict: Line
    unit: str
    nominal: float
    worse: tuple[str, ...]

    def share(self, kind: str) -> float:
        """Share of all lines of a kind."""
        return sum(line.share for line in self.lines if line.kind == kind)


def budget(selection: Selection, verdict: Verdict, seed: int = 0, found: LeftOut | None = None) -> Budget:
    """Share the gap out; verdict: whose effects are named; found: parts left out, where they are known already.

    An effect that is in the verdict's fit but not named there is part of what repeats without a name.
    """
    found = found or left_out(selection, verdict)
    parts, targets = found.parts, targets_of(found.parts.setting)
    varying = verdict.kind == "varying"
    chain = found.chain if verdict.effects or varying else found.chain[:2]
    free = next((f for f in selection.free if f.fit is (chain[-1] if varying else verdict.fit)), None)
    beside = [_beside(free, parts, targets[k], k, fold.chain[-1]) for k, fold in enumerate(found.folds)]
    errors = [(*fold.chain[: len(chain)], last) for fold, last in zip(found.folds, beside, strict=True)]
    steps = np.hstack([[_blocks(e**2) for e in steps] for steps in errors])
    noise = np.hstack([_blocks((target.variance + target.coloured)[target.scored]) for target in targets])
    if np.sum(steps[-1]) > np.sum(steps[-2]):
        steps[-1] = steps[-2]  # what does not come again in data it has not seen is not repeatable
    drawn = np.random.default_rng(seed).integers(noise.size, size=(DRAWS, noise.size))
    shares = _shares(steps.sum(axis=1), noise.sum())
    low, high = np.quantile(_shares(steps[:, drawn].sum(axis=2), noise[drawn].sum(axis=1)), (0.05, 0.95), axis=1)
    added = [BY_RUN] if varying else [(name, "effect") for name in _added(chain)]
    names = [("own parameters", "parameters"), *added, *REST]
    lines = [
        Line(*name, float(share), (float(a), float(b)))
        for name, share, a, b in zip(names, shares, low, high, strict=True)
    ]
    unit = "m" if any(run.has_position for run in parts.setting.runs) else "m/s"
    nominal = float(np.sqrt(steps[0].sum() / sum(e[0].size for e in errors)))
    pairs = zip(parts.setting.runs, found.folds, strict=True)
    worse = tuple(part.name for part, f in pairs if np.mean(f.chain[-1] ** 2) > np.mean(f.chain[1] ** 2))
    *shared, unexplained, named = lines
    return Budget(tuple(shared), unexplained, named, unit, nominal, worse)


def _added(chain: Sequence[Fitted]) -> list[str]:
    """Effects that each step of the chain adds, joined by `+`."""
    sets = [[e.name for e in f.hypothesis.effects] for f in chain[1:]]
    return ["+".join(n for n in b if n not in a) for a, b in zip(sets, sets[1:], strict=False)]


def _beside(free: Freeform | None, parts: Parts, target: Target, k: int, alone: np.ndarray) -> np.ndarray:
    """Errors on part k of a model with what it lacks and what comes again beside it; alone: its own errors."""
    free = free.without(~parts.rows[k]) if free else None
    if not free or not free.components:
        return alone
    fit, run = free.fit, parts.parent[k]
    problem, whole = fit.problem, fit.problem.runs[run]
    model = Model(problem.model(fit.optimum.theta + free.shift, run)[0], problem.per_run)
    fed = np.isin(whole.input_time_s, target.run.input_time_s)
    first = sum(r.time_s.size for r in problem.runs[:run])
    here = parts.rows[k][first : first + whole.time_s.size]
    force, error = free.forces()[run][fed], free.errors()[run][here]
    return Prediction(model, target).errors(target.run.value - error, forcing=force)


def _blocks(squares: np.ndarray) -> np.ndarray:
    """Sums over the blocks of a part, shape (B,)."""
    return np.asarray(np.add.reduceat(squares, np.unique(np.linspace(0, squares.size, BLOCKS + 1).astype(int)[:-1])))


def _shares(steps: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Shares from the sums of squares after each step, shape (S, ...), and of sensor noise, shape (S + 3, ...).

    Last, what is unexplained, and what the verdict accounts for: all after the refit, or the refit where that is all.
    """
    left, named, noise = steps[-1], steps[-2], np.minimum(noise, steps[-1])
    before = steps[min(1, len(steps) - 3)]
    found = [*-np.diff(steps, axis=0), left - noise, noise, named - noise, before - named]
    return np.array(found) / steps[0]
