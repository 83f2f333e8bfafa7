"""What an effect is: a named physical law the nominal simulator leaves out, with its parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Channel = Literal["hydrodynamics", "actuator", "sensor"]
Standing = Literal["separable", "absorbed", "tied"]

UNIT_SUFFIX = {
    "-": "",
    "s": "_s",
    "m": "_m",
    "1/s": "_per_s",
    "1/s2": "_per_s2",
    "m/s": "_m_s",
    "m/s2": "_m_s2",
    "rad": "_rad",
    "rad/s": "_rad_s",
    "rev/s": "_rev_s",
    "1/rev": "_per_rev",
}


@dataclass(frozen=True)
class Parameter:
    """One number of an effect's law.

    Attributes:
        name: short name within the effect, as in the JSON report.
        unit: SI unit, one of UNIT_SUFFIX.
        meaning: what it is, in a few words.
        null: the value at which the effect does nothing.
        bounds: physically admissible values (low, high).
        scale: typical size [unit], from which the prior in gap units is made.
        per_run: True when every run has a value of its own (a phase), which is a nuisance and not a finding.
        shape: True when the value has no influence while the effect's size is null (a frequency, a time constant).
    """

    name: str
    unit: str
    meaning: str
    null: float
    bounds: tuple[float, float]
    scale: float
    per_run: bool = False
    shape: bool = False

    @property
    def key(self) -> str:
        """Name with its unit, as written in scenario files: `c` in 1/s is `c_per_s`."""
        return self.name + UNIT_SUFFIX[self.unit]


@dataclass(frozen=True)
class Effect:
    """A physical law that can be switched on in the tank, in the surge model and in the diagnosis.

    Attributes:
        name: fixed name that users script on.
        channel: where it acts.
        sentence: what it is, in one sentence.
        law: the formula as text, in the symbols of the equation of motion.
        parameters: the numbers of the law.
        source: where the law comes from.
        confused_with: effects that look alike to one sonar, by name.
        standing: "separable" in principle, "absorbed" by refitted parameters, or "tied" to another effect.
    """

    name: str
    channel: Channel
    sentence: str
    law: str
    parameters: tuple[Parameter, ...]
    source: str
    confused_with: tuple[str, ...] = ()
    standing: Standing = "separable"

    def slots(self) -> tuple[str, ...]:
        """Names of its entries in the parameter vector, `effect.parameter`."""
        return tuple(f"{self.name}.{parameter.name}" for parameter in self.parameters)
