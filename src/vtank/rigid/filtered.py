"""Noise, what a filter at a noise leaves of a run, and how work on several cores, and memory, is shared out."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .kalman import Told, Way, kalman
from .kernels import SIZE, Gains, simulate
from .known import SMOOTH_S
from .recorded import Recorded

Array = NDArray[np.float64]
THREADS = 2  # that share simulations out; each is computed alike on any number
ASIDE_M = 0.01  # [m] by which a wall is moved to see what that does; a choice
TINY = 1e-12
FAR = 4.0  # deviations beyond which a measurement counts less and less; a choice
REWEIGHTED = 4  # times that the place of a wall is sought; a choice
PUNCTUAL = 0.01  # share of the time between rows below which inputs turn when they should; a choice
STILL = 1e-4  # [m/s2, rad/s2] below which a disturbance is none beside that of any water; a choice


@dataclass(frozen=True)
class Noise:
    """White error of each column, (C,) [its unit squared]; disturbance of each axis, (6,) [m/s2, rad/s2], memories [s].

    slow, slow_s: deviation [its unit] and memory [s] of the slow error of each column, (C,); none by default.
    flows: whether the first three are speeds of the water north, east, and down instead [m/s], which push by the drag.
    timing: deviation of when inputs turn between rows, over the time between these; see `Recorded.rough`.
    """

    variance: Array
    sigma: Array
    memory_s: Array = field(default_factory=lambda: np.full(6, 2.0))
    slow: Array = field(default_factory=lambda: np.zeros(1))
    slow_s: Array = field(default_factory=lambda: np.ones(1))
    flows: bool = False
    timing: float = 0.0

    @property
    def even(self) -> Noise:
        """Without slow errors."""
        return replace(self, slow=np.zeros_like(self.variance), slow_s=np.ones_like(self.variance))

    @property
    def errors(self) -> Array:
        """Variance of all errors of each column, (C,) [its unit squared]."""
        return np.asarray(self.variance + self.slow**2)

    @property
    def quiet(self) -> bool:
        """Whether nothing of it is remembered: no disturbance, no slow error."""
        return not (self.sigma > STILL).any() and not self.slow.any()

    def like(self, other: Noise) -> bool:
        """Whether disturbances that are any, memories, and timing are within a factor of two of the other's."""
        mine, its = (np.maximum(noise.sigma, STILL) for noise in (self, other))
        size, memory = np.log2(mine / its), np.log2(self.memory_s / other.memory_s)
        any_is = np.maximum(mine, its) > STILL
        near = bool(np.all(np.abs(size) < 1.0) and np.all(np.abs(memory[any_is]) < 1.0))
        early = np.log2(max(self.timing, PUNCTUAL) / max(other.timing, PUNCTUAL))
        return near and abs(early) < 1.0 and self.flows == other.flows


@dataclass(frozen=True, eq=False)
class Left:
    """What a filter leaves of one run.

    wall: what moving the wall ahead does to the innovations, (M,) [per m].
    """

    told: Told
    wall: Array

    @property
    def innovation(self) -> Array:
        """Innovations, (M,)."""
        return np.asarray(self.told.innovation)

    @property
    def variance(self) -> Array:
        """Their variances, (M,)."""
        return np.asarray(self.told.variance)

    @cached_property
    def aside(self) -> Array:
        """Direction of the innovations over their deviations that the place of the wall decides, (M,), of length 1.

        Nobody measures from where a recording begins to the wall, and each has a place of its own: what lies along this
        tells nothing of a model.
        """
        way = self.white(self.wall)
        return np.asarray(way / max(float(np.linalg.norm(way)), TINY))

    @property
    def root(self) -> Array:
        """Deviation of the innovations, (M,)."""
        return np.asarray(np.sqrt(self.variance))

    @property
    def z(self) -> Array:
        """Innovations over their deviations, (M,), the wall where they have it."""
        return self.unmoved(self.white(self.innovation))

    def white(self, e: Array) -> Array:
        """Innovations, or what changes them, (M,), over their deviations."""
        return np.asarray(e / self.root)

    def unmoved(self, z: Array) -> Array:
        """Residuals, (M,), at the place of the wall that makes the sum of their Huber measures the least.

        By least squares weighted anew. Holland, Welsch, Commun. Stat. A 6 (1977).
        """
        for _ in range(REWEIGHTED if self.wall.any() else 0):
            weighed = self.aside * np.minimum(1.0, FAR / np.maximum(np.abs(z), FAR))
            z = z - self.aside * (weighed @ z) / (weighed @ self.aside)
        return z


@dataclass(frozen=True, eq=False)
class Filtered(Left):
    """Of one run at parameters p: what the filter leaves, its gains, and its path, linearised.

    judged: measurements by which a model is judged, (M,): a partial likelihood, of these given all before them. Those
    of known motion tell the filter where the vehicle is, but nobody asked what they say of the model.
    Cox, Biometrika 62 (1975).
    """

    p: Array
    gains: Gains
    way: Way
    judged: NDArray[np.bool_]


def shaken(noise: Noise, found: Sequence[Filtered]) -> Array:
    """Deviation of the disturbance of each axis as an acceleration [m/s2, rad/s2], (6,), over what was filtered."""
    if not noise.flows:
        return noise.sigma
    stir = np.concatenate([f.gains.stir for f in found])
    water = np.mean(np.sum((stir * noise.sigma[:3]) ** 2, axis=2), axis=0)
    return np.asarray(np.sqrt(water + np.where(np.arange(6) < 3, 0.0, noise.sigma) ** 2))


def bent(z: Array) -> Array:
    """Residuals whose square is Huber's: deviations as they are up to FAR, beyond it growing as their root.

    A spike then tells of the instrument, and a model that is far off is still told from one that is farther.
    Huber, Ann. Math. Stat. 35 (1964).
    """
    size = np.abs(z)
    return np.asarray(np.where(size <= FAR, z, np.sign(z) * np.sqrt(FAR * (2.0 * size - FAR) * (size > FAR))))


def share(work: Sequence[Callable[[], Any]]) -> list[Any]:
    """Results of calls that numba runs without Python's lock, in their order."""
    if len(work) < 2:
        return [call() for call in work]
    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(lambda call: call(), work))


def give_back() -> None:
    """Hand memory that is free back to the system: glibc keeps it, in holes between what is in use."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim:
        trim(0)


def _way(run: Recorded) -> Way:
    steps, size = run.steps.now.size, run.time_s.size
    return Way(np.empty((steps + 1, SIZE)), np.empty((size, SIZE)), np.empty((steps, 12, 12)), np.empty((size, SIZE)))


def memories(run: Recorded, noise: Noise) -> Array:
    """Of the disturbance of each axis [s], (6,); of known motion it is what smoothing leaves of instruments' errors."""
    return np.where(run.moves, noise.memory_s, 0.5 * SMOOTH_S)


def _gains(run: Recorded, noise: Noise) -> tuple[Gains, Array]:
    """Gains to fill, at a noise, and the deviations of its slow errors, (S,)."""
    has = np.broadcast_to(noise.slow > 0.0, noise.variance.shape)
    which = np.where(has, np.cumsum(has) - 1, -1)
    of, stir = np.empty((run.time_s.size, SIZE + has.sum())), np.zeros((run.steps.now.size * noise.flows, 6, 3))
    gains = Gains(of, memories(run, noise), which, noise.slow_s[has], stir)
    return gains, noise.slow[has]


def free(run: Recorded) -> Gains:
    """Of a pure simulation, which follows nothing that was measured."""
    none = np.full(len(run.layout.columns), -1)
    return Gains(np.zeros((run.time_s.size, SIZE)), np.ones(6), none, np.empty(0), np.zeros((0, 6, 3)))


def filtered(run: Recorded, p: Array, noise: Noise) -> Filtered:
    """Extended Kalman filter along a run; InputError where the motion diverges."""
    size, way, (gains, slow) = run.time_s.size, _way(run), _gains(run, noise)
    told, wall = Told(*np.empty((5, size))), np.zeros(size)
    kalman(
        run.hull(p), run.hull(p, soft=True), run.start, run.spread, run.steps, run.record, run.drive(p),
        noise.variance[run.column], noise.sigma * run.disturbed, slow, noise.timing**2 * run.rough, gains, way, told,
    )  # fmt: skip
    innovation = told.innovation
    if not np.isfinite(innovation).all():
        lost = run.time_s[~np.isfinite(innovation)].min()
        raise InputError(f"run {run.name}: the simulation diverges at {lost:.4g} s; are units and signs right?")
    if run.wall:
        wall = (innovations(replace(run, wall=run.wall + ASIDE_M), p, gains) - innovation) / ASIDE_M
    return Filtered(told, wall, p, gains, way, run.layout.judged[run.column])


def innovations(
    run: Recorded, p: Array, gains: Gains, *, track: Array | None = None, restart: Array | None = None
) -> Array:
    """Measured less predicted, (M,). See `kernels.simulate`."""
    out, none = np.empty(run.time_s.size), np.empty((0, SIZE))
    simulate(
        run.hull(p),
        run.start,
        run.steps,
        run.record,
        run.drive(p),
        gains,
        none if restart is None else restart,
        out,
        none if track is None else track,
    )
    return out


def followed(run: Recorded, p: Array, f: Filtered) -> tuple[Way, Array]:
    """The path at other parameters with the gains of a filter, and the innovations along it."""
    told, way, none = Told(*np.empty((5, run.time_s.size))), _way(run), np.empty(0)
    kalman(
        run.hull(p), run.hull(p, soft=True), run.start, none, run.steps, run.record, run.drive(p), none, np.zeros(6),
        np.zeros(f.gains.slow_s.size), np.empty((0, 6)), f.gains, way, told,
    )  # fmt: skip
    return way, told.innovation
