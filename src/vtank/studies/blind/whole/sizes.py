"""How large an effect at a place is in a blind trial: usual values for vehicle and place, times a drawn size."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ....plant.vehicle import AXES, Vehicle
from ....tank.places import Number, PlacedEffect, key_of, partners

U_M_S, U_RAD_S = 0.4, 0.3  # usual speeds, choices


class Usual:
    """Usual values at a place of a vehicle: speed, force, mass, length, input."""

    def __init__(self, vehicle: Vehicle, kind: str, place: str) -> None:
        """kind, place: as of an effect."""
        axis = AXES.index(place) if kind == "axis" else 0
        self.u = U_M_S if axis < 3 else U_RAD_S
        drag = vehicle.linear_drag[axis] * self.u + vehicle.quadratic_drag[axis] * self.u**2
        self.mass = vehicle.mass_kg + float(vehicle.added_mass[1, 1] - vehicle.added_mass[0, 0])
        self.force, self.length = max(float(drag), 1e-3), 1.0
        self.hull = max(abs(end) for end in vehicle.ends_m)
        self.weight = vehicle.buoyancy_N
        self.input = 1.0
        if kind == "thruster":
            thruster = next(t for t in vehicle.thrusters if t.name == place)
            self.input = float(thruster.input_for(np.array([0.4 * thruster.most_N(1.0)]))[0])
            self.force = 0.4 * thruster.most_N(1.0)


Value = Callable[[Usual], float]
VALUES: dict[tuple[str, str], Value] = {  # (effect, number) -> value at size 1, all choices; others below, by number
    ("linear_drag", "c"): lambda s: 0.5 * s.force / s.u,
    ("coulomb_friction", "f"): lambda s: 0.3 * s.force,
    ("tether", "k"): lambda s: 0.3 * s.force / s.length,
    ("wake_memory", "k"): lambda s: 0.3,
    ("wake_memory", "T"): lambda s: 5.0,
    ("munk_moment", "c"): lambda s: 0.3 * s.mass,
    ("coriolis", "c"): lambda s: 0.3 * s.mass,
    ("seiche", "amplitude"): lambda s: 0.05,
    ("seiche", "frequency"): lambda s: 0.7,
    ("seiche", "phase"): lambda s: 1.0,
    ("constant_force", "F"): lambda s: 0.3 * s.force,
    ("thrust_loss", "gamma"): lambda s: 0.3 * s.force / s.input / U_M_S,
    ("supply_sag", "r"): lambda s: 0.003,
    ("thrust_lag", "tau"): lambda s: 0.4,
    ("thruster_dead", "share"): lambda s: 0.5,
    ("fin_weak", "share"): lambda s: 0.4,
    ("fin_offset", "angle"): lambda s: 0.05,
    ("sensor_latency", "d"): lambda s: 0.3,
    ("sensor_scale", "s"): lambda s: 0.1,
    ("wrong_unit", "factor"): lambda s: 1.0 / 0.3048,
    ("clock_skew", "s"): lambda s: 0.005,
    ("clock_offset", "o"): lambda s: 0.4,
    ("magnetometer_bias", "b"): lambda s: 0.15,
    ("depth_offset", "o"): lambda s: 0.3,
    ("sonar_offset", "o"): lambda s: 0.1,
    ("sonar_multipath", "p"): lambda s: 0.05,
    ("sonar_multipath", "extra"): lambda s: 0.5,
    ("tachometer_spikes", "p"): lambda s: 0.05,
    ("tachometer_spikes", "size"): lambda s: 0.5 * s.input,
    ("buoyancy", "B"): lambda s: 0.005 * s.weight,
    ("trim_weight", "m"): lambda s: 0.0005 * s.weight,
    ("coriolis_left_out", "share"): lambda s: 0.8,
    ("cross_flow_drag", "sway"): lambda s: 3.0 * s.force / U_M_S**2,
    ("cross_flow_drag", "heave"): lambda s: 3.0 * s.force / U_M_S**2,
    ("cross_flow_drag", "tail"): lambda s: -s.hull,
    ("cross_flow_drag", "nose"): lambda s: s.hull,
    ("thruster_turned", "yaw"): lambda s: 0.3,
    ("thruster_turned", "pitch"): lambda s: 0.2,
}
BY_NUMBER: dict[str, Value] = {
    "e": lambda s: 0.3,
    "U": lambda s: 0.4 * s.u,
    "n0": lambda s: 0.3 * s.input,
    "n_max": lambda s: 0.6 * s.input,
    "d": lambda s: 0.4,
    "b": lambda s: 0.2 * s.input,
}
BY_KIND: dict[str, Value] = {  # of vectors, by their unit's ending
    "_m": lambda s: 0.05 * s.hull,
    "_rad": lambda s: 0.15,
    "_rad_s": lambda s: 0.02,
    "_m_s2": lambda s: 0.1,
    "_m_s": lambda s: 0.1,
    "_N": lambda s: s.force,
    "_N_per_m": lambda s: 0.3 * s.force,
}
FIXED = {"T", "frequency", "phase", "tail", "nose", "factor", "p", "n_max"}  # not turned up and down with the size


def entries(
    random: np.random.Generator, effect: PlacedEffect, place: str, vehicle: Vehicle, size: float
) -> dict[str, Any]:
    """The keys and values of an effect in a scenario, at a size of which 1 is usual."""
    usual = Usual(vehicle, effect.kind, place)
    drawn: dict[str, Any] = {}
    measured = {c for s in vehicle.sensors if effect.kind == "sensor" and s.name == place for c in s.channels}
    numbers = [n for n in effect.numbers if not n.channel or n.channel in measured]
    vector = sum(number.default == 0.0 for number in numbers)  # a direction is drawn for it
    for number in numbers:
        value = _value(effect.name, number)(usual) * (1.0 if number.name in FIXED else size)
        value *= random.uniform(0.1, 1.0) if vector > 1 and number.name not in FIXED else 1.0
        sign = -1.0 if number.low < 0.0 < number.high and number.name not in FIXED and random.random() < 0.5 else 1.0
        drawn[key_of(number, place, vehicle)] = float(np.clip(sign * value, number.low, 0.98 * number.high))
    if effect.name == "wrong_allocation":
        drawn["other"] = str(random.choice(partners(vehicle, place)))
    return drawn


def _value(effect: str, number: Number) -> Value:
    return VALUES.get((effect, number.name)) or BY_NUMBER.get(number.name) or BY_KIND[number.endings[0]]
