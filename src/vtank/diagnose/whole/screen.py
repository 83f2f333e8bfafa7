"""Score tests over all effects at all places: what each would gain beside a fitted model, from one linearisation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...rigid.filtered import Filtered
from ...rigid.fit import weighed
from ...rigid.layout import Layout
from ...rigid.places import Placed
from ...rigid.tangent import Path
from .model import RUNS_AWAY, Model, slopes, sparing

Array = NDArray[np.float64]
TOGETHER = 64  # trials whose answers are held at a time; a choice
STEP = 0.02  # of finite differences, as a share of a prior deviation


@dataclass(frozen=True, eq=False)
class Promise:
    """What an effect promises: gain of log evidence, and where its fit may begin."""

    placed: Placed
    gain: float
    begin: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Base:
    """A fitted model's innovations e, (M,), and the derivative J, (M, U), that others are projected off.

    paths: along which changes are followed. whitened: J such that J'J and the priors together are one: what the model's
    own unknowns take up of a column c is whitened (whitened' c). given: whitened' e.
    """

    paths: list[Path]
    e: Array
    J: Array
    whitened: Array
    given: Array

    def gram(self, columns: Iterable[Array]) -> Array:
        """Inner products of columns, (L, L), less what the model's own unknowns would take up within their priors.

        columns: (M, L), in pieces one after the other, such as those of each run, none of which is kept.
        """
        inner, taken, first = np.zeros(()), np.zeros(()), 0
        for piece in columns:
            last = first + len(piece)
            inner, taken = inner + piece.T @ piece, taken + self.whitened[first:last].T @ piece
            first = last
        return np.asarray(inner - taken.T @ taken)


def based(model: Model, found: Sequence[Filtered]) -> Base:
    """Linearise a fitted model; it stands at its optimum, about which the priors pull its numbers back."""
    paths = model.fit.paths(model.vector(), found)
    e, J = np.concatenate([weighed(path.innovation, path.f) for path in paths]), slopes(model, paths)
    A = J * np.array([u.scale for u in model.unknowns])
    R = np.asarray(np.linalg.qr(np.vstack([A, np.eye(A.shape[1])]), mode="r"))  # R'R = 1 + A'A, whatever its condition
    whitened = np.ascontiguousarray(np.linalg.solve(R.T, A.T).T)
    return Base(paths, e, J, whitened, whitened.T @ e)


def promises(model: Model, base: Base, layout: Layout, candidates: Sequence[Placed]) -> list[Promise]:
    """All candidates that are not in the model, the most promising first."""
    taken = set(model.names)
    p, trials = model.vector(), []
    for placed in candidates:
        if placed.name in taken:
            continue
        free = placed.parameters
        tries = max(len(number.starts) for number in free) or 1
        for t in range(tries):
            begin = tuple(n.starts[min(t, len(n.starts) - 1)] if n.starts else 0.0 for n in free)
            trials.append((placed, begin, *_sides(p, layout, placed, begin)))
    best: dict[str, Promise] = {}
    for first in range(0, len(trials), TOGETHER):
        some = trials[first : first + TOGETHER]
        answers = model.fit.answers(base.paths, [v for *_, sides in some for v in sides])
        with np.errstate(over="ignore", invalid="ignore"):  # what ran away is left out below
            adapted = base.whitened.T @ answers
        place = 0
        for placed, begin, steps, sides in some:
            mine = slice(place, place + len(sides))
            promise = _promise(placed, begin, steps, answers[:, mine], adapted[:, mine], base)
            place += len(sides)
            if promise is not None and (placed.name not in best or promise.gain > best[placed.name].gain):
                best[placed.name] = promise
    return sorted(best.values(), key=lambda promise: -promise.gain)


def _sides(p: Array, layout: Layout, placed: Placed, begin: Sequence[float]) -> tuple[list[float], list[Array]]:
    """Vectors with the effect at its start, and with each of its free numbers moved from there."""
    numbers = placed.parameters
    steps = [STEP * number.scale for number in numbers if number.scale > 0.0]

    def vector(values: Sequence[float]) -> Array:
        q = p.copy()
        for number, value in zip(numbers, values, strict=True):
            at = layout.at(number.slots)
            q[at] = (q[at] if np.isfinite(number.null) else 0.0) + value
        return q

    sides = [vector(begin)]
    for i, number in enumerate(numbers):
        if number.scale > 0.0:
            moved = list(begin)
            moved[i] += STEP * number.scale
            sides.append(vector(moved))
    return steps, sides


def _promise(
    placed: Placed, begin: tuple[float, ...], steps: list[float], answers: Array, adapted: Array, base: Base
) -> Promise | None:
    """Gain of log evidence, linear about the start, own unknowns readapted, each number within its prior.

    answers: changes of the innovations at the start, and at a step of each number from there; adapted: whitened' of
    them.
    """
    free = [(number, b) for number, b in zip(placed.parameters, begin, strict=True) if number.scale > 0.0]
    if not np.all(np.abs(answers) < RUNS_AWAY) or not np.any(answers):
        return None

    def sided(none: Array, sides: Array) -> Array:
        return np.column_stack([none, none + sides[:, 0], (sides[:, 1:] - sides[:, :1]) / np.array(steps)])

    columns, less = sided(base.e, answers), sided(base.given, adapted)
    gram = columns.T @ columns - less.T @ less
    scale = np.array([number.scale for number, _ in free])
    start = np.array([b for _, b in free])
    low, high = np.array([n.low for n, _ in free]), np.array([n.high for n, _ in free])
    before, at_start, pull, H = gram[0, 0], gram[1, 1], gram[2:, 1], gram[2:, 2:]
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
