"""What stands between hull and recording: the laws of the effects that act there, one after the other.

An effect's file says by its hooks what it does to a sensor's reading, to the instant at which that was true, to the
input that acts, and to the input behind a recorded one; being there is enough.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..compiled import term
from ..effects.catalogue import CATALOGUE
from ..effects.effect import Effect
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


def shifting(effects: Sequence[Effect] = CATALOGUE) -> tuple[str, ...]:
    """Names of the parameters that shift an instant, of the input or of a measurement."""
    return tuple(name for e in effects if e.instant or e.acts for name in e.slots())
