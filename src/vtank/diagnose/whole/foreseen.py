"""What flights that were not made yet would tell: how far apart they set hypotheses about a whole vehicle.

A flight of the nominal stands for the flight to be. Every hypothesis changes what its instruments would read, to first
order in what follows from a change of law (`rigid.tangent`); the distance of one hypothesis from another is what is
left, in deviations, once the other has adapted own parameters and its own numbers as far as it may.
Separation with refitted parameters: Buzzi-Ferraris, Forzatti, Chem. Eng. Sci. 39 (1984).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.special import xlogy

from ...plant.vehicle import Vehicle
from ...record.run import Run
from ...rigid.filtered import Noise
from ...rigid.fit import Fit
from ...rigid.layout import Layout
from ...rigid.noise import first_noise
from ...rigid.places import Placed, Sizes, catalogue
from ...rigid.recorded import Recorded
from ...rigid.recordings import record
from .model import Model
from .own import Unknown, own_unknowns
from .sizes import sizes_of

Array = NDArray[np.float64]
SMALL = 0.2  # of a deviation of its prior: what is larger is hardly ever in doubt; a choice
STILL = 1e-3  # [m/s2, rad/s2] disturbance where none is known: still water moves a vehicle so far; a guess


@dataclass(frozen=True)
class Free:
    """A number that is free: the slots that it moves alike, a step of it, and how far it may move from where it is."""

    slots: tuple[str, ...]
    step: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A cause that is possible.

    Attributes:
        name: none, parameters, or effects at places. chance: its probability.
        values: slots that differ from the vehicle file's, by name; it says so of any recording of the vehicle.
        numbers: of its effects, that are free.
        known: information about own parameters, then about these numbers; None where own parameters are the file's.
    """

    name: str
    chance: float
    values: Mapping[str, float]
    numbers: tuple[Free, ...]
    known: Array | None


@dataclass(frozen=True, eq=False)
class Foreseen:
    """What flights tell: inner products of all columns over all instruments, (L, L), and which column is whose.

    Attributes:
        own: columns of own parameters; at, sides: of each hypothesis, and of its free numbers.
    """

    gram: Array
    own: slice
    at: tuple[int, ...]
    sides: tuple[slice, ...]

    def __add__(self, other: Foreseen) -> Foreseen:
        """Both flights."""
        return replace(self, gram=self.gram + other.gram)

    def apart(self, hypotheses: Sequence[Hypothesis]) -> Array:
        """Deviations that hypothesis j leaves of what i brings, (L, L)."""
        found = np.zeros((len(self.at), len(self.at)))
        at = np.array(self.at)
        for j, rival in enumerate(hypotheses):
            mine = at[j]
            square = self.gram[at, at] - 2.0 * self.gram[at, mine] + self.gram[mine, mine]
            if rival.known is not None:
                free = np.r_[self.own, self.sides[j]]
                pull = self.gram[np.ix_(at, free)] - self.gram[mine, free]
                low, high = (np.array([getattr(n, side) for n in rival.numbers]) for side in ("low", "high"))
                square = square - _taken(self.gram[np.ix_(free, free)] + rival.known, pull, low, high)
            found[:, j] = np.sqrt(np.maximum(square, 0.0))
        return found

    def bounds(self, known: Array) -> Array:
        """Deviations of own parameters, (U,), by Cramer and Rao, beside what is known of them: information, (U, U)."""
        return np.asarray(np.sqrt(np.diag(np.linalg.inv(self.gram[self.own, self.own] + known))))


def _taken(inner: Array, pull: Array, low: Array, high: Array) -> Array:
    """What is taken up of each row of `pull`, (L,), by least squares with the last numbers within bounds."""
    move = np.asarray(np.linalg.solve(inner, pull.T).T)
    last = slice(move.shape[1] - low.size, None)
    inside = np.clip(move[:, last], low, high)
    held = np.zeros(move.shape, bool)
    held[:, last] = inside != move[:, last]
    move[:, last] = inside
    for pattern in np.unique(held[held.any(axis=1)], axis=0):
        rows, free = (held == pattern).all(axis=1), ~pattern
        rest = pull[np.ix_(rows, free)] - move[np.ix_(rows, pattern)] @ inner[np.ix_(pattern, free)]
        move[np.ix_(rows, free)] = np.linalg.solve(inner[np.ix_(free, free)], rest.T).T
    return np.asarray(2.0 * np.sum(pull * move, axis=1) - np.sum(move @ inner * move, axis=1))


def foreseen(
    vehicle: Vehicle, flights: Sequence[Run], hypotheses: Sequence[Hypothesis], noise: Noise | None = None
) -> list[Foreseen]:
    """What each flight tells of hypotheses; noise: whose disturbance is taken, by default that of still water."""
    layout, seen, _ = record(flights, vehicle)
    own = own_unknowns(layout, seen)
    return [_foreseen(layout, run, own, hypotheses, noise) for run in seen]


def _foreseen(
    layout: Layout, run: Recorded, own: Sequence[Unknown], hypotheses: Sequence[Hypothesis], noise: Noise | None
) -> Foreseen:
    white = first_noise((run,))
    still = replace(white, sigma=np.where(run.moves, STILL, 0.0))
    level = replace(noise, variance=white.variance).even if noise else still
    fit, p = Fit((run,), level), layout.null
    steps, vectors = [unknown.step for unknown in own], [_moved(p, u.slots, u.step) for u in own]
    at, sides = [], []
    for hypothesis in hypotheses:
        q = layout.vector({name: v for name, v in hypothesis.values.items() if name in layout.slots})
        at.append(len(vectors))
        vectors += [q, *(_moved(q, layout.at(number.slots), number.step) for number in hypothesis.numbers)]
        steps += [1.0, *(number.step for number in hypothesis.numbers)]
        sides.append(slice(at[-1] + 1, len(vectors)))
    columns = fit.answers(fit.paths(p, fit.filter(p)), vectors)
    for first, own_columns in zip(at, sides, strict=True):
        columns[:, own_columns] -= columns[:, first : first + 1]
    columns = np.nan_to_num(columns / np.array(steps))
    return Foreseen(columns.T @ columns, slice(0, len(own)), tuple(at), tuple(sides))


def _moved(p: Array, slots: NDArray[np.int64], step: float) -> Array:
    q = p.copy()
    q[slots] = np.where(np.isfinite(q[slots]), q[slots], 0.0) + step
    return q


# --- hypotheses ------------------------------------------------------------------------------------------------------
def possible(
    vehicle: Vehicle, flights: Sequence[Run], effects: Iterable[str] | None = None, share: float = SMALL
) -> list[Hypothesis]:
    """What is possible before anything was recorded: no effect, and each effect at each place.

    share: size of an effect, in deviations of its prior; where its fits begin anywhere but at nothing, it begins there.

    flights: of the nominal, by which sizes are told. effects: names, or names at places, to consider (default: all).
    The first is own parameters alone; chances are those of the diagnosis beforehand.
    """
    layout, seen, _ = record(flights, vehicle)
    own = own_unknowns(layout, seen)
    fit = Fit(seen, first_noise(seen))
    model = Model(fit, (), (), np.array([]), layout.null)
    placed = usual(layout, seen, sizes_of(model, fit.filter(layout.null)), effects)
    prior = np.diag([u.scale**-2.0 for u in own])
    count = Counter(one.effect for one in placed)
    effects_at = [_placed(layout, one, prior, 0.5 / len(count) / count[one.effect], share) for one in placed]
    return [Hypothesis("parameters", 0.5, {}, (), prior), *effects_at]


def own_numbers(vehicle: Vehicle, flights: Sequence[Run]) -> dict[str, tuple[float, float]]:
    """Own parameters that are free, with the file's values and what these are trusted to: deviations of the prior.

    In the order of the information about them.
    """
    layout, seen, _ = record(flights, vehicle)
    return {u.name: (float(np.mean(u.base)), u.scale) for u in own_unknowns(layout, seen)}


def usual(layout: Layout, seen: Sequence[Recorded], sizes: Sizes, effects: Iterable[str] | None = None) -> list[Placed]:
    """The catalogue, one form of each name; or of the effects that are asked for."""
    some = None if effects is None else set(effects)
    found: dict[str, Placed] = {}
    for placed in catalogue(layout, seen[0].moves, sizes):
        if some is None or {placed.effect, placed.name} & some:
            found.setdefault(placed.name, placed)
    return list(found.values())


def _placed(layout: Layout, placed: Placed, prior: Array, chance: float, share: float) -> Hypothesis:
    """An effect where its fit would begin, or at a share of its prior's deviation."""
    values: dict[str, float] = {}
    numbers, known = [], []
    for number in placed.parameters:
        step = share * number.scale * (1.0 if number.high > 0.0 else -1.0)
        size = number.starts[0] if number.starts else step
        for slot in number.slots:
            values[slot] = float(number.moved(values.get(slot, float(layout.null[layout.slot(slot)])), size))
        if number.scale > 0.0:
            unit = values[number.slots[0]] if number.factor else 1.0  # of the slot, for a little of the number
            low, high = (unit * (bound - size) for bound in (number.low, number.high))
            numbers.append(Free(number.slots, 1e-3 * unit * number.scale, low, high))
            known.append((unit * number.scale) ** -2.0)
    return Hypothesis(placed.name, chance, values, tuple(numbers), block_diag(prior, np.diag(known)))


def fitted(model: Model, name: str, chance: float) -> Hypothesis:
    """A model that was fitted to recordings, with what they tell of its numbers."""
    layout, p = model.fit.runs[0].layout, model.vector()
    values = {layout.names[i]: float(p[i]) for i in np.flatnonzero(p != layout.null)}
    free = tuple(
        Free(tuple(layout.names[i] for i in u.slots), u.step, u.low - float(theta), u.high - float(theta))
        for u, theta in zip(model.unknowns, model.theta, strict=True)
        if u.name.rpartition(".")[0]
    )
    return Hypothesis(name, chance, values, free, model.information if model.unknowns else None)


def drop_of_doubt(chances: Sequence[float] | Array, apart: Array) -> float:
    """Entropy [nats] by which flights that set hypotheses so far apart lower the doubt between them, at the least.

    chances: of the hypotheses, (L,), in any measure; apart: deviations, (L, L). A lower bound of the mutual information
    of which is true and what is recorded, by Bhattacharyya distances: Kolchinsky, Tracey, Entropy 19 (2017), 361.
    """
    p = np.array(chances) / np.sum(chances)
    near = np.exp(-(np.minimum(apart, apart.T) ** 2) / 8.0)
    return float(-np.sum(xlogy(p, near @ p)))
