"""What stands between hull and recording: the laws of the effects that act there, one after the other.

An effect's file says by its hooks what it does to a sensor's reading, to the instant at which that was true, to the
input that acts, and to the input behind a recorded one; being there is enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..compiled import term
from ..effects.catalogue import CATALOGUE
from ..effects.effect import Effect, Parameter
from .parameters import indices


@term
def unchanged(value, p):
    """Nothing stands between."""
    return value


def acting_on(place: str) -> tuple[Effect, ...]:
    """The effects of one place, in the order in which they act from the hull to the recording."""
    return tuple(effect for effect in CATALOGUE if effect.place == place)


def chained(effects: Sequence[Effect], hook: str, more: str = "") -> Callable[..., Any]:
    """(value, *more, p) -> the value after the law of each effect that has this hook; more: their other arguments."""
    laws = [(getattr(effect, hook), indices(effect)) for effect in effects if getattr(effect, hook) is not None]
    text, space = "value", {}
    for i, (law, slots) in enumerate(laws):
        space[f"law{i}"] = law
        text = f"law{i}({text}, {more}{''.join(f'p[{k}], ' for k in slots)})"
    exec(f"def chain(value, {more}p):\n    return {text}\n", space)
    return term(space["chain"])


def added(effects: Sequence[Effect], symbols: Mapping[str, str], laws: Mapping[str, Any]) -> Callable[..., Any]:
    """(force, *, p) -> the force with that of each effect that has one, skipped where all its sizes are null.

    symbols: what a law may ask for by the names of its arguments -> how that is written. laws: the functions in these.
    ValueError for a law that asks for anything else, or depends on place or time where its effect does not say so.
    """
    lines, space = [], {"inf": math.inf, **laws}
    for effect in effects:
        if effect.force is not None:
            space[effect.name] = effect.force
            sizes = [f"p[{k}] != {q.null!r}" for k, q in _numbered(effect) if not q.shape]
            asked = [symbols[name] for name in effect.asked()] + [f"p[{k}]" for k, _ in _numbered(effect)]
            lines.append(f"    if {' or '.join(sizes)}:\n        force = force + {effect.name}({', '.join(asked)})\n")
    given = ", ".join(name for name, written in symbols.items() if name == written)
    exec(f"def add(force, {given}, p):\n{''.join(lines)}    return force\n", space)
    return term(space["add"])


def _numbered(effect: Effect) -> list[tuple[int, Parameter]]:
    return list(zip(indices(effect), effect.parameters, strict=True))


def shifting() -> tuple[str, ...]:
    """Names of the parameters that shift an instant, of the input or of a measurement."""
    return tuple(name for e in CATALOGUE if e.instant or e.acts for name in e.slots())
