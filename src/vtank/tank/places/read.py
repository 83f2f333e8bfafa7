"""The [effects] of a whole vehicle's scenario."""

from __future__ import annotations

from typing import Any

from ...plant.actuators import INPUTS
from ...plant.vehicle import AXES, Vehicle
from ...record.table import Table
from ...record.toml import meant
from .catalogue import CATALOGUE, ordered
from .effect import VEHICLE, Number, Placed, PlacedEffect, part


def read_placed(table: Table, vehicle: Vehicle) -> tuple[Placed, ...]:
    """The effects that a table switches on, each by NAME@PLACE; InputError names file, key and what there is.

    They come in the order of the catalogue, in which they act, however the file has them.
    """
    placed = [one for key in table.entries for one in _read(table, key, vehicle)]
    table.close()
    return ordered(placed)


def places(vehicle: Vehicle) -> dict[str, tuple[str, ...]]:
    """Kind of a place -> the places of that kind that a vehicle has."""
    return {
        "axis": AXES,
        "thruster": tuple(t.name for t in vehicle.thrusters),
        "fin": tuple(fin.name for fin in vehicle.fins if fin.limit_rad),
        "sensor": tuple(sensor.name for sensor in vehicle.sensors),
        VEHICLE: (VEHICLE,),
    }


def partners(vehicle: Vehicle, name: str) -> tuple[str, ...]:
    """Other thrusters that take the same kind of input, whose wires may be exchanged with one's."""
    own = part(vehicle, "thrusters", name)
    return tuple(t.name for t in vehicle.thrusters if t.input == own.input and t.name != name)


def _read(table: Table, key: str, vehicle: Vehicle) -> list[Placed]:
    effect, place = _found(table, key, vehicle)
    own = table.table(key)
    values: dict[str, Any] = {
        number.name: own.number(key_of(number, place, vehicle), number.default, number.low, number.high)
        for number in effect.numbers
    }
    for number in effect.numbers:
        if values[number.name] and number.channel and number.channel not in part(vehicle, "sensors", place).channels:
            raise own.error(key_of(number, place, vehicle), f"'{place}' does not measure {number.channel}")
    if effect.numbers and not own.entries and all(number.default == 0.0 for number in effect.numbers):
        raise table.error(
            key, f"does nothing so; expected one of {', '.join(n.name + n.endings[0] for n in effect.numbers)}"
        )
    if effect.text == "other":
        one, others = part(vehicle, "thrusters", place), partners(vehicle, place)
        if not others:
            raise table.error(key, f"{vehicle.name} has no other thruster that takes {one.input}")
        two = part(vehicle, "thrusters", own.choice("other", others))
        own.close()
        return [Placed(effect, place, {"column": two.column}), Placed(effect, two.name, {"column": one.column})]
    if effect.text:
        channels = part(vehicle, "sensors", place).channels
        values["channel"] = own.choice("channel", ("", *channels), "")
    own.close()
    return [Placed(effect, place, values)]


def _found(table: Table, key: str, vehicle: Vehicle) -> tuple[PlacedEffect, str]:
    """The effect that a key names, and its place."""
    name, _, place = key.strip('"').partition("@")
    effects = [effect for effect in CATALOGUE if effect.name == name]
    if not effects:
        raise table.error(key, f"no effect '{name}'{meant(name, dict.fromkeys(e.name for e in CATALOGUE))}")
    there = places(vehicle)
    for effect in effects:
        if place in (effect.places if effect.kind == "axis" else there[effect.kind]):
            if effect.channels and not set(effect.channels) & set(part(vehicle, "sensors", place).channels):
                raise table.error(key, f"'{place}' measures none of {', '.join(effect.channels)}")
            return effect, place
    known = [p for effect in effects for p in (effect.places if effect.kind == "axis" else there[effect.kind])]
    if not known:
        raise table.error(key, f"{vehicle.name} has no {effects[0].kind}")
    raise table.error(key, f"expected {name}@PLACE, found the place '{place}'{meant(place, known)}")


def key_of(number: Number, place: str, vehicle: Vehicle) -> str:
    """Key of a number at a place: its name and the unit's ending there."""
    index = 0
    if len(number.endings) == 2:
        index = int(AXES.index(place) >= 3)
    elif len(number.endings) == 3:
        index = INPUTS.index(part(vehicle, "thrusters", place).input)
    return number.name + number.endings[index]
