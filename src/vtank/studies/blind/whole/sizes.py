"""How large an effect at a place is in a blind trial: its usual values for vehicle and place, times a drawn size."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....plant.vehicle import Vehicle
from ....tank.places import PlacedEffect, Usual, key_of, partners


def entries(
    random: np.random.Generator, effect: PlacedEffect, place: str, vehicle: Vehicle, size: float
) -> dict[str, Any]:
    """The keys and values of an effect in a scenario, at a size of which 1 is usual."""
    usual = Usual(vehicle, effect.kind, place)
    drawn: dict[str, Any] = {}
    measured = {c for s in vehicle.sensors if effect.kind == "sensor" and s.name == place for c in s.channels}
    numbers = [n for n in effect.numbers if not n.channel or n.channel in measured]
    vector = sum(number.default == 0.0 for number in numbers) > 1  # a direction is drawn for it
    for number in numbers:
        value = number.usual(usual)
        if not number.shape:
            value *= size * (random.uniform(0.1, 1.0) if vector else 1.0)
            value *= -1.0 if number.low < 0.0 < number.high and random.random() < 0.5 else 1.0
        drawn[key_of(number, place, vehicle)] = float(np.clip(value, number.low, 0.98 * number.high))
    if effect.text == "other":
        drawn["other"] = str(random.choice(partners(vehicle, place)))
    return drawn
