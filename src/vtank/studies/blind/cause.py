"""Causes of a gap: effects of the catalogue, or laws outside it, with a size that can be turned up and down."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ...effects import BY_NAME, Parameter
from .outside import OUTSIDE

RUNS, HOLDOUTS = 4, 5  # runs that are given; held back for the score: each once more, and one of another kind
CHANCE = ("sonar_multipath", "tachometer_spikes")  # single readings: rate and size are both drawn, not solved for
STRONGEST = 10.0  # largest size over the catalogue's typical one; a choice

# Ranges of the parameters that have no influence while the size is null, drawn log-uniformly; choices
SHAPES = {"seiche.frequency": (0.15, 1.6), "wake_memory.T": (1.5, 20.0)}
RATE, EXTRA_M, SPIKE_REV_S = (0.003, 0.06), (0.06, 1.5), (1.0, 9.0)


@dataclass(frozen=True)
class Cause:
    """One cause of the gap.

    Attributes:
        name: of an effect or of an outside law.
        size: 0 does nothing.
        largest: largest plausible size.
        unit: slot -> value per unit of size.
        fixed: slot -> value that does not depend on the size.
        per_run: slot -> one value for each run, held-out ones included.
    """

    name: str
    size: float
    largest: float
    unit: dict[str, float] = field(default_factory=dict)
    fixed: dict[str, float] = field(default_factory=dict)
    per_run: dict[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def outside(self) -> bool:
        """Whether no catalogue has it."""
        return self.name in OUTSIDE

    @property
    def solved(self) -> bool:
        """Whether its size is solved for a wanted signal-to-noise ratio."""
        return self.name not in CHANCE

    def slots(self, run: int) -> dict[str, float]:
        """Entries of the parameter vector in one run."""
        if self.outside:
            return {}
        scaled = {name: self.size * value for name, value in self.unit.items()}
        if self.name == "thrust_saturation":  # the null is infinite: the limit falls from the top speed as size grows
            scaled = {name: value / (1.0 + self.size) for name, value in self.unit.items()}
        return scaled | self.fixed | {name: values[run] for name, values in self.per_run.items()}

    def sized(self, size: float) -> Cause:
        """The same cause at another size, at most the largest."""
        return replace(self, size=min(size, self.largest))


def with_limit(cause: Cause, top_rev_s: float) -> Cause:
    """A thrust limit that falls from top_rev_s as its size grows [rev/s]; any other cause as it is."""
    if cause.name != "thrust_saturation":
        return cause
    return replace(cause, unit={"thrust_saturation.n_max": top_rev_s})


def draw_cause(name: str, random: np.random.Generator) -> Cause:
    """A cause with drawn direction and shape at size 1."""
    if name in OUTSIDE:
        return Cause(name, 1.0, OUTSIDE[name].largest)
    if name == "sonar_multipath":
        drawn = {"p": log_uniform(random, *RATE), "extra": log_uniform(random, *EXTRA_M)}
        return Cause(name, 1.0, 1.0, fixed={f"{name}.{key}": value for key, value in drawn.items()})
    if name == "tachometer_spikes":
        drawn = {"p": log_uniform(random, *RATE), "size": log_uniform(random, *SPIKE_REV_S)}
        return Cause(name, 1.0, 1.0, fixed={f"{name}.{key}": value for key, value in drawn.items()})
    if name == "thrust_saturation":
        return Cause(name, 0.2, 1.5, unit={f"{name}.n_max": 20.0})
    effect = BY_NAME[name]
    sizes = [p for p in effect.parameters if not p.shape]
    weights = np.abs(random.normal(size=len(sizes)))
    weights /= np.linalg.norm(weights)
    unit = {f"{name}.{p.name}": float(w) * _direction(p, random) * p.scale for p, w in zip(sizes, weights, strict=True)}
    largest = min([STRONGEST, *(_room(p, unit[f"{name}.{p.name}"]) for p in sizes)])
    shapes = {f"{name}.{p.name}" for p in effect.parameters if p.shape and not p.per_run}
    fixed = {slot: log_uniform(random, *SHAPES[slot]) for slot in sorted(shapes)}
    own = [f"{name}.{p.name}" for p in effect.parameters if p.per_run]
    per_run = {slot: tuple(random.uniform(-np.pi, np.pi, RUNS + HOLDOUTS).tolist()) for slot in own}
    return Cause(name, 1.0, largest, unit, fixed, per_run)


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
