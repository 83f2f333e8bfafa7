"""Causes of a gap, with a size that can be turned up and down: effects, laws of no catalogue, runs that differ."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ...effects import BY_NAME, PARAMETERS, Parameter
from ...plant import LAG
from .generator import FAMILIES, Scene, draw_law
from .laws import Law
from .outside import OUTSIDE

MOST = 12  # runs that a case has at most, those held back among them
VARIED = {"alpha": "alpha", "beta": "beta", "tau": LAG}  # own parameters that may differ from run to run, and slots
VARIES, WIDEST = 0.05, 0.8  # [-] usual and largest relative spread of one; choices
STRONGEST = 10.0  # largest size over the catalogue's typical one; a choice

# Ranges by unit, drawn log-uniformly: of parameters that have no influence while the size is null, and of outliers,
# whose rate and size are both drawn and not solved for; choices
SHAPES = {"rad/s": (0.15, 1.6), "s": (1.5, 20.0)}
CHANCE = {"-": (0.003, 0.06), "m": (0.06, 1.5), "rev/s": (1.0, 9.0)}
ABOVE_REV_S = 20.0  # [rev/s] where a limit stands at first, which no propeller reaches


@dataclass(frozen=True)
class Cause:
    """One cause of the gap.

    Attributes:
        name: of an effect, of a law or its family, or of the own parameter that differs from run to run.
        size: 0 does nothing.
        largest: largest plausible size.
        unit: slot -> value per unit of size.
        fixed: slot -> value that does not depend on the size.
        per_run: slot -> one value for each run, held-out ones included.
        law: what acts, where no catalogue has it.
        varies: deviation of the logarithm of an own parameter per unit of size, for each run.
    """

    name: str
    size: float
    largest: float
    unit: dict[str, float] = field(default_factory=dict)
    fixed: dict[str, float] = field(default_factory=dict)
    per_run: dict[str, tuple[float, ...]] = field(default_factory=dict)
    law: Law | None = None
    varies: tuple[float, ...] = ()

    @property
    def known(self) -> bool:
        """Whether it is an effect of the catalogue."""
        return self.name in BY_NAME

    @property
    def solved(self) -> bool:
        """Whether its size is solved for a wanted signal-to-noise ratio."""
        return not BY_NAME[self.name].outliers if self.known else self.law is None or self.law.solved

    def slots(self, run: int) -> dict[str, float]:
        """Entries of the parameter vector in one run."""
        if not self.known:
            return {}
        scaled = {name: self.size * value for name, value in self.unit.items()}
        if is_limit(self):  # the null is infinite: the limit falls from the top speed as size grows
            scaled = {name: value / (1.0 + self.size) for name, value in self.unit.items()}
        return scaled | self.fixed | {name: values[run] for name, values in self.per_run.items()}

    def factors(self, run: int) -> dict[str, float]:
        """Slot -> factor on an own parameter in one run."""
        return {VARIED[self.name]: float(np.exp(self.size * self.varies[run]))} if self.varies else {}

    def sized(self, size: float) -> Cause:
        """The same cause at another size, at most the largest."""
        return replace(self, size=min(size, self.largest))


def is_limit(cause: Cause) -> bool:
    """Whether it is a limit of the propeller speed, which does nothing where it is not reached."""
    return cause.known and any(p.limit for p in BY_NAME[cause.name].parameters)


def with_limit(cause: Cause, top_rev_s: float) -> Cause:
    """A limit that falls from top_rev_s as its size grows [rev/s]; any other cause as it is."""
    return replace(cause, unit=dict.fromkeys(cause.unit, top_rev_s)) if is_limit(cause) else cause


def draw_cause(name: str, random: np.random.Generator, scene: Scene | None = None) -> Cause:
    """A cause with drawn direction and shape at size 1; a law needs the scene that it is drawn for."""
    if name in VARIED and scene is not None:
        varies = _pattern(random, len(scene.durations_s), scene.given)
        return Cause(name, 1.0, WIDEST / max(map(abs, varies)), varies=varies)
    if scene is not None and (name in OUTSIDE or name in FAMILIES):
        law = OUTSIDE[name] if name in OUTSIDE else draw_law(name, random, scene)
        return Cause(name, 1.0, law.largest, law=law)
    effect = BY_NAME[name]
    if effect.outliers:
        return Cause(name, 1.0, 1.0, fixed=_drawn(effect.slots(), CHANCE, random))
    if any(p.limit for p in effect.parameters):
        return Cause(name, 0.2, 1.5, unit=dict.fromkeys(effect.slots(), ABOVE_REV_S))
    known = {slot: PARAMETERS[slot] for slot in effect.slots()}
    sizes = {slot: p for slot, p in known.items() if not p.shape}
    weights = np.abs(random.normal(size=len(sizes)))
    weights /= np.linalg.norm(weights)
    pairs = zip(sizes.items(), weights, strict=True)
    unit = {slot: float(w) * _direction(p, random) * p.scale for (slot, p), w in pairs}
    largest = min([STRONGEST, *(_room(p, unit[slot]) for slot, p in sizes.items())])
    fixed = _drawn(sorted(slot for slot, p in known.items() if p.shape and not p.per_run), SHAPES, random)
    own = {slot: (-np.pi, np.pi) if p.angle else p.bounds for slot, p in known.items() if p.per_run}
    per_run = {slot: tuple(random.uniform(*ends, MOST).tolist()) for slot, ends in own.items()}
    return Cause(name, 1.0, largest, unit, fixed, per_run)


def _pattern(random: np.random.Generator, runs: int, given: int) -> tuple[float, ...]:
    """How an own parameter differs from run to run: drawn, fading with their order, or in one run alone."""
    kind = random.integers(3)
    if kind == 0:
        return tuple((VARIES * random.normal(size=runs)).tolist())
    sign = VARIES * float(random.choice([-1.0, 1.0]))
    if kind == 1:
        return tuple(sign * k for k in range(runs))
    other = random.integers(given)
    return tuple(3.0 * sign * (k == other) for k in range(runs))


def _drawn(
    slots: Iterable[str], ranges: Mapping[str, tuple[float, float]], random: np.random.Generator
) -> dict[str, float]:
    """Values within the ranges of their units, drawn in this order; typical ones of units that have no range."""
    spans = {slot: ranges.get(PARAMETERS[slot].unit, (PARAMETERS[slot].scale,) * 2) for slot in slots}
    return {slot: log_uniform(random, *span) for slot, span in spans.items()}


def log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    """A number whose logarithm is uniform between those of low and high."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def _direction(parameter: Parameter, random: np.random.Generator) -> float:
    low, high = parameter.bounds
    return float(random.choice([-1.0, 1.0])) if low < 0.0 < high else 1.0 if high > 0.0 else -1.0


def _room(parameter: Parameter, unit: float) -> float:
    """Size at which a parameter comes to 90 % of its bound."""
    bound = parameter.bounds[1] if unit > 0.0 else parameter.bounds[0]
    return 0.9 * bound / unit if unit != 0.0 else float("inf")
