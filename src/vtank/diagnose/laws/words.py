"""A formula in one plain sentence."""

from __future__ import annotations

from ...plant.formula import Factor, Formula, Memory

NAMES = {
    "u": "speed", "n": "propeller speed", "x": "the place along the tank", "gap": "the distance to the wall",
    "t": "time", "a": "acceleration", "z": "thrust", "speed": "the size of speed",
    "turning": "the size of propeller speed",
}  # fmt: skip
UNITS = {
    "u": "m/s",
    "speed": "m/s",
    "n": "rev/s",
    "turning": "rev/s",
    "x": "m",
    "gap": "m",
    "t": "s",
    "a": "m/s2",
    "z": "m/s2",
}


def sentence(formula: Formula) -> str:
    """What a formula says, such as `A force grows with the power 1.5 of speed while the gap is below 1.2 m.`"""
    what = {"force": "A force per unit of moving mass", "range": "An error of the range"}[formula.acts]
    powers = [f for f in formula.factors if f.operation in ("power", "signed", "from") and f.variable != "w"]
    rest = [f for f in formula.factors if f not in powers]
    grows = " and ".join(_power(f, formula.memory) for f in powers)
    parts = [
        f"{what} {f'goes with {grows}' if grows else 'of constant size'}",
        *(_said(f, formula.memory) for f in rest),
    ]
    return ", ".join(parts) + "."


def _power(f: Factor, memory: Memory | None) -> str:
    name = _named(f.variable, memory)
    if f.operation == "from":
        return f"{name} beyond {f.a:.3g}"
    if f.a == 0.0:
        return f"the sign of {name}"
    return name if f.a == 1.0 else f"the power {f.a:g} of {name}"


def _said(f: Factor, memory: Memory | None) -> str:
    name, unit = _named(f.variable, memory), UNITS.get(f.variable, "")
    side = "below" if f.b < 0.0 else "above"
    return {
        "above": f"while {name} is {side} {f.a:.3g} {unit}".rstrip(),
        "beyond": f"in proportion to what {name} is {side} {f.a:.3g} {unit}".rstrip(),
        "sine": f"as a wave over {name}, one turn in {6.283185 / abs(f.a or 1.0):.3g} {unit}".rstrip(),
        "decay": f"{'falling' if f.a > 0.0 else 'growing'} e-fold over {abs(f.a):.3g} {unit} of {name}",
        "power": f"times {name}", "signed": f"times {name}", "from": f"while not {name}",
    }[f.operation]  # fmt: skip


def _named(variable: str, memory: Memory | None) -> str:
    if variable not in ("w", "fresh") or memory is None:
        return NAMES[variable]
    q = _power(memory.quantity, None)
    if memory.kind == "follows":
        return f"{'what' if variable == 'w' else 'what is new in what'} {q} was over the last {memory.a:.3g} s"
    if memory.kind == "sums":
        return f"the sum of {q} so far"
    return f"a latch that {q} sets above {memory.a:.3g} and frees below {memory.b:.3g}"
