"""All effects at places, and their table."""

from __future__ import annotations

from .body import VEHICLES
from .effect import PlacedEffect
from .hydrodynamics import HYDRODYNAMICS
from .sensors import SENSORS
from .thrusters import THRUSTERS

CATALOGUE: tuple[PlacedEffect, ...] = (*HYDRODYNAMICS, *THRUSTERS, *SENSORS, *VEHICLES)


def keys(effect: PlacedEffect) -> str:
    """The keys that an effect takes in a scenario, endings by place where they differ."""
    numbers = [f"{number.name}{'|'.join(ending or '-' for ending in number.endings)}".removesuffix("-")
               for number in effect.numbers]  # fmt: skip
    return ", ".join([*numbers, *([effect.text[0]] if effect.text else [])])


def table() -> str:
    """The catalogue as a table in Markdown: where, keys, law."""
    rows = ["| effect | place | keys | law |", "|---|---|---|---|"]
    for effect in CATALOGUE:
        places = effect.kind if effect.kind != "axis" or len(effect.places) == 6 else " ".join(effect.places)
        rows.append(
            f"| {effect.name} | {places} | {keys(effect) or 'none'} | {effect.law.replace('|', chr(92) + '|')} |"
        )
    return "\n".join(rows) + "\n"
