"""What makes another sensor of a vehicle's sensor: attributes, biases and factors of its channels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ....plant.sensor import Sensor
from ....plant.vehicle import Vehicle
from ..effect import Values, part, with_part


def change(**attributes: Callable[[Sensor, Any], Any]) -> Callable[[Vehicle, str, Any], Vehicle]:
    """Makes another sensor of it: attribute -> (sensor, values) -> its new value."""

    def changed(vehicle: Vehicle, name: str, p: Any) -> Vehicle:
        sensor = part(vehicle, "sensors", name)
        return with_part(vehicle, "sensors", name, **{key: make(sensor, p) for key, make in attributes.items()})

    return changed


def biased(channels: dict[str, str]) -> Callable[[Vehicle, str, Any], Vehicle]:
    """Adds to channels: number of the effect -> channel."""

    def added(sensor: Sensor, p: Values) -> tuple[float, ...]:
        more = {channel: p[name] for name, channel in channels.items()}
        return tuple(
            bias + more.get(channel, 0.0) for channel, bias in zip(sensor.channels, sensor.each("bias"), strict=True)
        )

    return change(bias=added)


def scaled(factor: Callable[[Any], float]) -> Callable[[Vehicle, str, Any], Vehicle]:
    """Multiplies one channel, or all."""

    def multiplied(sensor: Sensor, p: Any) -> tuple[float, ...]:
        pairs = zip(sensor.channels, sensor.each("scale"), strict=True)
        return tuple(scale * (factor(p) if p["channel"] in ("", channel) else 1.0) for channel, scale in pairs)

    return change(scale=multiplied)
