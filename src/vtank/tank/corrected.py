"""A vehicle that a diagnosis corrected, as the tank flies it: other numbers, and effects that its file does not know.

The corrections are numbers of `rigid.layout`, QUANTITY@PLACE; those that the file has take its numbers' places, the
others become effects of `tank.places`. What spoils a recording alone (lone wrong readings, echoes) is not flown, nor
what belongs to one recording (how the wall stood), nor the lag of a rotor, instead of which the tank's force lags, nor
how a fin goes with an oblique flow or beyond its stall, where the tank's has the law of `tank.fins`, nor inputs that
act before they are given or on the way to the next: the tank holds them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..plant.actuators import Thruster
from ..plant.sensor import Sensor
from ..plant.vehicle import AXES, COUPLING, Vehicle
from ..record.columns import channel_of
from .places.catalogue import CATALOGUE
from .places.effect import Placed
from .places.read import places

Numbers = Mapping[str, float]


def corrected(vehicle: Vehicle, quickest_s: float) -> tuple[Vehicle, tuple[Placed, ...]]:
    """The vehicle with its corrections in place of its numbers, and the effects that stand for the others.

    quickest_s: the shortest lag that can be flown [s]; a shorter one is none.
    """
    late = ("delay@", "late@")
    c = {name: value for name, value in vehicle.corrections.items() if value > 0.0 or not name.startswith(late)}
    vehicle = replace(vehicle, corrections=c)
    changed = replace(
        vehicle,
        added_mass=_added_mass(vehicle, c),
        linear_drag=np.array(_each(c, "linear_drag@{}", AXES, vehicle.linear_drag)),
        quadratic_drag=np.array(_each(c, "quadratic_drag@{}", AXES, vehicle.quadratic_drag)),
        buoyancy_N=c.get("buoyancy@hull", vehicle.buoyancy_N),
        centre_of_buoyancy_m=np.array(_each(c, "centre_of_buoyancy_{}@hull", "xyz", vehicle.centre_of_buoyancy_m)),
        thrusters=tuple(_thruster(thruster, c, quickest_s) for thruster in vehicle.thrusters),
        fins=tuple(
            replace(
                fin,
                lift_per_rad=c.get(f"lift@{fin.name}", fin.lift_per_rad),
                suction=c.get(f"suction@{fin.name}", fin.suction),
            )
            for fin in vehicle.fins
        ),
        sensors=tuple(_sensor(vehicle, sensor) for sensor in vehicle.sensors),
        corrections={},
    )
    return changed, tuple(_effects(vehicle))


def _added_mass(vehicle: Vehicle, c: Numbers) -> np.ndarray:
    matrix = vehicle.added_mass.copy()
    for i, axis in enumerate(AXES):
        matrix[i, i] = c.get(f"added_mass@{axis}", matrix[i, i])
    for key, (i, j) in COUPLING.items():
        pair = "_".join(key.split("_")[:2])
        matrix[i, j] = matrix[j, i] = c.get(f"added_mass_{pair}@hull", matrix[i, j])
    return matrix


def _each(c: Numbers, name: str, of: Iterable[str], known: Iterable[float]) -> tuple[Any, ...]:
    """Numbers as they are corrected, one for each of `of`, which goes into the name."""
    return tuple(float(c.get(name.format(one), value)) for one, value in zip(of, known, strict=True))


def _thruster(thruster: Thruster, c: Numbers, quickest_s: float) -> Thruster:
    """With another gain, which all of its forces have, and lag."""
    gain, lag_s = c.get(f"gain@{thruster.name}", 1.0), c.get(f"lag@{thruster.name}", thruster.lag_s)
    return replace(
        thruster,
        gain=gain * thruster.gain,
        curve=tuple((asked, gain * force) for asked, force in thruster.curve),
        limit_N=gain * thruster.limit_N,
        lag_s=lag_s if lag_s >= quickest_s else 0.0,
    )


def _sensor(vehicle: Vehicle, sensor: Sensor) -> Sensor:
    """With other errors and another place."""
    c, name, radians = vehicle.corrections, sensor.name, np.radians(sensor.rotation_deg)
    later_s = c.get(f"latency@{name}", sensor.late_s) - sensor.late_s
    of = {channel_of(column): column for slot in c if (column := slot.partition("@")[2]) and
          slot.startswith(("scale@", "bias@")) and vehicle.instrument(column) == name}  # fmt: skip
    columns = [of.get(channel, "") for channel in sensor.channels]
    roll, pitch, yaw = _each(c, f"rotation_{{}}@{name}", ("roll", "pitch", "yaw"), radians)
    scale = _each(c, "scale@{}", columns, sensor.each("scale"))
    bias = _each(c, "bias@{}", columns, np.multiply(scale, sensor.each("bias")))
    return replace(
        sensor,
        latency_s=sensor.latency_s + max(later_s, 0.0),
        clock_offset_s=sensor.clock_offset_s + min(later_s, 0.0),  # the clock is behind
        clock_skew=c.get(f"skew@{name}", sensor.clock_skew),
        rotation_deg=(math.degrees(roll), math.degrees(pitch), math.degrees(yaw)),
        position_m=_each(c, f"position_{{}}@{name}", "xyz", sensor.position_m),
        earth_axes=bool(c.get(f"earth@{name}", sensor.earth_axes)),
        scale=scale,
        bias=tuple(np.divide(bias, scale).tolist()),  # the instrument adds it before it multiplies
    )


def _effects(vehicle: Vehicle) -> Iterator[Placed]:
    """The effects that stand for what the file does not have."""
    where = places(vehicle)
    for effect in CATALOGUE:
        for place in where[effect.kind]:
            if effect.kind != "axis" or place in effect.places:
                values = effect.corrected(vehicle, place)
                if values is not None:
                    yield Placed(effect, place, values)
