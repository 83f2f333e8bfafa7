"""What a vehicle did along its recordings, by which the priors of effects are scaled."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...rigid.filtered import Filtered, innovations
from ...rigid.places import Sizes
from ...rigid.steps import spike
from ...rigid.tangent import Path
from .model import Model

Array = NDArray[np.float64]
WAVE_STEP_S = 0.2  # [s] of the periodogram: no standing wave in water of a tank is quicker; a choice


def tracks_of(model: Model, found: Sequence[Filtered]) -> list[Array]:
    """States and disturbances along the filtered innovations of each run, (M, 18)."""
    p, out = model.vector(), []
    for run, f in zip(model.fit.runs, found, strict=True):
        out.append(np.empty((run.time_s.size, 18)))
        innovations(run, p, f.gains, track=out[-1])
    return out


def sizes_of(model: Model, found: Sequence[Filtered]) -> Sizes:
    """What the vehicle did, by which priors are scaled."""
    p, tracks = model.vector(), tracks_of(model, found)
    runs = model.fit.runs
    motion = np.concatenate(tracks)
    speed = np.sqrt(np.mean(motion[:, 6:12] ** 2, axis=0)) + 1e-4
    away = np.sqrt(np.mean(np.concatenate([t[:, :6] - t[0, :6] for t in tracks]) ** 2, axis=0)) + 1e-3
    hull = runs[0].hull(p)
    inertia = np.diag(hull.body + hull.water)
    force = np.zeros(6)
    for path in model.fit.paths(p, found):
        steered = path.drive.thrust + _lift(path, hull.body + hull.water)
        force = np.maximum(force, np.sqrt(np.mean(steered**2, axis=0)))
    force = np.maximum(force, 0.2 * inertia * speed)  # [1/s] an axis that no thruster pushes turns round in seconds
    duration = float(max(np.ptp(run.time_s) for run in runs))
    asked = np.max([np.abs(run.inputs).max(axis=0, initial=0.0) for run in runs], axis=0)
    nose, tail = p[runs[0].layout.at(["nose@hull", "tail@hull"])]
    length = float(nose - tail) or 1.0
    waves = tuple(_waves(runs[0].time_s, tracks[0][:, 12 + axis]) for axis in range(3))
    lone = np.max([[spike(column) for column in run.inputs.T] for run in runs], axis=0)
    return Sizes(
        force, speed, away, duration_s=duration, length_m=length, asked=np.maximum(asked, 1e-9),
        lone=lone, waves=waves,
    )  # fmt: skip


def _lift(path: Path, inertia: Array) -> Array:
    """Wrench of all fins along a path, (N, 6): what is missing where they lift and drag nothing."""
    layout, p = path.run.layout, path.p.copy()
    if not layout.vehicle.fins:
        return np.zeros(6)
    p[layout.at([f"{slot}@{fin.name}" for fin in layout.vehicle.fins for slot in ("pressure", "induced_drag")])] = 0.0
    without_fins = path.cause(p)
    assert without_fins is not None
    return -without_fins[0] @ inertia.T


def _waves(time_s: Array, disturbance: Array) -> tuple[float, ...]:
    """Frequencies [rad/s] of the two strongest peaks of a disturbance's periodogram; none of a flat one."""
    grid = np.arange(time_s.min(), time_s.max(), WAVE_STEP_S)
    if grid.size < 50 or not np.any(disturbance):
        return ()
    order = np.argsort(time_s, kind="stable")
    series = np.interp(grid, time_s[order], disturbance[order])
    power = np.abs(np.fft.rfft((series - series.mean()) * np.hanning(grid.size), 4 * grid.size)) ** 2
    rate = 2.0 * np.pi * np.fft.rfftfreq(4 * grid.size, WAVE_STEP_S)
    peaks = 1 + np.flatnonzero((power[1:-1] > power[:-2]) & (power[1:-1] > power[2:]))
    peaks = peaks[rate[peaks] * np.ptp(grid) > 4.0 * np.pi]
    return tuple(float(rate[i]) for i in peaks[np.argsort(power[peaks])[::-1][:2]])
