"""The gap budget: what the nominal's mean-square error on data left out is made of.

Every part is left out in turn (`shrink.Parts`), models are fitted without it and simulate it open loop. Steps from one
model to the next are shares: own parameters, each named effect, and what a free-form model finds that comes again in
the part it has not seen. What then is left is sensor noise and what does not repeat, the disturbance.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .evidence import Fitted
from .freeform import Freeform
from .holdout import Model, Prediction, Target, model_of, targets_of
from .selection import Selection
from .shrink import Parts, again, parts_of, without
from .verdict import Verdict

DRAWS = 400  # resampled sets of blocks behind an interval
BLOCKS = 4  # blocks of a part, which are drawn together; errors of a simulation stay alike for long


@dataclass(frozen=True)
class Line:
    """One line of the budget.

    Attributes:
        name: "own parameters", an effect, "repeatable, unnamed", "disturbance" or "sensor noise".
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
        unit: of the errors, "m" or "m/s".
        nominal: root mean square error of the nominal on data left out ["unit"].
        worse: parts that the last named model predicts worse than the refit does.
    """

    lines: tuple[Line, ...]
    unit: str
    nominal: float
    worse: tuple[str, ...]

    @property
    def unexplained(self) -> Line:
        """What neither own parameters nor a named effect nor sensor noise accounts for."""
        last = self.lines[-1]
        return replace(last, name="not explained", kind="unexplained")

    def share(self, kind: str) -> float:
        """Share of all lines of a kind."""
        return sum(line.share for line in self.lines if line.kind == kind)


def budget(selection: Selection, verdict: Verdict, seed: int = 0) -> Budget:
    """Share the gap out; verdict: whose effects are named."""
    parts, chain = parts_of(selection.setting), _chain(selection, verdict.fit)
    free = next((f for f in selection.free if f.fit is verdict.fit), None)
    targets = targets_of(parts.setting)
    with ThreadPoolExecutor(2) as pool:
        errors = list(pool.map(lambda k: _errors(selection, chain, free, parts, targets, k), range(len(targets))))
    noise = [(target.variance + target.coloured)[target.scored] for target in targets]
    names = [("own parameters", "parameters"), *((name, "effect") for name in _added(chain))]
    squares = [[np.add.reduceat(e**2, _starts(e.size)) for e in steps] for steps in errors]
    steps = np.array([np.concatenate([part[i] for part in squares]) for i in range(len(squares[0]))])
    known = np.concatenate([np.add.reduceat(v, _starts(v.size)) for v in noise])
    if np.sum(steps[-1]) > np.sum(steps[-2]):
        steps[-1] = steps[-2]  # what does not come again in data it has not seen is not repeatable
    rng = np.random.default_rng(seed)
    drawn = rng.integers(known.size, size=(DRAWS, known.size))
    found, draws = (
        _shares(steps.sum(axis=1), known.sum()),
        _shares(steps[:, drawn].sum(axis=2), known[drawn].sum(axis=1)),
    )
    names += [("repeatable, unnamed", "repeatable"), ("disturbance", "disturbance"), ("sensor noise", "noise")]
    low, high = np.quantile(draws, (0.05, 0.95), axis=1)
    lines = tuple(
        Line(*name, float(share), (float(a), float(b)))
        for name, share, a, b in zip(names, found, low, high, strict=True)
    )
    worse = [part.name for part, steps in zip(parts.setting.runs, errors, strict=True)
             if np.mean(steps[-2] ** 2) > np.mean(steps[1] ** 2)]  # fmt: skip
    unit = "m" if any(run.has_position for run in parts.setting.runs) else "m/s"
    nominal = float(np.sqrt(steps[0].sum() / sum(e[0].size for e in errors)))
    return Budget(lines, unit, nominal, tuple(worse))


def _chain(selection: Selection, fit: Fitted) -> list[Fitted]:
    """Nominal, refit, and the fit's effects one after the other, as far as they were fitted alone."""
    known = {frozenset(e.name for e in f.hypothesis.effects): f for f in selection.named}
    effects, chain = [e.name for e in fit.hypothesis.effects], [selection.nominal, selection.refit]
    sets = [frozenset(effects[: i + 1]) for i in range(len(effects))]
    return [*chain, *(known[names] for names in sets[:-1] if names in known), *([fit] if effects else [])]


def _added(chain: Sequence[Fitted]) -> list[str]:
    """Effects that each step of the chain adds, in words."""
    sets = [[e.name for e in f.hypothesis.effects] for f in chain[1:]]
    return [" and ".join(n for n in b if n not in a) for a, b in zip(sets, sets[1:], strict=False)]


def _errors(
    selection: Selection,
    chain: Sequence[Fitted],
    free: Freeform | None,
    parts: Parts,
    targets: Sequence[Target],
    k: int,
) -> list[np.ndarray]:
    """Errors on part k of all models of the chain, fitted without it, and with what repeats beside the last."""
    setting, target = without(parts.setting, k), targets[k]
    models = [model_of(again(setting, fit, parts, k)) for fit in chain]
    errors = [Prediction(model, target).errors() for model in models]
    found = free.without(~parts.rows[k]) if free else None
    return [*errors, _beside(found, parts, target, k) if found and found.components else errors[-1]]


def _beside(free: Freeform, parts: Parts, target: Target, k: int) -> np.ndarray:
    """Errors on part k of a model with what it lacks beside it."""
    fit, run = free.fit, parts.parent[k]
    problem, whole = fit.problem, fit.problem.runs[run]
    model = Model(problem.model(fit.optimum.theta + free.shift, run)[0], problem.per_run)
    fed = np.isin(whole.input_time_s, target.run.input_time_s)
    first = sum(r.time_s.size for r in problem.runs[:run])
    here = parts.rows[k][first : first + whole.time_s.size]
    force, error = free.forces()[run][fed], free.errors()[run][here]
    return Prediction(model, target).errors(target.run.value - error, forcing=force)


def _starts(size: int) -> np.ndarray:
    """First measurement of each block."""
    return np.unique(np.linspace(0, size, BLOCKS + 1).astype(int)[:-1])


def _shares(steps: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Shares from the sums of squares after each step, shape (S, ...), and of sensor noise."""
    left = steps[-1]
    noise = np.minimum(noise, left)
    return np.asarray(np.concatenate([-np.diff(steps, axis=0), [left - noise, noise]]) / steps[0])
