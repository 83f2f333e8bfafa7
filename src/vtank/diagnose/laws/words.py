"""A formula in one plain sentence."""

from __future__ import annotations

from ...plant.formula import Factor, Formula, spelled

NAMES = {
    "u": "speed", "x": "the place along the tank", "gap": "the distance to the wall", "t": "time",
    "a": "acceleration", "z": "thrust", "speed": "the size of speed",
}  # fmt: skip
INPUTS = {"n_rev_s": "propeller speed", "command": "the command", "thrust_N": "the thrust put in"}


def sentence(formula: Formula) -> str:
    """What a formula says, such as `A force grows with the power 1.5 of speed while the gap is below 1.2 m.`"""
    what = {"force": "A force per unit of moving mass", "range": "An error of the range"}[formula.acts]
    latched = formula.memory is not None and formula.memory.kind == "latches"
    powers = [f for f in formula.factors if f.operation in ("power", "signed") and not (latched and f.variable == "w")]
    rest = [f for f in formula.factors if f not in powers]
    grows = " and ".join(_power(f, formula) for f in powers)
    parts = [f"{what} {f'goes with {grows}' if grows else 'of constant size'}", *(_said(f, formula) for f in rest)]
    return ", ".join(parts) + "."


def _power(f: Factor, formula: Formula) -> str:
    name = _named(f.variable, formula)
    if f.a == 0.0:
        return f"the sign of {name}"
    return name if f.a == 1.0 else f"the power {f.a:g} of {name}"


def _said(f: Factor, formula: Formula) -> str:
    name = _named(f.variable, formula)
    side = "below" if f.b < 0.0 else "above"
    return {
        "above": f"while {name} is {side} {_of(f.a, f.variable, formula)}",
        "beyond": f"in proportion to what {name} is {side} {_of(f.a, f.variable, formula)}",
        "sine": f"as a wave over {name}, one turn in {_of(6.283185 / abs(f.a or 1.0), f.variable, formula)}",
        "decay": f"{'falling' if f.a > 0.0 else 'growing'} e-fold over {_of(abs(f.a), f.variable, formula)} of {name}",
        "power": f"while {name} is on", "signed": f"while {name} is on", "from": f"while {name} is off",
    }[f.operation]  # fmt: skip


def _of(value: float, variable: str, formula: Formula) -> str:
    """A number with its unit, none where it has none."""
    unit = spelled(formula.dimension(variable)).replace(" s^-1", "/s")
    return f"{value:.3g} {unit}".removesuffix(" -")


def _named(variable: str, formula: Formula) -> str:
    m = formula.memory
    if variable not in ("w", "fresh") or m is None:
        size = "the size of " if variable == "turning" else ""
        return size + INPUTS[formula.fed] if variable in ("n", "turning") else NAMES[variable]
    q, unit = _power(m.quantity, formula), m.quantity.variable
    play = f"a play of {_of(m.a, unit, formula)} to either side"
    return {
        "follows": f"{'what' if variable == 'w' else 'what is new in what'} {q} was over the last {m.a:.3g} s",
        "sums": f"the sum of {q} so far",
        "latches": f"a latch that {q} sets above {_of(m.a, unit, formula)} and frees below {_of(m.b, unit, formula)}",
        "delays": f"what {q} was {m.a:.3g} s before",
        "plays": f"{q} with {play}" if variable == "w" else f"what {play} takes off {q}",
    }[m.kind]
