"""A vehicle that a diagnosis corrected, as the tank flies it: other numbers, and effects that its file does not know.

The corrections are numbers of `rigid.layout`, QUANTITY@PLACE; those that the file has take its numbers' places, the
others become effects of `tank.places`. What spoils a recording alone (lone wrong readings, echoes) is not flown, nor
what belongs to one recording (how the wall stood).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..plant.actuators import Thruster
from ..plant.sensor import Sensor
from ..plant.vehicle import AXES, COUPLING, Vehicle
from ..record.columns import channel_of
from .places.catalogue import CATALOGUE
from .places.effect import VEHICLE, Placed
from .places.vehicle.offset import EARTH

Numbers = Mapping[str, float]
OF: Mapping[str, Mapping[str, tuple[str, str]]] = {  # kind of place -> quantity -> the effect that it is, its number
    "axis": {
        "coulomb_friction": ("coulomb_friction", "f"), "drag_asymmetry": ("drag_asymmetry", "e"),
        "force": ("constant_force", "F"), "drift": ("ambient_current", "U"), "spring": ("tether", "k"),
        "wake": ("wake_memory", "k"), "recovery": ("wake_memory", "T"), "wall_drag": ("wall_proximity", "drag"),
        "wall_mass": ("wall_proximity", "mass"),
    },
    "thruster": {
        "deadband": ("thrust_deadband", "n0"), "saturation": ("thrust_saturation", "n_max"),
        "asymmetry": ("thrust_asymmetry", "e"), "slower": ("thrust_lag", "tau"), "delay": ("command_delay", "d"),
        "loss": ("thrust_loss", "gamma"), "sag": ("supply_sag", "r"), "misread": ("tachometer_bias", "b"),
        "yawed": ("thruster_turned", "yaw"), "pitched": ("thruster_turned", "pitch"),
    },
    "fin": {
        "offset": ("fin_offset", "angle"), "induced_drag": ("fin_drag", "k"), "late": ("fin_delay", "d"),
        "lost": ("fin_weak", "share"),
    },
    VEHICLE: {
        **{f"current_{way}": ("current", way) for way in EARTH}, **{f"pull_{way}": ("tether", way) for way in EARTH},
        "tether": ("tether", "k"), **{f"held_at_{i}": ("tether", i) for i in "xyz"}, "trim": ("trim_weight", "m"),
        **{f"trim_{i}": ("trim_weight", i) for i in "xyz"}, "crossflow_h": ("cross_flow_drag", "sway"),
        "crossflow_v": ("cross_flow_drag", "heave"), "left_out": ("coriolis_left_out", "share"),
    },
}  # fmt: skip


def corrected(vehicle: Vehicle, quickest_s: float) -> tuple[Vehicle, tuple[Placed, ...]]:
    """The vehicle with its corrections in place of its numbers, and the effects that stand for the others.

    quickest_s: the shortest lag that can be flown [s]; a shorter one is none.
    """
    c = vehicle.corrections
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
    return changed, _effects(vehicle)


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
    file_s = sensor.latency_s + sensor.clock_offset_s
    later_s = c.get(f"latency@{name}", file_s) - file_s
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


def _effects(vehicle: Vehicle) -> tuple[Placed, ...]:
    """The effects that stand for what the file does not have."""
    found: dict[tuple[str, str, str], dict[str, Any]] = {}  # kind of place, place, effect -> its numbers

    def put(kind: str, place: str, effect: str, **values: Any) -> None:
        found.setdefault((kind, place, effect), {}).update(values)

    kinds = {axis: "axis" for axis in AXES} | {"hull": VEHICLE}
    kinds |= {thruster.name: "thruster" for thruster in vehicle.thrusters} | {fin.name: "fin" for fin in vehicle.fins}
    centre = dict(zip("xyz", vehicle.centre_m or (0.0, 0.0, 0.0), strict=True))
    for name, value in vehicle.corrections.items():
        quantity, _, place = name.partition("@")
        kind = kinds.get(place, "sensor")
        place = VEHICLE if kind == VEHICLE else place
        if quantity in OF.get(kind, {}):
            effect, number = OF[kind][quantity]
            put(kind, place, effect, **{number: value})
        elif quantity == "coupling":
            put(kind, place, "munk_moment" if place in ("pitch", "yaw") else "coriolis", c=value)
        elif quantity.startswith("swell"):
            put(kind, place, "seiche", **_swell(vehicle.corrections, place))
        elif quantity.startswith("centre_of_gravity"):
            put(kind, place, "centre_of_gravity", **{quantity[-1]: value - centre[quantity[-1]]})
        elif quantity == "lost":  # 1 of all, 2 where it pushes the other way
            put(kind, place, "thruster_dead", share=value if value <= 1.0 else 2.0 - value)
            if value > 1.0:
                put(kind, place, "thruster_reversed")
        elif quantity == "wired":
            put(kind, place, "wrong_allocation", column=vehicle.thrusters[round(value) - 1].column)
        if quantity.startswith("crossflow"):
            put(kind, place, "cross_flow_drag", nose=vehicle.ends_m[0], tail=vehicle.ends_m[1])
    return tuple(_placed(*key, values) for key, values in found.items())


def _swell(c: Numbers, axis: str) -> dict[str, float]:
    """The wave that is sine and cosine, as amplitude and phase."""
    sine, cosine = (c.get(f"{name}@{axis}", 0.0) for name in ("swell", "swell_ahead"))
    frequency = c.get(f"swell_rate@{axis}", 0.0)
    return {"amplitude": math.hypot(sine, cosine), "frequency": frequency, "phase": math.atan2(cosine, sine)}


def _placed(kind: str, place: str, name: str, values: Mapping[str, Any]) -> Placed:
    """An effect with all of its numbers."""
    effect = next(effect for effect in CATALOGUE if (effect.kind, effect.name) == (kind, name))
    return Placed(effect, place, {number.name: number.default or 0.0 for number in effect.numbers} | dict(values))
