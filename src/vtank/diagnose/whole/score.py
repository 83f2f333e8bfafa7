"""Score tests over all effects at all places: what each would gain beside a fitted model, from one linearisation."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...rigid.filtered import Filtered, give_back
from ...rigid.fit import weighed
from ...rigid.layout import Layout
from ...rigid.places import Placed
from ...rigid.tangent import AT_ONCE, Path
from .model import RUNS_AWAY, Model, slopes, sparing
from .unfinished import digest, step

Array = NDArray[np.float64]
PIECE = 4096  # measurements whose columns are put side by side at a time; a choice
STEP = 0.02  # of finite differences, as a share of a prior deviation
Trial = tuple[Placed, tuple[float, ...], list[float], list[Array]]  # an effect, where it starts, and its `_sides`


@dataclass(frozen=True, eq=False)
class Promise:
    """What an effect promises: gain of log evidence, and where its fit may begin."""

    placed: Placed
    gain: float
    begin: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Base:
    """A fitted model's innovations e, (M,), and the derivative J, (M, U), that others are projected off.

    paths: along which changes are followed. whitening: (U, U), of J: what the model's own unknowns take up of the
    square of a column c is that of whitening J'c. strain: (U,), where they stand, in prior deviations; what spares
    them to be there gains by it. scale: those deviations, (U,).
    """

    paths: list[Path]
    e: Array
    J: Array
    whitening: Array
    strain: Array
    scale: Array

    def gram(self, columns: Iterable[Array]) -> Array:
        """Inner products of columns, (L, L), less what the model's own unknowns would take up within their priors.

        columns: (M, L), the innovations first, in pieces one after the other, such as those of each run, none of which
        is kept; what is zero throughout a piece, as what acts in one run is in all others, costs nothing.
        """
        inner, taken, first = np.zeros((0, 0)), np.zeros((0, 0)), 0
        for piece in columns:
            if not inner.size:
                inner, taken = np.zeros((piece.shape[1],) * 2), np.zeros((len(self.whitening), piece.shape[1]))
            last, some = first + len(piece), np.flatnonzero(piece.any(axis=0))
            part = piece if some.size == piece.shape[1] else piece[:, some]
            inner[np.ix_(some, some)] += part.T @ part
            taken[:, some] += self.J[first:last].T @ part
            first = last
        inner[0, 0] += self.strain @ self.strain
        taken[:, 0] += self.strain / self.scale
        taken = self.whitening @ taken
        return np.asarray(inner - taken.T @ taken)


def based(model: Model, found: Sequence[Filtered]) -> Base:
    """Linearise a fitted model."""
    give_back()
    paths = model.fit.paths(model.vector(), found)
    e, J = np.concatenate([weighed(path.innovation, path.f) for path in paths]), slopes(model, paths)
    scale = np.array([u.scale for u in model.unknowns])
    return Base(paths, e, J, whitening(J, scale), model.theta / scale, scale)


def whitening(J: Array, scale: Array) -> Array:
    """W, (U, U), with W'W the inverse of J'J + 1 / scale^2, for prior deviations (U,), whatever the condition of J."""
    R = np.eye(scale.size)
    for first in range(0, len(J), PIECE):  # R'R = 1 + A'A, of which A = J scale is never whole
        R = np.asarray(np.linalg.qr(np.vstack([R, J[first : first + PIECE] * scale]), mode="r"))
    return np.asarray(np.linalg.solve(R.T, np.diag(scale)), dtype=np.float64)


def promises(model: Model, base: Base, layout: Layout, candidates: Sequence[Placed]) -> list[Promise]:
    """All candidates that are not in the model, the most promising first."""
    named = {placed.name: placed for placed in candidates if placed.name not in model.names}

    def told() -> str:
        numbers = [(n.starts, n.scale, n.low, n.high) for placed in named.values() for n in placed.parameters]
        return digest(["promises", model.vector(), base.e, base.whitening, tuple(named), numbers])

    def plain(promising: list[Promise]) -> list[Any]:
        return [[promise.placed.name, promise.gain, promise.begin] for promise in promising]

    def again(filed: list[Any]) -> list[Promise]:
        return [Promise(named[name], gain, tuple(begin)) for name, gain, begin in filed]

    return step(told, lambda: _promises(model, base, layout, list(named.values())), plain, again)


def _promises(model: Model, base: Base, layout: Layout, candidates: Sequence[Placed]) -> list[Promise]:
    p, trials = model.vector(), list[Trial]()
    for placed in candidates:
        free = placed.parameters
        tries = max(len(number.starts) for number in free) or 1
        for t in range(tries):
            begin = tuple(n.starts[min(t, len(n.starts) - 1)] if n.starts else 0.0 for n in free)
            trials.append((placed, begin, *_sides(p, layout, placed, begin)))
    best: dict[str, Promise] = {}
    while trials:
        ends = np.cumsum([len(sides) for *_, sides in trials])
        count = max(int(np.searchsorted(ends, AT_ONCE, side="right")), 1)
        some, trials = trials[:count], trials[count:]
        with np.errstate(over="ignore", invalid="ignore"):  # what ran away is left out below
            gram = base.gram(_columns(model, base, some))
        for (placed, begin, steps, _), end in zip(some, ends, strict=False):
            mine = [0, *range(int(end) - len(steps), int(end) + 1)]
            promise = _promise(placed, begin, gram[np.ix_(mine, mine)])
            if promise is not None and (placed.name not in best or promise.gain > best[placed.name].gain):
                best[placed.name] = promise
    return sorted(best.values(), key=lambda promise: -promise.gain)


def _columns(model: Model, base: Base, trials: Sequence[Trial]) -> Iterator[Array]:
    """Innovations, and of each trial their change at the start and derivatives there, run by run, (M, 1 + L)."""
    first, vectors = 0, [v for *_, sides in trials for v in sides]
    for path in base.paths:
        changed = replace(model.fit, runs=(path.run,)).answers([path], vectors)
        last, at = first + len(changed), 0
        for _, _, steps, _ in trials:
            sides = changed[:, at + 1 : at + 1 + len(steps)]
            sides -= changed[:, at, None]
            sides /= steps
            at += 1 + len(steps)
        yield np.column_stack([base.e[first:last], changed])
        first = last


def _sides(p: Array, layout: Layout, placed: Placed, begin: Sequence[float]) -> tuple[list[float], list[Array]]:
    """Vectors with the effect at its start, and with each of its free numbers moved from there."""
    numbers = placed.parameters
    steps = [STEP * number.scale for number in numbers if number.scale > 0.0]

    def vector(values: Sequence[float]) -> Array:
        q = p.copy()
        for number, value in zip(numbers, values, strict=True):
            at = layout.at(number.slots)
            q[at] = number.moved(q[at], value)
        return q

    sides = [vector(begin)]
    for i, number in enumerate(numbers):
        if number.scale > 0.0:
            moved = list(begin)
            moved[i] += STEP * number.scale
            sides.append(vector(moved))
    return steps, sides


def _promise(placed: Placed, begin: tuple[float, ...], gram: Array) -> Promise | None:
    """Gain of log evidence, linear about the start, own unknowns readapted, each number within its prior.

    gram: of innovations, their change at the start, and their derivative there with respect to each free number.
    """
    free = [(number, b) for number, b in zip(placed.parameters, begin, strict=True) if number.scale > 0.0]
    squares = np.diag(gram)[1:]
    if not np.all(np.abs(squares) < RUNS_AWAY**2) or not np.any(squares):
        return None
    scale = np.array([number.scale for number, _ in free])
    start = np.array([b for _, b in free])
    low, high = np.array([n.low for n, _ in free]), np.array([n.high for n, _ in free])
    before, at_start = gram[0, 0], gram[0, 0] + 2.0 * gram[0, 1] + gram[1, 1]
    pull, H = gram[2:, 0] + gram[2:, 1], gram[2:, 2:]
    information = H + np.diag(scale**-2.0)
    move = -np.linalg.solve(information, pull + start * scale**-2.0) if free else start
    end = np.clip(start + move, low, high)
    move = end - start
    after = float(at_start + 2.0 * move @ pull + move @ H @ move + np.sum((end / scale) ** 2))
    occam = 0.5 * float(np.linalg.slogdet(np.eye(scale.size) + H * np.outer(scale, scale))[1]) if free else 0.0
    some = [i for i, (number, _) in enumerate(free) if number.optional]
    if len(free) > 1 and some:
        covariance = np.asarray(np.linalg.inv(information)[np.ix_(some, some)], dtype=np.float64)
        occam -= sparing(end[some], covariance, scale[some], len(some) == len(free))
    values, i = [], 0
    for number, b in zip(placed.parameters, begin, strict=True):
        values.append(float(end[i]) if number.scale > 0.0 else b)
        i += number.scale > 0.0
    return Promise(placed, 0.5 * (before - after) - occam, tuple(values))
