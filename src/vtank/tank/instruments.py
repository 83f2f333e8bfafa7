"""What the instruments of a vehicle measure, free of error: MuJoCo's own sensors at a site for each of them.

MuJoCo's sensordata is of the beginning of a step, which is just what a record at the times of the steps needs; so are
the accelerations in it, added mass included.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..plant.sensor import Sensor
from ..record.columns import ACCELERATION, RATES, VELOCITY
from .model import HEARD

Array = NDArray[np.float64]
SITE = "vtank/sensor {}"
KINDS = mujoco.mjtSensor
NATIVE = {  # sensor of MuJoCo -> numbers of it
    KINDS.mjSENS_ACCELEROMETER: 3,
    KINDS.mjSENS_GYRO: 3,
    KINDS.mjSENS_VELOCIMETER: 3,
    KINDS.mjSENS_FRAMEPOS: 3,
    KINDS.mjSENS_FRAMEQUAT: 4,
}
TO_EARTH = np.array([1.0, -1.0, -1.0])  # from the world, north, west, up, to north, east, down


def add_sensors(spec: mujoco.MjSpec, body: mujoco.MjsBody, sensors: tuple[Sensor, ...]) -> None:
    """Give every instrument a site, and all of MuJoCo's sensors there, of NATIVE."""
    for sensor in sensors:
        quaternion, name = np.zeros(4), SITE.format(sensor.name)
        mujoco.mju_mat2Quat(quaternion, sensor.rotation.ravel())
        body.add_site(name=name, pos=sensor.position_m, quat=quaternion)
        for kind in NATIVE:
            spec.add_sensor(name=_native(sensor, kind), type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=name)


def _native(sensor: Sensor, kind: mujoco.mjtSensor) -> str:
    """Name of one of MuJoCo's sensors at an instrument's site."""
    return f"{SITE.format(sensor.name)} {kind.name}"


def measured(
    model: mujoco.MjModel, sensors: tuple[Sensor, ...], sensordata: Array, only: str = ""
) -> dict[str, Mapping[str, Array]]:
    """Each instrument's channels without error, by its name and theirs: sensordata (T, nsensordata) -> (T,) [SI].

    only: name of the one that is meant (default: all).
    """
    found = {}
    for sensor in sensors:
        if only in ("", sensor.name):
            starts = [int(model.sensor(_native(sensor, kind)).adr[0]) for kind in NATIVE]
            numbers = [sensordata[:, at : at + width] for at, width in zip(starts, NATIVE.values(), strict=True)]
            found[sensor.name] = _channels(model, sensor, numbers)
    return found


def _channels(model: mujoco.MjModel, sensor: Sensor, numbers: Sequence[Array]) -> Mapping[str, Array]:
    """numbers: of each of NATIVE, (T, width)."""
    accel, gyro, velocity, place, quaternion = numbers
    w, x, y, z = quaternion.T
    ahead = np.array([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)]).T  # x axis, world
    starboard_z, down_z = 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    if sensor.earth_axes:
        starboard = np.array([2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), starboard_z]).T
        down = np.array([2.0 * (x * z + w * y), 2.0 * (y * z - w * x), down_z]).T
        u, v, d = velocity[:, :1], velocity[:, 1:2], velocity[:, 2:]
        velocity = (u * ahead + v * starboard + d * down) * TO_EARTH
    channels = dict(
        zip(
            (*ACCELERATION, *RATES, *VELOCITY),
            np.hstack([accel, gyro, velocity]).T,
            strict=True,
        )
    )
    # earth axes are x north, y east, z down: the world's y and z are turned over
    channels |= {"north_m": place[:, 0], "east_m": -place[:, 1], "depth_m": -place[:, 2]}
    channels["roll_rad"] = np.unwrap(np.arctan2(-starboard_z, -down_z))
    channels["pitch_rad"] = np.arcsin(np.clip(ahead[:, 2], -1.0, 1.0))
    channels["heading_rad"] = np.unwrap(np.arctan2(-ahead[:, 1], ahead[:, 0]))
    if "range_m" in sensor.channels:
        channels["range_m"] = _ranges(model, place, ahead)
    return {name: channels[name] for name in sensor.channels}


def _ranges(model: mujoco.MjModel, places: Array, directions: Array) -> Array:
    """Distance to walls and floor, which stand still, along a direction [m]; NaN where there is nothing."""
    data, geom = mujoco.MjData(model), np.zeros(1, dtype=np.int32)
    mujoco.mj_kinematics(model, data)
    pairs = zip(places, directions, strict=True)
    found = np.array([mujoco.mj_ray(model, data, place, ahead, HEARD, 1, -1, geom) for place, ahead in pairs])
    return np.where(found < 0.0, np.nan, found)
