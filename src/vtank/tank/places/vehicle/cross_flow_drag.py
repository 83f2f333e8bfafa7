"""Every strip of the hull drags in the flow that it meets itself."""

from __future__ import annotations

import numpy as np

from ....plant.vehicle import Vehicle
from ....water.record import SIZE, field
from .. import laws
from ..effect import VEHICLE, Array, Moving, Number, PlacedEffect, Values


def strips(s: Moving, place: str, p: Values) -> Array:
    """Drag of the flow across the hull from tail to nose."""
    user = np.zeros(SIZE)
    field(user, "cross_flow")[...] = p["tail"], p["nose"], p["sway"], p["heave"]
    return np.array(laws.strips(user, tuple(s.through)))


def along_the_hull(vehicle: Vehicle, place: str) -> dict[str, float] | None:
    """Its corrections, over the length of the vehicle."""
    sizes = {"sway": vehicle.corrections.get("crossflow_h@hull"), "heave": vehicle.corrections.get("crossflow_v@hull")}
    found = {name: size for name, size in sizes.items() if size is not None}
    nose, tail = vehicle.ends_m
    ends = {"nose": vehicle.corrections.get("nose@hull", nose), "tail": vehicle.corrections.get("tail@hull", tail)}
    return {**found, **ends} if found else None


EFFECT = PlacedEffect(
    "cross_flow_drag",
    VEHICLE,
    "dY = -sway |V| (v + x r) dx, dZ = -heave |V| (w - x q) dx, from tail to nose",
    (
        Number("sway", ("_N_s2_per_m3",), "drag per length in sway", 0.0, 0.0, usual=lambda s: 3.0 * s.force / s.u**2),
        Number(
            "heave", ("_N_s2_per_m3",), "drag per length in heave", 0.0, 0.0, usual=lambda s: 3.0 * s.force / s.u**2
        ),
        Number("tail", ("_m",), "hindmost x", low=-100.0, high=100.0, usual=lambda s: -s.hull, shape=True),
        Number("nose", ("_m",), "foremost x", low=-100.0, high=100.0, usual=lambda s: s.hull, shape=True),
    ),
    wrench=strips,
    of=along_the_hull,
    order=6,
)
