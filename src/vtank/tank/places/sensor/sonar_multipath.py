"""Now and then an echo by way of surface or floor is taken for the wall, and reads long."""

from __future__ import annotations

from ..effect import Number, PlacedEffect
from .change import change

EFFECT = PlacedEffect(
    "sonar_multipath",
    "sensor",
    "range + extra with probability p",
    (
        Number("p", ("",), "probability per ping", low=0.0, high=1.0, usual=lambda _: 0.05, shape=True),
        Number("extra", ("_m",), "excess path", low=0.0, high=100.0, usual=lambda _: 0.5),
    ),
    channels=("range_m",),
    changes=change(echo=lambda sensor, p: (p["extra"], p["p"])),
    order=14,
)
