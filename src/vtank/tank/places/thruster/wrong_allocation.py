"""The inputs of two thrusters are exchanged."""

from __future__ import annotations

from ....plant.vehicle import Vehicle
from ..effect import PlacedEffect


def wired(vehicle: Vehicle, name: str) -> dict[str, str] | None:
    """The column of the thruster whose inputs it gets by the corrections."""
    number = vehicle.corrections.get(f"wired@{name}", 0.0)
    return {"column": vehicle.thrusters[round(number) - 1].column} if number else None


EFFECT = PlacedEffect(
    "wrong_allocation",
    "thruster",
    "n_this <-> n_other",
    text="other",
    of=wired,
    order=12,
)
