"""Motion that is known from its recording: of axes that are measured and not asked about.

Instruments tell it where they sit, as they are turned and when they are late; from there it is carried to the body's
origin, put on an even grid of times and smoothed, since its rate of change is needed too.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..plant.sensor import Sensor
from ..plant.vehicle import Vehicle
from ..record.columns import ATTITUDE, SPEEDS, channel_of
from ..record.run import Run

Array = NDArray[np.float64]
ROUND, CLEARLY = 0.05, 6.0  # [rad], or times the noise of a step, by which a jump may miss a turn; choices
SMOOTH_S = 0.8  # [s] over which known motion is smoothed by a local parabola; a choice


def known_motion(run: Run, vehicle: Vehicle, known: NDArray[np.bool_]) -> tuple[Array, NDArray[np.bool_], Array]:
    """Grid of times [s], which of attitude, velocity and acceleration are known, (15,), and these, (T, 15).

    known: axes, shape (6,); one that was not measured is at rest.
    """
    step = float(np.median(np.diff(run.time_s)))
    grid = np.arange(run.time_s[0], run.time_s[-1] + step, step)
    knows, motion = np.zeros(15, dtype=bool), np.zeros((grid.size, 15))
    if not known.any():
        return grid, knows, motion
    angles = [_series(run, vehicle, name, grid) for name in ATTITUDE]
    rates = [_series(run, vehicle, name, grid) for name in SPEEDS[3:]]
    turning = [
        rate if rate is not None else np.zeros(grid.size) if angle is None else np.gradient(angle, step)
        for rate, angle in zip(rates, angles, strict=True)
    ]
    series = [*_at_origin(run, vehicle, np.stack(turning, axis=1), grid), *turning]
    for axis in np.flatnonzero(known):
        if axis > 2:
            knows[axis - 3] = True
            if angles[axis - 3] is not None:
                motion[:, axis - 3] = angles[axis - 3]
        motion[:, 3 + axis], motion[:, 9 + axis] = _smooth(series[axis], step)
        knows[[3 + axis, 9 + axis]] = True
    return grid, knows, motion


def _series(run: Run, vehicle: Vehicle, name: str, grid: Array) -> Array | None:
    """The first recorded column of a channel on a grid of times, as of when it was true."""
    column = next((column for column in run.columns if channel_of(column) == name), None)
    if column is None or (np.isfinite(run.columns[column]).sum() < 2):
        return None
    time, value = run.samples(column)
    sensor = sensor_of(vehicle, column)
    return np.interp(grid, time - (sensor.latency_s if sensor else 0.0), onward(value) if name in ATTITUDE else value)


def onward(angle: Array) -> Array:
    """Recorded angles that go on beyond a turn; of those that range farther it is what they jump by less their pace.

    A jump among jumps, where noise crosses the mark to and fro, tells nothing of that.
    """
    step = np.diff(angle)
    size = np.abs(step)
    if size.max(initial=0.0) <= np.pi:
        return angle
    far = np.r_[True, size > 0.5 * size.max(), True]  # with a jump before the first step and after the last
    jumps = np.flatnonzero(far[1:-1] & ~far[:-2] & ~far[2:])
    turn, noise = 2.0 * np.pi, float(np.median(np.abs(np.diff(step)))) / np.sqrt(max(jumps.size, 1))
    if jumps.size and np.ptp(angle) > turn + CLEARLY * noise:  # else it fits into a turn as everybody has it
        found = float(np.median(np.abs(step[jumps] - 0.5 * (step[jumps - 1] + step[jumps + 1]))))
        if found > turn + max(ROUND, CLEARLY * noise):
            turn = found
    return np.asarray(np.unwrap(angle, period=turn))


def sensor_of(vehicle: Vehicle, column: str) -> Sensor | None:
    """The instrument of a recorded column; None for one that the file does not have."""
    return next((s for s in vehicle.sensors if s.name == vehicle.instrument(column)), None)


def _at_origin(run: Run, vehicle: Vehicle, turning: Array, grid: Array) -> list[Array]:
    """Velocity of the body's origin along its axes: what is measured elsewhere less what turning adds there."""
    found = [_series(run, vehicle, name, grid) for name in SPEEDS[:3]]
    column = next((c for c in run.columns if channel_of(c) in SPEEDS[:3]), "")
    velocity = np.stack([np.zeros(grid.size) if v is None else v for v in found], axis=1)
    sensor = sensor_of(vehicle, column)
    if sensor is not None:
        if all(v is not None for v in found):
            velocity = velocity @ sensor.rotation.T
        velocity = velocity - np.cross(turning, np.array(sensor.position_m)) * [v is not None for v in found]
    return list(velocity.T)


def _smooth(series: Array, step: float) -> tuple[Array, Array]:
    """A series and its rate of change."""
    window = min(2 * int(0.5 * SMOOTH_S / step) + 1, series.size - (series.size + 1) % 2)
    if window < 5:
        return series, np.gradient(series, step)
    from scipy.signal import savgol_filter  # heavy, and only known motion needs it

    smooth, rate = (savgol_filter(series, window, 2, deriv=order, delta=step) for order in (0, 1))
    return smooth, rate
