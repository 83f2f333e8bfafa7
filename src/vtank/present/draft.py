"""A law that is data as the file of an effect, to be finished by hand: its code, its parameters, what is left to do."""

from __future__ import annotations

from ..effects.effect import DEPENDS_ON, SYMBOLS
from ..plant.formula import Factor, Formula

TEMPLATE = '''"""{title}: found in recordings by vtank diagnose; to be finished by hand.

{formula} [{unit}]

To do: its name, sentence and source; what it is confused with; typical sizes and bounds{term}.
"""

import math

from ..compiled import law
from .effect import Effect, Parameter


@law
def {function}({variables}, {names}):
    """{returns}."""
    return {code}


EFFECT = Effect(
    name="{name}",
    channel="{channel}",
    place="{place}",
    sentence="{sentence}",
    law="{formula}",
    parameters=(
{parameters}
    ),
    source="found in recordings; to be finished by hand",{more}
)
'''
OF = {"speed": "abs(u)", "turning": "abs(n)", "w": "w", "fresh": "fresh"}


def draft(name: str, formula: Formula, sentence: str) -> str:
    """The text of the effect `name`.py."""
    slots, values = formula.fitted(), formula.values()
    names = [slot.partition(".")[2] for slot in slots]
    used = [v for v in ("t", "x", "u", "z", "n", "gap", "a", "w", "fresh") if v in _variables(formula)]
    code = " * ".join([names[0], *(_code(f, f"{i}") for i, f in enumerate(formula.factors, start=1))])
    force, asked = formula.acts == "force", _variables(formula)
    whole = force and asked <= set(SYMBOLS)
    place = "its term in plant/surge.py, and in_equation=True" if force else "its term in the reading of the range"
    more = ['needs=("sonar",)'] if asked & {"x", "gap"} else []
    if whole:
        depends = [what for what, symbols in DEPENDS_ON.items() if symbols & asked]
        more += [f"depends_on={tuple(depends)!r}".replace("'", '"')] if depends else []
        more += ["force=acceleration"]
    parameters = [
        _parameter(n, formula.unit_of(s), values[s], s == slots[0]) for n, s in zip(names, slots, strict=True)
    ]
    if formula.memory:
        code += f"  # w: {formula.memory.text()}, a state of the plant; fresh: what it keeps, less w"
    return TEMPLATE.format(
        title=name.replace("_", " ").capitalize(), formula=formula.text(), unit=formula.unit,
        term="" if whole else f"; {place}", function="acceleration" if force else "error",
        variables=", ".join(used) or "u", names=", ".join(names), code=code, name=name, channel=formula.channel,
        returns="Acceleration [m/s2]" if force else "Error of the range [m]", place=formula.place, sentence=sentence,
        parameters="\n".join(parameters), more="".join(f"\n    {line}," for line in more),
    )  # fmt: skip


def _variables(formula: Formula) -> set[str]:
    return {{"speed": "u", "turning": "n"}.get(f.variable, f.variable) for f in formula.factors}


def _parameter(name: str, unit: str, value: float, size: bool) -> str:
    """A parameter about its fitted value; its unit in words, since those of effects are simple ones."""
    reach = 10.0 * abs(value) or 1.0
    shape = "" if size else ", shape=True"
    null = 0.0 if size else value
    return f'        Parameter("{name}", "-", "in {unit}; fitted {value:.6g}", {null:.6g}, ' + (
        f"({-reach:.6g}, {reach:.6g}), {abs(value) or 1.0:.6g}{shape}),"
    )


def _code(f: Factor, number: str) -> str:
    """A factor as Python."""
    v = OF.get(f.variable, f.variable)
    a = f"a{number}" if f.count else f"{f.a:g}"
    b = f"b{number}" if f.count > 1 else f"{f.b:.6g}"
    return {
        "power": f"abs({v}) ** {f.a:g}",
        "signed": f"math.tanh({v} / {f.b:g})" if f.a == 0.0 else f"math.copysign(abs({v}) ** {f.a:g}, {v})",
        "above": f"(0.5 + 0.5 * math.tanh(({v} - {a}) / {b}))",
        "beyond": f"max({'-' if f.b < 0.0 else ''}({v} - {a}), 0.0)",
        "sine": f"math.sin({a} * {v} + {b})",
        "decay": f"math.exp(-{v} / {a})",
        "from": f"({v} - {a})",
    }[f.operation]
