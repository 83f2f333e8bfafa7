"""Effects of one sensor: late, turned, elsewhere, off, in other units, or by a clock of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...plant.sensor import Sensor, matrix_of
from ...plant.vehicle import Vehicle
from .effect import Number, PlacedEffect, Values, part, with_part

ANGLE, ARM = (-3.2, 3.2), (-100.0, 100.0)  # [rad], [m] admissible
GYRO = {"roll": "roll_rate_rad_s", "pitch": "pitch_rate_rad_s", "yaw": "yaw_rate_rad_s"}
VELOCITY = ("surge_m_s", "sway_m_s", "heave_m_s")
ACCELEROMETER = {axis: f"accel_{axis}_m_s2" for axis in "xyz"}


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


def rotated(sensor: Sensor, p: Values) -> tuple[float, float, float]:
    """Roll, pitch and yaw [deg] of a sensor that is turned in its own axes from where the file has it."""
    turn = sensor.rotation @ matrix_of(np.array([p["roll"], p["pitch"], p["yaw"]]))
    angles = np.arctan2(turn[2, 1], turn[2, 2]), -np.arcsin(np.clip(turn[2, 0], -1.0, 1.0)), np.arctan2(*turn[1::-1, 0])
    roll, pitch, yaw = np.degrees(angles)
    return float(roll), float(pitch), float(yaw)


def displaced(sensor: Sensor, p: Values) -> tuple[float, float, float]:
    """Place [m] of a sensor that sits elsewhere."""
    x, y, z = sensor.position_m
    return x + p["x"], y + p["y"], z + p["z"]


SENSORS = (
    PlacedEffect(
        "sensor_latency",
        "sensor",
        "What it measures is recorded late.",
        "z(t) tells of t - d",
        (Number("d", ("_s",), "more latency", low=0.0, high=60.0, usual=lambda _: 0.3),),
        changes=change(latency_s=lambda sensor, p: sensor.latency_s + p["d"]),
    ),
    PlacedEffect(
        "sensor_scale",
        "sensor",
        "All that it reads, or one channel, is too large by a factor.",
        "z -> (1 + s) z",
        (Number("s", ("",), "relative error", low=-10.0, high=10.0, usual=lambda _: 0.1),),
        text="channel",
        changes=scaled(lambda p: 1.0 + p["s"]),
    ),
    PlacedEffect(
        "wrong_unit",
        "sensor",
        "It is recorded in a unit of its own.",
        "z -> factor z",
        (Number("factor", ("",), "its unit in SI, inverted", usual=lambda _: 1.0 / 0.3048, shape=True),),
        text="channel",
        changes=scaled(lambda p: p["factor"]),
    ),
    PlacedEffect(
        "wrong_sign",
        "sensor",
        "A channel, or all, has the other sign.",
        "z -> -z",
        text="channel",
        changes=scaled(lambda p: -1.0),
    ),
    PlacedEffect(
        "earth_axes",
        "sensor",
        "Velocity is recorded along north, east and down instead of the body's axes.",
        "(u, v, w) -> R (u, v, w)",
        channels=VELOCITY,
        changes=change(earth_axes=lambda sensor, p: True),
    ),
    PlacedEffect(
        "clock_skew",
        "sensor",
        "Its clock runs slow.",
        "z(t) tells of t (1 + s)",
        (Number("s", ("",), "relative drift", low=-0.1, high=0.1, usual=lambda _: 0.005),),
        changes=change(clock_skew=lambda sensor, p: sensor.clock_skew + p["s"]),
    ),
    PlacedEffect(
        "clock_offset",
        "sensor",
        "Its clock is ahead of the others', which looks late, or behind.",
        "z(t) tells of t - o",
        (Number("o", ("_s",), "by which it is ahead", low=-600.0, high=600.0, usual=lambda _: 0.4),),
        changes=change(clock_offset_s=lambda sensor, p: sensor.clock_offset_s + p["o"]),
    ),
    PlacedEffect(
        "sensor_rotated",
        "sensor",
        "It is mounted at other angles than the vehicle file has.",
        "R -> R R(roll, pitch, yaw)",
        tuple(
            Number(axis, ("_rad",), f"{axis} in its own axes", 0.0, *ANGLE, usual=lambda _: 0.15)
            for axis in ("roll", "pitch", "yaw")
        ),
        changes=change(rotation_deg=rotated),
    ),
    PlacedEffect(
        "sensor_displaced",
        "sensor",
        "It sits elsewhere than the vehicle file has it.",
        "r -> r + (x, y, z)",
        tuple(
            Number(axis, ("_m",), f"along the body's {axis}", 0.0, *ARM, usual=lambda s: 0.05 * s.hull)
            for axis in "xyz"
        ),
        changes=change(position_m=displaced),
    ),
    PlacedEffect(
        "gyro_bias",
        "sensor",
        "A gyro turns where nothing turns.",
        "z -> z + b",
        tuple(
            Number(axis, ("_rad_s",), f"bias in {axis}", 0.0, -10.0, 10.0, name, usual=lambda _: 0.02)
            for axis, name in GYRO.items()
        ),
        channels=tuple(GYRO.values()),
        changes=biased(GYRO),
    ),
    PlacedEffect(
        "accelerometer_bias",
        "sensor",
        "An accelerometer reads what is not there.",
        "z -> z + b",
        tuple(
            Number(x, ("_m_s2",), f"bias along {x}", 0.0, -100.0, 100.0, name, usual=lambda _: 0.1)
            for x, name in ACCELEROMETER.items()
        ),
        channels=tuple(ACCELEROMETER.values()),
        changes=biased(ACCELEROMETER),
    ),
    PlacedEffect(
        "magnetometer_bias",
        "sensor",
        "The heading is off by an angle: declination, or iron nearby.",
        "heading + b",
        (Number("b", ("_rad",), "error of the heading", low=-3.2, high=3.2, usual=lambda _: 0.15),),
        channels=("heading_rad",),
        changes=biased({"b": "heading_rad"}),
    ),
    PlacedEffect(
        "depth_offset",
        "sensor",
        "The depth sensor was set to zero elsewhere.",
        "depth + o",
        (Number("o", ("_m",), "error of the depth", low=-100.0, high=100.0, usual=lambda _: 0.3),),
        channels=("depth_m",),
        changes=biased({"o": "depth_m"}),
    ),
    PlacedEffect(
        "sonar_multipath",
        "sensor",
        "Now and then an echo by way of surface or floor is taken for the wall, and reads long.",
        "range + extra with probability p",
        (
            Number("p", ("",), "probability per ping", low=0.0, high=1.0, usual=lambda _: 0.05, shape=True),
            Number("extra", ("_m",), "excess path", low=0.0, high=100.0, usual=lambda _: 0.5),
        ),
        channels=("range_m",),
        changes=change(echo=lambda sensor, p: (p["extra"], p["p"])),
    ),
    PlacedEffect(
        "sonar_offset",
        "sensor",
        "The sonar measures from a point that is not where the file has it.",
        "range + o",
        (Number("o", ("_m",), "error of the range", low=-100.0, high=100.0, usual=lambda _: 0.1),),
        channels=("range_m",),
        changes=biased({"o": "range_m"}),
    ),
)
