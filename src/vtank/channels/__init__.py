"""What can be measured of a plant: one row per sensor."""

from __future__ import annotations

from ..plant.plant import Plant
from . import planar, surge
from .channel import Channel

TABLES: dict[str, tuple[Channel, ...]] = {"surge": surge.CHANNELS, "planar": planar.CHANNELS}


def channels(plant: Plant) -> tuple[Channel, ...]:
    """The channels of a plant; a measurement's kind is its place in this table."""
    return TABLES[plant.name]
