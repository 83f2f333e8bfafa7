"""A law that is data, as its author writes it: factors, memory, units and the numbers of the parameter vector."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite, nan
from typing import Any

from ..record.table import Table
from ..record.toml import shown
from .law import FACTORS, KINDS, OPERATIONS, SLOTS, VARIABLES

UNITS: dict[str, dict[str, float]] = {
    "u": {"m": 1.0, "s": -1.0}, "x": {"m": 1.0}, "gap": {"m": 1.0}, "t": {"s": 1.0}, "a": {"m": 1.0, "s": -2.0},
    "z": {"m": 1.0, "s": -2.0}, "speed": {"m": 1.0, "s": -1.0},
}  # fmt: skip
INPUTS: dict[str, dict[str, float]] = {"n_rev_s": {"rev": 1.0, "s": -1.0}, "command": {}, "thrust_N": {"N": 1.0}}
KEPT = ("u", "n", "x", "gap", "t", "a", "z", "speed", "turning")  # what a memory may keep
ACTS = {"force": {"m": 1.0, "s": -2.0}, "range": {"m": 1.0}}
SENSED = ("u", "speed", "x", "gap", "t")  # what an error of the range may depend on
SPOKEN = {"speed": "|u|", "turning": "|n|"}
POSITIVE = ("gap", "t", "speed", "turning")
NUMBERS = {"power": 0, "signed": 0, "above": 1, "beyond": 1, "sine": 2, "decay": 1, "from": 1}  # fitted, in this order
WIDE = ("x", "gap", "t")  # variables over which a threshold may be gradual
FIXED = (("above", 0.0), ("from", 1.0))  # a change of sign, and the other side of a latch, are where they are


@dataclass(frozen=True)
class Factor:
    """operation(variable; a, b): see `law.operated`."""

    variable: str
    operation: str
    a: float = 0.0
    b: float = 0.0

    @property
    def count(self) -> int:
        """How many of its numbers a fit may move; how sharp a threshold of speed is, no recording tells."""
        if (self.operation, self.a) in FIXED:
            return 0
        wide = self.operation == "above" and self.variable in WIDE
        return 2 if wide else NUMBERS[self.operation]

    def text(self, variable: str = "") -> str:
        """As in a formula."""
        v, a, b = variable or SPOKEN.get(self.variable, self.variable), self.a, self.b
        size = v if self.variable in POSITIVE or v.startswith("|") else f"|{v}|"
        return {
            "power": size if a == 1.0 else f"{size if a % 2.0 else v}^{a:g}",
            "signed": {0.0: f"sign({v})", 1.0: v, 2.0: f"{v}{size}"}.get(a, f"{size}^{a:g} sign({v})"),
            "above": f"[{v} {'<' if b < 0.0 else '>'} {a:.3g}{f' within {abs(b):.2g}' if self.count > 1 else ''}]",
            "beyond": f"max({f'{a:.3g} - {v}' if b < 0.0 else f'{v} - {a:.3g}'}, 0)",
            "sine": f"sin({a:.4g} {v} {'-' if b < 0.0 else '+'} {abs(b):.3g})",
            "decay": f"exp({'-' if a > 0.0 else ''}{v}/{abs(a):.3g})",
            "from": f"({v} {'-' if a > 0.0 else '+'} {abs(a):.3g})",
        }[self.operation]


@dataclass(frozen=True)
class Memory:
    """What a law remembers of a quantity.

    It follows it in a [s], sums it up, latches on above a and off below b, is what it was a [s] ago, or drags behind it
    with play of a to either side.
    """

    kind: str
    quantity: Factor
    a: float = 0.0
    b: float = 0.0

    def text(self) -> str:
        """As in a formula."""
        q = self.quantity.text()
        return {
            "follows": f"follow({q}; {self.a:.3g} s)",
            "sums": f"sum({q})",
            "latches": f"latch({q}; on above {self.a:.3g}, off below {self.b:.3g})",
            "delays": f"late({q}; {self.a:.3g} s)",
            "plays": f"play({q}; {self.a:.3g})",
        }[self.kind]


@dataclass(frozen=True)
class Formula:
    """A law: it acts on "force" or "range"; its size in SI, its factors, its memory, and the column that n is."""

    acts: str
    factors: tuple[Factor, ...]
    memory: Memory | None = None
    size: float = 1.0
    fed: str = "n_rev_s"

    def text(self) -> str:
        """The law without its unit, such as `du/dt += -0.12 |u|^1.5 sign(u) [gap < 1.2]`."""
        memory = self.memory.text() if self.memory else ""
        quantity = self.memory.quantity.text() if self.memory else ""
        said = {"w": memory, "fresh": f"({quantity} - {memory})"}
        left = {"force": "du/dt", "range": "range"}[self.acts]
        return " ".join([f"{left} += {self.size:.4g}", *(f.text(said.get(f.variable, "")) for f in self.factors)])

    @property
    def unit(self) -> str:
        """Unit of the size, so that the whole is an acceleration or a length."""
        left: defaultdict[str, float] = defaultdict(float, ACTS[self.acts])
        for f in self.factors:
            if f.operation in ("power", "signed", "beyond", "from"):
                power = f.a if f.operation in ("power", "signed") else 1.0
                for unit, exponent in self.dimension(f.variable).items():
                    left[unit] -= power * exponent
        return spelled(left)

    def unit_of(self, name: str) -> str:
        """Unit of one of its numbers, by slot."""
        part = name.partition(".")[2]
        if part == self.acts:
            return self.unit
        if part.startswith("memory"):
            assert self.memory
            timed = self.memory.kind in ("follows", "delays")
            return "s" if timed else spelled(self.dimension(self.memory.quantity.variable))
        f = self.factors[int(part[-1]) - 1]
        if f.operation != "sine":
            return spelled(self.dimension(f.variable))
        per = {unit: -exponent for unit, exponent in self.dimension(f.variable).items()}
        return "rad" if part[0] == "b" else f"rad {spelled(per)}"

    @property
    def place(self) -> str:
        """Where it acts: the hull's axis, the thruster, or a sensor's column."""
        return {"sensor": "range_m", "actuator": "thruster", "hydrodynamics": "surge"}[self.channel]

    def dimension(self, variable: str) -> Mapping[str, float]:
        """Exponents of the units of a variable."""
        if variable not in ("w", "fresh") or self.memory is None:
            return INPUTS[self.fed] if variable in ("n", "turning") else UNITS[variable]
        q, kind = self.memory.quantity, self.memory.kind
        of = defaultdict(float, {unit: q.a * power for unit, power in self.dimension(q.variable).items()})
        if kind == "sums":
            of["s"] += 1.0
        return {} if kind == "latches" else of

    @property
    def channel(self) -> str:
        """Where it belongs: a sensor, the actuator where thrust or propeller is among the factors, else the water."""
        used = {f.variable for f in (*self.factors, *((self.memory.quantity,) if self.memory else ()))}
        return "sensor" if self.acts == "range" else "actuator" if used & {"n", "z", "turning"} else "hydrodynamics"

    def values(self) -> dict[str, float]:
        """Slots of the parameter vector and their values."""
        out = {name: null for name, (_, null) in SLOTS.items()} | {f"law.{self.acts}": self.size}
        for i, f in enumerate(self.factors, start=1):
            numbers = (float(VARIABLES.index(f.variable)), float(OPERATIONS.index(f.operation)), f.a, f.b)
            out |= dict(zip((f"law.{part}{i}" for part in ("variable", "operation", "a", "b")), numbers, strict=True))
        if self.memory:
            q = self.memory.quantity
            numbers = (KINDS.index(self.memory.kind), VARIABLES.index(q.variable), OPERATIONS.index(q.operation), q.a)
            names = (f"law.memory_{part}" for part in ("kind", "variable", "operation", "power", "a", "b"))
            out |= dict(zip(names, (*numbers, self.memory.a, self.memory.b), strict=True))
        return {name: float(value) for name, value in out.items()}

    def fitted(self) -> tuple[str, ...]:
        """Slots of its numbers that a fit may move: the size first."""
        names = [f"law.{self.acts}"]
        for i, f in enumerate(self.factors, start=1):
            names += [f"law.{part}{i}" for part in ("a", "b")[: f.count]]
        kinds = {"sums": (), "latches": ("a", "b")}
        names += [f"law.memory_{part}" for part in (kinds.get(self.memory.kind, ("a",)) if self.memory else ())]
        return tuple(names)

    def moved(self, values: Mapping[str, float]) -> Formula:
        """The same formula with other numbers, by slot."""
        now = self.values() | {name: value for name, value in values.items() if name in SLOTS}
        return formula_of(now, self.fed)  # type: ignore[return-value]


def spelled(dimension: Mapping[str, float]) -> str:
    """A unit from the exponents of its parts: `m s^-2`."""
    return " ".join(u if p == 1.0 else f"{u}^{p:g}" for u, p in sorted(dimension.items()) if p) or "-"


def formula_of(values: Mapping[str, float], fed: str = "n_rev_s") -> Formula | None:
    """The law in values of slots, of a vehicle fed by that column; None where there is none."""
    acts = next((acts for acts in ACTS if values.get(f"law.{acts}", 0.0) != 0.0), None)
    if acts is None:
        return None
    factors = []
    for i in range(1, FACTORS + 1):
        v, o, a, b = (values[f"law.{part}{i}"] for part in ("variable", "operation", "a", "b"))
        if v:
            factors.append(Factor(VARIABLES[int(v)], OPERATIONS[int(o)], a, b))
    kind, v, o, power, a, b = (
        values[f"law.memory_{part}"] for part in ("kind", "variable", "operation", "power", "a", "b")
    )
    memory = Memory(KINDS[int(kind)], Factor(VARIABLES[int(v)], OPERATIONS[int(o)], power), a, b) if kind else None
    return Formula(acts, tuple(factors), memory, values[f"law.{acts}"], fed)


def law_lines(formula: Formula) -> list[str]:
    """The law as a table of TOML, which `read_law` reads back."""

    def words(*parts: object) -> str:
        return '"' + " ".join(p if isinstance(p, str) else f"{p:.12g}" for p in parts) + '"'

    lines = [
        f"[law] # {formula.text()}",
        f'acts = "{formula.acts}"',
        f'input = "{formula.fed}"',
        f"size = {formula.size:.12g} # {formula.unit}",
    ]
    factors = ", ".join(words(f.variable, f.operation, f.a, f.b) for f in formula.factors)
    lines.append(f"factors = [{factors}]")
    if formula.memory:
        m, q = formula.memory, formula.memory.quantity
        lines.append(f"memory = {words(m.kind, q.variable, q.operation, q.a, m.a, m.b)}")
    return lines


def read_law(file: Table) -> dict[str, float]:
    """Slots and values of the law in a file's table [law]; none where it has none. InputError names file and key."""
    found = read_formula(file)
    return found.values() if found else {}


def read_formula(file: Table) -> Formula | None:
    """The law in a file's table [law]; None where it has none. InputError names file and key."""
    if not file.has("law"):
        return None
    table = file.table("law").check_keys(("acts", "input", "size", "factors", "memory"))
    acts, size = table.choice("acts", tuple(ACTS)), table.number("size")
    fed = table.choice("input", tuple(INPUTS)) if table.has("input") else "n_rev_s"
    texts = table.texts("factors")
    if len(texts) > FACTORS:
        raise table.error("factors", f"expected at most {FACTORS}, found {len(texts)}")
    factors = tuple(Factor(*_words(table, "factors", text, (VARIABLES[1:], OPERATIONS), 2)) for text in texts)
    memory = None
    if table.has("memory"):
        choices = (KINDS[1:], KEPT, ("power", "signed"))
        kind, variable, operation, power, a, b = _words(table, "memory", table.text("memory"), choices, 3)
        memory = Memory(kind, Factor(variable, operation, power), a, b)
    if acts == "range" and (memory or any(f.variable not in SENSED for f in factors)):
        raise table.error("factors", f"expected those of {', '.join(SENSED)} for a range, without memory")
    if memory is None and any(f.variable in ("w", "fresh") for f in factors):
        raise table.error("memory", "missing, but a factor asks for what it holds")
    return Formula(acts, factors, memory, size, fed)


def _words(table: Table, key: str, text: str, choices: tuple[tuple[str, ...], ...], count: int) -> tuple[Any, ...]:
    """Words of the given choices, then numbers, out of a text; InputError says which was expected."""
    words = text.split()
    if len(words) != len(choices) + count:
        raise table.error(key, f"expected {len(choices)} words and {count} numbers, found {shown(text)}")
    for word, known in zip(words, choices, strict=False):
        if word not in known:
            raise table.error(key, f"expected one of {', '.join(known)}, found {shown(word)} in {shown(text)}")
    try:
        numbers = [float(word) for word in words[len(choices) :]]
    except ValueError:
        numbers = [nan]
    if not all(map(isfinite, numbers)):
        raise table.error(key, f"expected {count} numbers at its end, found {shown(text)}")
    return (*words[: len(choices)], *numbers)
