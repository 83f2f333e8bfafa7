"""What a pilot makes of the readings: which instrument tells a place or a speed, and how far that is from an order.

Of two instruments that measure the same the first of the vehicle file is read. Velocities of a turned instrument are
turned back; its lever arm is neglected.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..plant.vehicle import AXES, Vehicle
from ..record.columns import RATES, SPEEDS, VELOCITY
from .orders import Order

Array = NDArray[np.float64]
PLACE = {"heave": "depth_m", "roll": "roll_rad", "pitch": "pitch_rad", "yaw": "heading_rad"}
SPEED = dict(zip(AXES, SPEEDS, strict=True))
LEVEL = ("north_m", "east_m", "heading_rad")  # what a place along surge or sway takes
TRIPLES = (VELOCITY, RATES)


class Sensing:
    """The instruments of one vehicle, as its file has them; it starts at north = east = 0, heading north."""

    def __init__(self, vehicle: Vehicle, depth_m: float) -> None:
        """depth_m: at the start."""
        self._start = {"depth_m": depth_m}
        self._sources = {channel: s for s in reversed(vehicle.sensors) for channel in s.channels}
        self._watched = {SPEED["surge"]}

    def watch(self, order: Order) -> None:
        """Look at what an order takes from now on."""
        self._watched |= {*self._needed(order), *([SPEED[order.axis]] if order.axis in AXES else [])}
        for triple in TRIPLES:
            if self._watched & set(triple):
                self._watched |= set(triple)

    def missing(self, order: Order) -> str:
        """A channel that an order must have and no instrument measures, "" where there is none."""
        return next((channel for channel in self._needed(order) if channel not in self._sources), "")

    @staticmethod
    def _needed(order: Order) -> tuple[str, ...]:
        """Channels without which an order cannot be obeyed; one of a speed can, by its drag."""
        if order.turns_at_rad:
            return ("heading_rad",)
        if order.loop != "place":
            return ()
        if order.target in ("surge", "sway"):
            return LEVEL
        return (PLACE[order.target], *([PLACE[order.through]] if order.through else []))

    def latency_s(self, channel: str) -> float:
        """Of the instrument that tells a channel [s]; 0 where none does."""
        return self._sources[channel].latency_s if channel in self._sources else 0.0

    def look(self, readings: Mapping[str, float]) -> dict[str, float]:
        """The last reading of every watched channel that has one, velocities in body axes, depth from the start."""
        seen = {}
        for channel in self._watched & set(self._sources):
            value = readings.get(f"{self._sources[channel].name}.{channel}")
            if value is not None:
                seen[channel] = value - self._start.get(channel, 0.0)
        for triple in TRIPLES:
            sources = {self._sources[channel].name for channel in triple if channel in seen}
            if len(sources) == 1 and all(channel in seen for channel in triple):
                turn = self._sources[triple[0]].rotation
                seen |= dict(zip(triple, (turn @ [seen[channel] for channel in triple]).tolist(), strict=True))
        return seen

    @staticmethod
    def error(axis: str, seen: Mapping[str, float], ordered: Mapping[str, float]) -> float | None:
        """How far the vehicle is beyond the ordered place along one of its axes [m or rad]; None if not known yet."""
        if axis in ("surge", "sway"):
            if any(channel not in seen for channel in LEVEL):
                return None
            north, east = seen["north_m"] - ordered.get("surge", 0.0), seen["east_m"] - ordered.get("sway", 0.0)
            c, s = np.cos(seen["heading_rad"]), np.sin(seen["heading_rad"])
            return float(c * north + s * east if axis == "surge" else c * east - s * north)
        if PLACE[axis] not in seen:
            return None
        error = seen[PLACE[axis]] - ordered.get(axis, 0.0)
        return error if axis == "heave" else float((error + np.pi) % (2.0 * np.pi) - np.pi)
