"""A fin has lost part of its area."""

from __future__ import annotations

from ....plant.vehicle import Vehicle
from ..effect import Number, PlacedEffect, Values, part, with_part


def smaller(vehicle: Vehicle, name: str, p: Values) -> Vehicle:
    """Part of a fin's area gone."""
    fin = part(vehicle, "fins", name)
    return with_part(vehicle, "fins", name, area_m2=fin.area_m2 * (1.0 - p["share"]))


EFFECT = PlacedEffect(
    "fin_weak",
    "fin",
    "A -> (1 - share) A",
    (Number("share", ("",), "of its area that is lost", 1.0, 0.0, 0.999, usual=lambda _: 0.4, slot="lost"),),
    changes=smaller,
    order=2,
)
