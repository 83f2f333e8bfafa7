"""Which parameters and which effects of the catalogue a plan can tell apart: separable, tied, absorbed, or too small.

An effect is judged at its typical size after the refit of the model's parameters and of the initial states. It is seen
from 3 deviations, tied where another effect imitates it to within 3, and absorbed where no admissible size is seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...effects import BY_NAME, CATALOGUE, Effect
from .flown import Array, Flown
from .information import Information, inverse
from .sensitivity import Quantity

SEEN = 3.0  # deviations from which two accounts of the data are told apart: one chance in a thousand
NONE_LEFT = 1e-3  # share of an effect below which nothing is left of it but rounding
ONE = 0.1  # deviations below which two effects are one and the same to a sonar, whatever the run; a choice
JUDGED = ("separable", "tied", "too small")  # effects that are neither in the model nor absorbed nor outliers
MATTERS = 0.7  # share of its deviations that a rival must leave of an effect for the two to be no pair; a choice
CLEAR = 10.0  # deviations below which telling apart is still a matter of luck: the right one is named 4 times in 5


@dataclass(frozen=True)
class Verdict:
    """What a plan says about one effect.

    Attributes:
        effect: of the catalogue.
        standing: "in the model", "separable", "tied", "too small", "absorbed" or "lone readings".
        size: typical size [unit of its first parameter].
        signature: deviations it brings before any refit.
        left: deviations left of it after the refit of the model.
        needed: size from which it is seen, or NaN.
        rivals: other effects that could be taken for it, and what they leave of it, nearest first.
        moves: how far each parameter of the model is moved where the effect is left out, over its size.
    """

    effect: Effect
    standing: str
    size: float
    signature: float
    left: float
    needed: float
    rivals: tuple[tuple[str, float], ...] = ()
    moves: tuple[tuple[str, float], ...] = ()

    @property
    def kept(self) -> float:
        """Share of the signature that the refit leaves."""
        return self.left / self.signature if self.signature > 0.0 else 0.0

    @property
    def unit(self) -> str:
        """Of the size."""
        unit = self.effect.parameters[0].unit
        return "" if unit == "-" else unit


def slots_of(effect: Effect, known: Sequence[Quantity]) -> list[str]:
    """The effect's rows among the quantities."""
    return [q.name for q in known if q.effect is effect]


def others(free: Sequence[str], own: Sequence[str]) -> list[str]:
    """Parameters of the model but those of the effect itself."""
    return [name for name in free if name not in own]


def separation(info: Information, a: Effect, b: Effect | None, free: Sequence[str]) -> float:
    """Deviations that the model refitted, and b with it if there is one, leave of a at its typical size."""
    own = slots_of(a, info.quantities)
    rival = [name for name in slots_of(b, info.quantities) if name not in free] if b else []
    return info.separation(own, [*others(free, own), *rival])


def verdicts(info: Information, flown: Sequence[Flown], free: Sequence[str]) -> list[Verdict]:
    """For every effect of the catalogue, in its order."""
    rivals = [effect for effect in CATALOGUE if _adds(info, effect, free)]
    return [_lone_readings(e, flown) if e.outliers else _verdict(info, e, free, rivals) for e in CATALOGUE]


def _verdict(info: Information, effect: Effect, free: Sequence[str], seen: Sequence[Effect]) -> Verdict:
    own = slots_of(effect, info.quantities)
    refitted = others(free, own)
    signature, left = info.signature(own), info.separation(own, refitted)
    q = info.quantities[info.index(own)[0]]
    needed = _needed(q, left)
    apart = [(rival.name, separation(info, effect, rival, free)) for rival in seen if rival is not effect]
    rivals = tuple(sorted(apart, key=lambda pair: pair[1]))
    if set(own) & set(free):
        standing = "in the model"
    elif left < SEEN:
        standing = "too small" if np.isfinite(needed) else "absorbed"
    else:
        standing = "tied" if rivals and rivals[0][1] < SEEN else "separable"
    moved = tuple(zip(refitted, _moved(info, own, refitted), strict=True))
    return Verdict(effect, standing, q.size, signature, left, needed, rivals, moved)


def _needed(q: Quantity, left: float) -> float:
    """Size from which an effect is seen, as far as its size is admissible; NaN where none is."""
    assert q.parameter is not None
    if not np.isfinite(q.parameter.null):
        return q.size if left >= SEEN else float("nan")
    size = q.size * SEEN / max(left, 1e-12)
    return size if size <= max(np.abs(q.parameter.bounds)) else float("nan")


def _adds(info: Information, effect: Effect, free: Sequence[str]) -> bool:
    """Whether an effect adds to the model, which neither holds it nor imitates it without a rest."""
    slots = slots_of(effect, info.quantities)
    if not slots or set(slots) & set(free):
        return False
    return info.separation(slots, free) >= NONE_LEFT * info.signature(slots)


def _moved(info: Information, own: Sequence[str], refitted: Sequence[str]) -> Array:
    at, of = info.index(refitted), info.index(own)
    return np.asarray(inverse(info.matrix[np.ix_(at, at)]) @ info.matrix[np.ix_(at, of)].sum(axis=1))


def _lone_readings(effect: Effect, flown: Sequence[Flown]) -> Verdict:
    """An outlier effect: each odd reading, over the noise of its sensor, on as many readings as are to be expected."""
    rate, size = (q.scale for q in effect.parameters)
    at_sonar = effect.place == "range_m"
    total = 0.0
    for f in flown:
        noise = np.sqrt(f.noise.variance[0]) if at_sonar else max(f.scenario.tachometer.noise_rev_s, 0.05)
        readings = f.run.time_s.size if at_sonar else f.run.input.size
        total += rate * readings * (size / noise) ** 2
    left = float(np.sqrt(total))
    return Verdict(effect, "lone readings", rate, left, left, float("nan"))


@dataclass(frozen=True)
class Pair:
    """Effect b, with the model refitted, leaves `separation` deviations of effect a at its typical size."""

    a: Effect
    b: Effect
    separation: float


def pairs(found: Sequence[Verdict]) -> list[Pair]:
    """Pairs of effects of which one imitates the other in part, the closest first, each the closer way round.

    Of effects that are one and the same to these runs, the last in the catalogue stands for all in pairs with others.
    """
    seen = {v.effect.name: v for v in found if v.left >= SEEN and v.standing in JUDGED}
    twins = doubles(found)
    closest: dict[frozenset[str], Pair] = {}
    for name, v in seen.items():
        for rival, left in v.rivals:
            key = frozenset((name, rival))
            alike = bool(key & twins) and left > NONE_LEFT * v.left
            if rival in seen and left < MATTERS * v.left and not alike:
                if key not in closest or left < closest[key].separation:
                    closest[key] = Pair(v.effect, BY_NAME[rival], left)
    return sorted(closest.values(), key=lambda pair: pair.separation)


def doubles(found: Sequence[Verdict]) -> set[str]:
    """Effects that a later one of the catalogue imitates without a rest: to these runs the two are one."""
    order = [v.effect.name for v in found]
    return {v.effect.name for v in found if v.standing in JUDGED for rival, left in v.rivals
            if left < NONE_LEFT * v.left and order.index(rival) > order.index(v.effect.name)}  # fmt: skip


def closest(info: Information, flown: Sequence[Flown], free: Sequence[str]) -> Pair | None:
    """The closest pair of effects that are two at all to these runs."""
    found = pairs(verdicts(info, flown, free))
    return next((pair for pair in found if pair.separation > ONE), None)
