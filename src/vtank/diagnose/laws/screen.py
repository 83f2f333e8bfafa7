"""Score tests of every formula of the grammar, and the most promising of different structure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...plant.formula import FACTORS, NUMBERS, Factor, Formula, Memory
from .grammar import CORES, RANGE_CORES, Modulator, modulators, waves
from .metric import Metric, blocks
from .motion import Motion

COST = 3.0  # [nats] a further number must gain, about half the log of the samples that tell it; a guess
FACTOR_COST = 3.0  # [nats] of a further factor, memory or level: one of about twenty of equal standing; a choice
BROKEN_COST = 2.0  # [nats] of a power that is not whole, which laws seldom have; a choice
BESIDE = {"speed": "u", "turning": "n", "gap": "x", "z": "n"}  # variables that are others in disguise


@dataclass(frozen=True)
class Promise:
    """A candidate, what it promises [nats], and that less what its numbers and factors cost."""

    formula: Formula
    gain: float
    worth: float


@dataclass(frozen=True)
class Carried:
    """The first factors of a formula, and their product along every run, by blocks, shapes (B, 1, L)."""

    factors: tuple[Factor, ...]
    memory: Memory | None
    values: tuple[np.ndarray, ...]


def screened(table: Table, metric: Metric, count: int) -> list[Promise]:
    """The `count` most promising formulas of one modulator, and half as many of one factor more, by structure."""
    cores = CORES if table.acts == "force" else RANGE_CORES
    found = [p for core in cores for p in table.scan(metric, table.carry(core, None))]
    simple, deep = _best(found, count), list[Promise]()
    for promise in simple:
        if len(promise.formula.factors) < FACTORS:
            carried = table.carry(promise.formula.factors, promise.formula.memory)
            deep += [p for p in table.scan(metric, carried) if p.worth > promise.worth]
    return simple + [p for p in _best(deep, count // 2) if structure(p.formula) not in map(structure_of, simple)]


def length(factors: Sequence[Factor], memory: Memory | None) -> float:
    """Description length of a formula's structure [nats]: its factors, its memory, and powers that are not whole."""
    kept = (memory.quantity,) if memory else ()
    levels = 2 if memory and memory.kind == "latches" else 0  # no slope tells them: the evidence does not charge them
    broken = sum(f.operation in ("power", "signed") and f.a % 1.0 != 0.0 for f in (*factors, *kept))
    return FACTOR_COST * (len(factors) + len(kept) + levels) + BROKEN_COST * broken


def structure_of(promise: Promise) -> object:
    """Of what is promised."""
    return structure(promise.formula)


def structure(formula: Formula) -> object:
    """What is left of a formula without its fitted numbers."""
    m = formula.memory
    return formula.acts, tuple(sorted(map(_bare, formula.factors))), m and (m.kind, m.quantity)


def within(less: Formula, more: Formula) -> bool:
    """Whether a formula is another without some of its factors."""
    return set(map(_bare, less.factors)) < set(map(_bare, more.factors))


def _bare(f: Factor) -> tuple[str, str, float]:
    return f.variable, f.operation, 0.0 if NUMBERS[f.operation] else f.a


def _best(found: Sequence[Promise], count: int) -> list[Promise]:
    best: dict[object, Promise] = {}
    for promise in sorted(found, key=lambda p: -p.worth):
        best.setdefault(structure(promise.formula), promise)
    return list(best.values())[:count]


def _doubled(factors: Sequence[Factor], f: Factor) -> bool:
    """Whether a factor meets another of its own kind: two powers of one variable would be one."""
    powers = ("power", "signed")
    return any(
        BESIDE.get(f.variable, f.variable) == BESIDE.get(g.variable, g.variable)
        and (f.operation == g.operation or (f.operation in powers and g.operation in powers))
        for g in factors
    )


class Table:
    """All modulators along all runs, by blocks, and the score tests of their products."""

    def __init__(self, runs: Sequence[Motion], acts: str, fed: str) -> None:
        """Work out every modulator along every run; fed: column of the input."""
        self.runs, self.acts, self.fed = runs, acts, fed
        thrust, self.memories = acts == "force", dict[Memory, list[np.ndarray]]()
        singles: list[Modulator] = list(modulators(runs, thrust))
        pairs = list(waves(runs, thrust))
        self.count, self.all = len(singles), singles + [(f, m) for f, _, m in pairs] + [(f, m) for _, f, m in pairs]
        columns = [[self.along((f,), m, k) for f, m in self.all] for k in range(len(runs))]
        self.values = [blocks(np.column_stack([np.ones_like(own[0]), *own])) for own in columns]
        kinds: dict[object, int] = {}
        self.kind = np.array([kinds.setdefault((_bare(f), m and (m.kind, m.quantity)), len(kinds))
                              for f, m in self.all[: self.count + len(pairs)]])  # fmt: skip
        self.cost = np.array([COST * (len(Formula(acts, (f,), m).fitted())) + length((f,), m) for f, m in
                              self.all[: self.count + len(pairs)]])  # fmt: skip

    def along(self, factors: Sequence[Factor], memory: Memory | None, k: int) -> np.ndarray:
        """Product of factors along run k, shape (I,)."""
        if memory is not None and memory not in self.memories:
            self.memories[memory] = [run.remembered(memory) for run in self.runs]
        run, out = self.runs[k], np.ones_like(self.runs[k].t)
        for f in factors:
            out = out * run.of(f, self.memories[memory][k] if memory else None)
        return out

    def carry(self, factors: tuple[Factor, ...], memory: Memory | None) -> Carried:
        """The first factors of a formula."""
        own = (self.along(factors, memory, k)[:, None] for k in range(len(self.runs)))
        return Carried(factors, memory, tuple(blocks(values).transpose(0, 2, 1) for values in own))

    def scan(self, metric: Metric, c: Carried) -> list[Promise]:
        """The carried factors alone and times every modulator: of each kind the best."""
        shown = [seen.patterns @ (own @ values)[:, 0] for seen, own, values in
                 zip(metric.runs, c.values, self.values, strict=True)]  # fmt: skip
        n, m = self.count + 1, (len(self.all) - self.count) // 2
        alone, size = metric.single([s[:, :n] for s in shown])
        waving, sizes = metric.double([s[:, n : n + m] for s in shown], [s[:, n + m :] for s in shown])
        out = [self.promise(c, None, float(alone[0]), float(size[0]))]
        gain = np.concatenate([alone[1:], waving])
        order = np.argsort(self.cost - gain)
        for i in order[np.unique(self.kind[order], return_index=True)[1]]:
            f, memory = self.all[i]
            if _doubled(c.factors, f) or (memory and c.memory and memory != c.memory):
                continue
            if i < self.count:
                out.append(self.promise(c, (f, memory), float(gain[i]), float(size[i + 1])))
            else:
                s, q = sizes[:, i - self.count]
                wave = replace(f, b=float(np.arctan2(q, s)))
                out.append(self.promise(c, (wave, memory), float(gain[i]), float(np.hypot(s, q))))
        return out

    def promise(self, c: Carried, modulator: Modulator | None, gain: float, size: float) -> Promise:
        """Worth: the gain less what numbers and factors cost."""
        f, memory = modulator or (None, None)
        formula = Formula(self.acts, (*c.factors, *((f,) if f else ())), c.memory or memory, size, self.fed)
        return Promise(formula, gain, gain - COST * len(formula.fitted()) - length(formula.factors, formula.memory))
