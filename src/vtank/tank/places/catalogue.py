"""All effects at places, and their table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from importlib import import_module

from ...effects.loaded import effects_in
from ...errors import InputError
from .effect import KINDS, Placed, PlacedEffect


def _found(kind: str) -> Iterator[PlacedEffect]:
    """The effects of a folder: one in each file that holds an EFFECT."""
    folder = f"{__package__}.{kind}"
    for _, effect in effects_in(folder, import_module(folder).__path__):
        yield effect


CATALOGUE: tuple[PlacedEffect, ...] = tuple(
    effect for kind in KINDS for effect in sorted(_found(kind), key=lambda effect: (effect.order, effect.name))
)


def ordered(effects: Sequence[Placed]) -> tuple[Placed, ...]:
    """In the order of the catalogue, in which they act; InputError for one with a memory that is there twice."""
    remembering = [placed.name for placed in effects if placed.effect.keep]
    if twice := {name for name in remembering if remembering.count(name) > 1}:
        raise InputError(f"effects: {', '.join(sorted(twice))}: the vehicle has it already; expected it once")
    return tuple(sorted(effects, key=lambda placed: CATALOGUE.index(placed.effect)))


def keys(effect: PlacedEffect) -> str:
    """The keys that an effect takes in a scenario; where they go by the place's unit, all of them."""
    numbers = [" or ".join(f"`{number.name}{ending}`" for ending in number.endings) for number in effect.numbers]
    return ", ".join([*numbers, *([f"`{effect.text}`"] if effect.text else [])])


def table(effects: Sequence[PlacedEffect] = CATALOGUE) -> str:
    """Effects as a table in Markdown: where, keys, law."""
    rows = ["| effect | place | keys | law |", "|---|---|---|---|"]
    for effect in effects:
        places = effect.kind if effect.kind != "axis" or len(effect.places) == 6 else " ".join(effect.places)
        rows.append(
            f"| {effect.name} | {places} | {keys(effect) or 'none'} | {effect.law.replace('|', chr(92) + '|')} |"
        )
    return "\n".join(rows) + "\n"
