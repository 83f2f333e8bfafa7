"""All effects at places, and their table."""

from __future__ import annotations

from .body import VEHICLES
from .effect import PlacedEffect
from .hydrodynamics import HYDRODYNAMICS
from .sensors import SENSORS
from .thrusters import THRUSTERS

CATALOGUE: tuple[PlacedEffect, ...] = (*HYDRODYNAMICS, *THRUSTERS, *SENSORS, *VEHICLES)


def keys(effect: PlacedEffect) -> str:
    """The keys that an effect takes in a scenario; where they go by the place's unit, all of them."""
    numbers = [" or ".join(f"`{number.name}{ending}`" for ending in number.endings) for number in effect.numbers]
    return ", ".join([*numbers, *([f"`{effect.text}`"] if effect.text else [])])


def table() -> str:
    """The catalogue as a table in Markdown: where, keys, law."""
    rows = ["| effect | place | keys | law |", "|---|---|---|---|"]
    for effect in CATALOGUE:
        places = effect.kind if effect.kind != "axis" or len(effect.places) == 6 else " ".join(effect.places)
        rows.append(
            f"| {effect.name} | {places} | {keys(effect) or 'none'} | {effect.law.replace('|', chr(92) + '|')} |"
        )
    return "\n".join(rows) + "\n"
