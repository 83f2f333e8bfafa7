"""What an effect is: a named physical law the nominal simulator leaves out, with its parameters."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from types import FunctionType
from typing import Any, Literal

Channel = Literal["hydrodynamics", "actuator", "sensor"]
Standing = Literal["separable", "absorbed", "tied"]
Need = Literal["sonar", "position", "propeller"]
Dependence = Literal["place", "time"]
Law = Callable[..., float]

SYMBOLS = ("t", "x", "u", "u_r", "z", "n", "n_e", "gap")  # of the equation of motion, that a force may ask for
DEPENDS_ON: dict[Dependence, set[str]] = {"place": {"x", "gap"}, "time": {"t"}}  # what is not the same everywhere

POWER = r"(m|s|kg|N|V|A|K|Pa|rad|rev)\d?"  # a unit of SI, or a turn, and its power
UNIT = re.compile(rf"-|(1|{POWER})/{POWER}|{POWER}")


def unit_suffix(unit: str) -> str:
    """How a key ends that is in this unit: `_m_s2` for m/s2, `_per_s` for 1/s; ValueError for a unit not known."""
    if not UNIT.fullmatch(unit):
        raise ValueError(f"unit '{unit}' is not known; expected '-' or such as 'm', 'm/s2', '1/s', 'rev/s'")
    return {"-": ""}.get(unit, "_" + unit.replace("1/", "per_").replace("/", "_"))


def plain(law: Law) -> FunctionType:
    """A law as it is written, not compiled."""
    written: Any = law
    plain: FunctionType = getattr(written, "py_func", written)
    return plain


def line_of(law: Law | None) -> int:
    """The line of its file at which a law is written; 0 where there is none."""
    return plain(law).__code__.co_firstlineno if law else 0


@dataclass(frozen=True)
class Parameter:
    """One number of an effect's law.

    Attributes:
        name: short name within the effect, as in the JSON report.
        unit: SI unit, see `unit_suffix`; rev/s stands for the unit of the input, whatever that is.
        meaning: what it is, in a few words.
        null: the value at which the effect does nothing; infinite for a limit.
        bounds: physically admissible values (low, high).
        scale: typical size [unit], from which the prior in gap units is made.
        per_run: True when every run has a value of its own (a phase), which is a nuisance and not a finding.
        shape: True when the value has no influence while the effect's size is null (a frequency, a time constant).
        starts: where a fit begins [unit; of a limit: share of the largest input]; by default at the null of a shape, at
            a moderate value of a size.
        counted: True when isolated outliers tell the value, and no fit of the trajectory does.
        seen: True when a fit begins at the size of isolated outliers, which is what is known of it beforehand.
    """

    name: str
    unit: str
    meaning: str
    null: float
    bounds: tuple[float, float]
    scale: float
    per_run: bool = False
    shape: bool = False
    starts: tuple[float, ...] = ()
    counted: bool = False
    seen: bool = False

    def __post_init__(self) -> None:
        unit_suffix(self.unit)

    @property
    def key(self) -> str:
        """Name with its unit, as written in scenario files: `c` in 1/s is `c_per_s`."""
        return self.name + unit_suffix(self.unit)

    @property
    def limit(self) -> bool:
        """Whether it is a limit, which does nothing where it is never reached."""
        return math.isinf(self.null)

    @property
    def angle(self) -> bool:
        """Whether it goes round: what differs by a turn is the same."""
        return self.unit == "rad"


@dataclass(frozen=True)
class Effect:
    """A physical law that can be switched on in the tank, in the surge model and in the diagnosis.

    A file of this folder that holds an EFFECT is in the catalogue. The five last attributes are what it does, and one
    of them is enough; `*parameters` are all of the effect's, in their order here. From the hull to the recording
    effects act in the order of the catalogue, on the way back (`instant`, `true_input`) in reverse.

    Attributes:
        name: fixed name that users script on, that of its file.
        channel: what it belongs to.
        place: where it acts: an axis of the hull ("surge"), the "thruster", or a sensor's column ("range_m").
        sentence: what it is, in one sentence.
        law: the formula as text, in the symbols of the equation of motion.
        parameters: the numbers of the law.
        source: where the law comes from.
        order: place among the effects of its channel, in the parameter vector and in tables; by default the last.
        confused_with: effects that look alike to one sonar, by name.
        standing: "separable" in principle, "absorbed" by refitted parameters, or "tied" to another effect.
        same_as: the effect that is named instead wherever that one can be seen, since the two cannot be told apart.
        needs: what must be recorded for it to be seen: a sonar, a position, a propeller rather than a measured force.
        depends_on: what its law depends on besides speed and input, so that a run is not the same everywhere.
        in_equation: whether what it does cannot be said by these, and has its term in the equation (plant/surge.py).
        force: (*symbols, *parameters) -> force on the hull per unit of moving mass [m/s2]; symbols are any of t, x, u,
            u_r, z, n, n_e, gap as in the equation of motion (plant/surge.py), called so in the law.
        reads: (value, *parameters) -> value: what the sensor reads.
        instant: (stamp, *parameters) -> time at which what the sensor stamps was true [s].
        acts: (time, *parameters) -> stamp of the input that acts at this time [s].
        true_input: (reading, lone, *parameters) -> input behind a reading that stands alone by `lone`.
    """

    name: str
    channel: Channel
    place: str
    sentence: str
    law: str
    parameters: tuple[Parameter, ...]
    source: str
    order: float = math.inf
    confused_with: tuple[str, ...] = ()
    standing: Standing = "separable"
    same_as: str = ""
    needs: tuple[Need, ...] = ()
    depends_on: tuple[Dependence, ...] = ()
    in_equation: bool = False
    force: Law | None = field(default=None, compare=False, repr=False)
    reads: Law | None = field(default=None, compare=False, repr=False)
    instant: Law | None = field(default=None, compare=False, repr=False)
    acts: Law | None = field(default=None, compare=False, repr=False)
    true_input: Law | None = field(default=None, compare=False, repr=False)

    def slots(self) -> tuple[str, ...]:
        """Names of its entries in the parameter vector, `effect.parameter`."""
        return tuple(f"{self.name}.{parameter.name}" for parameter in self.parameters)

    def asked(self) -> tuple[str, ...]:
        """The symbols that its force depends on: the first arguments of the law, before its parameters.

        ValueError for a law that asks for anything else, or depends on place or time where the effect does not say so.
        """
        if self.force is None:
            return ()
        names = list(inspect.signature(plain(self.force)).parameters)
        count = len(names) - len(self.parameters)
        asked = tuple(names[: max(count, 0)])
        if count < 0 or not set(asked) <= set(SYMBOLS):
            raise ValueError(
                f"effect '{self.name}': its force asks for {', '.join(names)}; expected any of {', '.join(SYMBOLS)}, "
                f"then its {len(self.parameters)} parameters"
            )
        for what, those in DEPENDS_ON.items():
            if those & set(asked) and what not in self.depends_on:
                raise ValueError(f"effect '{self.name}': its force depends on {what}; expected depends_on=('{what}',)")
        return asked

    @property
    def does(self) -> bool:
        """Whether anything says what it does."""
        hooks = (self.force, self.reads, self.instant, self.acts, self.true_input)
        return self.in_equation or self.outliers or any(hook is not None for hook in hooks)

    @property
    def outliers(self) -> bool:
        """Whether it makes isolated outliers of some readings and leaves the others alone."""
        return any(q.counted for q in self.parameters)

    @cached_property
    def wave(self) -> tuple[str, str, str] | None:
        """Slots of amplitude, frequency and phase of an effect that is a wave, else None."""
        found = {q.unit: slot for slot, q in zip(self.slots(), self.parameters, strict=True)}
        size = next(slot for slot, q in zip(self.slots(), self.parameters, strict=True) if not q.shape)
        return (size, found["rad/s"], found["rad"]) if {"rad", "rad/s"} <= found.keys() else None
