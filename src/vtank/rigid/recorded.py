"""A recording of a whole vehicle as the estimators see it: held inputs, measurements in order of time, known motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..effects.coulomb_friction import REVERSAL_M_S
from ..record.columns import SPEEDS
from .kernels import Record
from .layout import (
    BUOYED,
    CENTRE,
    FLOWS,
    FRICTION,
    GAIN,
    HULL,
    LAG,
    LATENCY,
    LENT,
    LINEAR,
    LOSS,
    QUADRATIC,
    SENSOR,
    THRUSTER,
    TRIM,
    WATERLINE,
    WEIGHT,
    Hull,
    Layout,
    masses,
)  # fmt: skip
from .motion import gears, lifts
from .readings import CHANNELS
from .steps import TOUCH_S, Drive, Steps, held, plan, smeared, thrust_of

Array = NDArray[np.float64]
STEP_SHARE, STEPS_S = 0.8, (0.02, 0.1)  # of an axis' shortest time; [s] bounds of a step: choices, errors of 0.01 sd
RINGING, PARTS = 0.7, 12  # of a step in which friction turns round, from which none rings; most parts of one: choices
UNTOLD_M_S, DRIFTING_M_S = 0.02, 0.2  # [m/s] deviation of a speed at the start of which nothing tells; guesses
USUAL_M_S = 0.5  # [m/s, rad/s] of a motion that was not measured; a guess
INPUTS_S = 0.049  # [s] of held inputs that are followed step by step; faster ones are averaged over a step; a choice
PHASE = 0.1  # of the time between rows, by which those of a run come early or late of another's; a guess
WOUND_S = 0.15  # [s] by which a motion is wound back at most where an instrument is later than was thought; a choice
KEPT, FORCES = 2, 4  # drives of a run, what pushes now and as is tried beside it, and forces of a thruster: choices


@dataclass(frozen=True)
class Kept:
    """What was worked out of how a run is driven, by the part of the parameters that it goes with."""

    drives: dict[bytes, Drive] = field(default_factory=dict)
    forces: dict[int, dict[bytes, tuple[Array, Array, Array]]] = field(default_factory=dict)


def keep(kept: dict[bytes, Any], key: bytes, value: object, count: int) -> None:
    """Keep something beside at most so many others less one; threads that do so at once only work twice."""
    if len(kept) >= count:
        kept.clear()
    kept[key] = value


@dataclass(frozen=True, eq=False)
class Recorded:
    """One run of a whole vehicle.

    Attributes:
        name: of the run.
        layout: of the parameters.
        asked: axes that are fitted and judged, shape (6,) of bool.
        knows: attitude (3), velocity (6) and acceleration (6) that enter as known motion, shape (15,) of bool.
        known: these over a grid of times [s], shapes (T,) and (T, 15).
        followed: axes of known motion that were measured, (6,) of bool: how they accelerate is known; where they are
            the filter follows, since instruments err.
        tied: whether they are where they were measured to be all the same, as a simulation without a filter needs.
        stamps: of the inputs [s], (I,); inputs of what pushes, (I, K), and angles of fins, (I, F).
        tick_s: time between inputs that are told of at instants [s]; 0 where they never change.
        tables: steady force of what pushes over inputs from -reach to reach, (K, T); reach: (K,).
        time_s, kind, sensor, column, value: of the measurements, (M,).
        start: first guess of place, attitude and velocity, (12,), and its standard deviations.
        wall: distance to the wall ahead of the start [m]; facing: heading [rad] near which one is square to it.
        later: delay of each instrument beyond its nominal one at which measurements are put in order, (S,) [s].
        resting: whether the thrusters have not pushed yet when the first inputs come.
        pushed: a wrench beside that of the thrusters, from stamps [s] on, (I,), and what it is, (I, 6) [N, N m].
        still: axes of which nothing tells that are known motion all the same: they do not move.
        phase_s: by which the rows of inputs of this run came off their stamps, which have it [s].
    """

    name: str
    layout: Layout
    asked: NDArray[np.bool_]
    knows: NDArray[np.bool_]
    known: tuple[Array, Array]
    followed: NDArray[np.bool_]
    stamps: Array
    tick_s: float
    inputs: Array
    angles: Array
    reach: Array
    tables: Array
    time_s: Array
    kind: NDArray[np.int64]
    sensor: NDArray[np.int64]
    column: NDArray[np.int64]
    value: Array
    start: Array
    spread: Array
    wall: float
    facing: float
    later: Array
    resting: bool
    tied: bool = False
    pushed: tuple[Array, Array] | None = None
    still: tuple[int, ...] = ()
    phase_s: float = 0.0
    _kept: Kept = field(default_factory=Kept, repr=False)
    _masses: dict[bytes, tuple[Array, Array, Array]] = field(default_factory=dict, repr=False)

    @cached_property
    def moves(self) -> NDArray[np.bool_]:
        """Axes that the equations of motion move, shape (6,)."""
        return ~self.knows[3:9]

    @property
    def disturbed(self) -> NDArray[np.bool_]:
        """Axes whose acceleration is not all that is known of it, shape (6,)."""
        return np.asarray(self.moves | (False if self.tied else self.followed))

    @cached_property
    def held(self) -> NDArray[np.bool_]:
        """Known motion that the states are set to, shape (15,)."""
        loose = np.zeros(6, dtype=bool) if self.tied else self.followed
        return self.knows & ~np.concatenate([loose[3:], loose, np.zeros(6, dtype=bool)])

    def as_measured(self) -> Recorded:
        """The run with its known motion where it was measured to be."""
        return replace(self, tied=True, _kept=Kept()) if self.followed.any() else self

    @property
    def switched(self) -> Recorded | None:
        """The run, begun with thrusters that have not pushed yet, or have long; None where none of them lags."""
        if not any(push.lag_s > 0.0 for push in self.layout.pushes):
            return None
        return replace(self, resting=not self.resting, _kept=Kept())

    @property
    def usual_s(self) -> float:
        """Standard deviation, beforehand, of `phase_s` [s]; 0 where inputs never change."""
        return PHASE * self.tick_s

    def shifted(self, by_s: float) -> Recorded:
        """The run whose inputs came so much later."""
        return replace(self, stamps=self.stamps + by_s, phase_s=self.phase_s + by_s, _kept=Kept())

    @property
    def drifting(self) -> Recorded | None:
        """The run, begun less at rest along the axes of whose speed nothing tells; None where all are told of."""
        untold = self.moves & (self.spread[6:12] == UNTOLD_M_S) & (np.arange(6) < 3)
        if not untold.any():
            return None
        spread = self.spread.copy()
        spread[6:12][untold] = DRIFTING_M_S
        return replace(self, spread=spread)

    def keeping_still(self, axes: Sequence[int]) -> Recorded:
        """The run of a vehicle that does not move along or about some axes of which nothing tells."""
        knows, start, spread = self.knows.copy(), self.start.copy(), self.spread.copy()
        for i in axes:
            knows[[3 + i, 9 + i]] = True
            start[6 + i] = spread[i] = spread[6 + i] = 0.0
            if i > 2:
                knows[i - 3], start[i] = True, 0.0
        return replace(self, knows=knows, start=start, spread=spread, still=tuple(axes), _kept=Kept())

    def beside(self, p: Array, course: Array) -> Recorded:
        """The run beside what nobody has named: accelerations over its steps, (N, 6), or errors of its readings, (M,).

        p: parameters, of whose masses these are the accelerations [m/s2, rad/s2].
        """
        if course.ndim == 1:
            return replace(self, value=self.value - course, _kept=Kept())
        hull = self.hull(p)
        return replace(self, pushed=(self.steps.now, course @ (hull.body + hull.water).T), _kept=Kept())

    @cached_property
    def record(self) -> Record:
        """The measurements for the kernels."""
        return Record(
            kind=self.kind, sensor=self.sensor, column=self.column, value=self.value, stamp=self.time_s, late=self.late,
            home=self.start[:2], wall=self.wall, facing=self.facing,
        )  # fmt: skip

    def until(self, end_s: float) -> Recorded:
        """The run to a time [s]."""
        return self.keeping(self.time_s <= end_s)

    def keeping(self, kept: NDArray[np.bool_]) -> Recorded:
        """The run with some of its measurements alone, (M,)."""
        if kept.all():
            return self
        parts = {name: getattr(self, name)[kept] for name in ("time_s", "kind", "sensor", "column", "value")}
        return replace(self, **parts, _kept=Kept())

    def hull(self, p: Array, soft: bool = False) -> Hull:
        """Parameters for the kernels; soft: with dry friction that turns round so slowly that one step follows it."""
        turn, losses = gears(p, self.layout.counts[0]), p[HULL + LOSS : self.layout.starts[1] : THRUSTER]
        key = p[:LINEAR].tobytes() + p[TRIM : TRIM + 4].tobytes() + p[LENT].tobytes() + self.moves.tobytes()
        if key not in self._masses:
            self._masses[key] = masses(p, self.moves)
        body, water, inverse = self._masses[key]
        # friction that turned round within a part of a step would set the axis ringing
        slowest = RINGING * self.longest_s * p[FRICTION : FRICTION + 6] * np.diag(inverse)
        often = 1 if soft else int(np.clip(np.ceil(np.max(slowest) / REVERSAL_M_S), 1, PARTS))
        home = self.start[[0, 1, 2, 5]]
        return Hull(
            p=p, counts=self.layout.counts, body=body, water=water, inverse=inverse, home=home, gears=turn,
            losing=bool(losses.any()), creep=np.maximum(REVERSAL_M_S, slowest / often), often=often,
            flow=self.layout.flow.times(p[FLOWS : FLOWS + 6]), wall=self.wall, facing=self.facing,
            sonar_m=self.layout.vehicle.sonar_x_m,
        )  # fmt: skip

    @cached_property
    def late(self) -> Array:
        """Delay of each measurement at which they are put in order, (M,) [s]."""
        return np.asarray((self._delays(self.layout.null) + self.later)[self.sensor])

    def _delays(self, p: Array) -> Array:
        """Of the instruments, (S,) [s]."""
        return p[self.layout.starts[2] :][: SENSOR * len(self.layout.sensors)].reshape(-1, SENSOR)[:, LATENCY]

    def ordered(self, p: Array) -> Recorded:
        """The run, its measurements in the order in which they were true at the delays of p.

        The same run where these are nearly its own: to wind a motion back goes well for a short while only.
        """
        later = self._delays(p) - self._delays(self.layout.null)
        if np.all(np.abs(later - self.later) < WOUND_S):
            return self
        return replace(self, later=later, _kept=Kept())

    @cached_property
    def steps(self) -> Steps:
        """Steps of a simulation through the instants at which measurements were true.

        Inputs begin a step where they stay as they are for longer than one, or as long as most are held; what comes
        faster is averaged.
        """
        many = (self.stamps.size - 1) * min(self.longest_s, INPUTS_S) > np.ptp(self.stamps)
        return Steps(*plan(self.time_s - self.late, self.stamps[:0] if many else self.stamps, self.longest_s))

    @cached_property
    def longest_s(self) -> float:
        """Longest Runge-Kutta step [s]: a share of the shortest time of any axis that moves, at its largest speed."""
        p = self.layout.null
        body, water, _ = masses(p, self.moves)
        fastest = np.full(6, USUAL_M_S)  # [m/s, rad/s] where it was not measured
        for i, name in enumerate(SPEEDS):
            mine = self.kind == CHANNELS.index(name)
            if mine.any():
                fastest[i] = float(np.percentile(np.abs(self.value[mine]), 99.0))
        inertia = np.diag(body + water)
        righting = p[WEIGHT] * (p[CENTRE + 2] - p[BUOYED + 2])
        stiff = np.array([0.0, 0.0, p[WATERLINE], righting, righting, 0.0])
        drag = p[LINEAR : LINEAR + 6] + 2.0 * p[QUADRATIC : QUADRATIC + 6] * fastest
        rates = np.maximum(drag / inertia, np.sqrt(np.maximum(stiff, 0.0) / inertia))
        return float(np.clip(STEP_SHARE / np.max(rates[self.moves], initial=1e-9), *STEPS_S))

    def drive(self, p: Array) -> Drive:
        """What pushes over each step."""
        steps, (_, fins, sensors, _) = self.steps, self.layout.starts
        key, drives = p[HULL:sensors].tobytes(), self._kept.drives
        drive = drives.get(key)
        if drive is None:
            force, swing, size = self._forces(p)
            angles, turn = held(steps.now, steps.length, self.stamps, self.angles, p, fins)
            gear = gears(p, self.layout.counts[0])
            thrust = force @ gear
            if self.pushed is not None:
                since, wrench = self.pushed
                thrust += wrench[np.maximum(np.searchsorted(since, steps.now + TOUCH_S, side="right") - 1, 0)]
            drive = Drive(thrust, swing @ gear, size, angles, turn, self._along, self.held)
            keep(drives, key, drive, KEPT)
        return drive

    def _forces(self, p: Array) -> tuple[Array, Array, Array]:
        """Force of each thruster over each step, half its change, and size of its input, (N, K); see `thrust_of`."""
        steps, made = self.steps, np.empty((3, self.steps.now.size, self.inputs.shape[1]))
        for k in range(made.shape[2]):
            first, kept = HULL + THRUSTER * k, self._kept.forces.setdefault(k, {})
            key = p[first : first + THRUSTER].tobytes()
            of = kept.get(key)
            if of is None:
                table, reach = self.tables[k], self.reach[k]
                of = thrust_of(k, steps.now, steps.length, self.stamps, self.inputs, table, reach, p, self.resting)
                keep(kept, key, of, FORCES)
            made[..., k] = of
        return made[0], made[1], made[2]

    @cached_property
    def rough(self) -> Array:
        """How much each axis may be off in speed as nobody knows when inputs turn between rows, (N, 6).

        Growth of its variance over each step [SI per s] by the file's numbers, where inputs turn at instants as far off
        as rows lie apart. How far a force turns is half its third difference: that of a step is the step, that of what
        goes smoothly through the rows nothing. What lags comes in later. A fin's force is of the flow from ahead.
        """
        p, steps, fins = self.layout.null, self.steps, self.layout.starts[1]
        force = np.empty_like(self.inputs)
        for k in range(force.shape[1]):
            place = np.linspace(-self.reach[k], self.reach[k], self.tables[k].size)
            force[:, k] = np.interp(self.inputs[:, k], place, self.tables[k]) * p[HULL + THRUSTER * k + GAIN]
        rough, lags = self._off(force @ gears(p, self.layout.counts[0])), p[HULL + LAG : fins : THRUSTER]
        smeared(steps.length, rough, float(lags.mean()) if lags.size else 0.0)
        return rough + self._off(self.angles @ lifts(p, fins, self.angles.shape[1]), self._ahead)

    def _off(self, wrench: Array, ahead: Array | float = 1.0) -> Array:
        """As `rough`, of a wrench at the stamps, (I, 6), over the square of a speed there, (I,) [m/s]."""
        steps, (after, before) = self.steps, (self.steps.now + self.steps.length, self.steps.now)
        turn = 0.5 * np.diff(np.pad(wrench, ((1, 1), (0, 0)), mode="edge"), 3, axis=0)
        turn = turn * (np.broadcast_to(ahead, self.stamps.shape)[1:, None] ** 2)
        apart = np.minimum(np.diff(self.stamps), self.tick_s)
        speeds = turn @ self.hull(self.layout.null).inverse.T * self.moves * apart[:, None]
        grown = np.cumsum(np.vstack([np.zeros(6), speeds**2]), axis=0)
        late, early = ([np.interp(t, self.stamps, g) for g in grown.T] for t in (after, before))
        return np.ascontiguousarray(np.subtract(late, early).T / steps.length[:, None])

    @cached_property
    def _ahead(self) -> Array:
        """Speed ahead at the stamps as it was measured, (I,) [m/s]."""
        mine = self.kind == CHANNELS.index(SPEEDS[0])
        if not mine.any():
            return np.full(self.stamps.size, USUAL_M_S)
        return np.interp(self.stamps, self.time_s[mine], self.value[mine])

    @cached_property
    def _along(self) -> Array:
        """Known motion at the start of each step, (N, 15)."""
        grid, values = self.known
        known = np.zeros((self.steps.now.size, 15))
        for i in np.flatnonzero(self.knows):
            known[:, i] = np.interp(self.steps.now, grid, values[:, i])
        return known


def relaid(layout: Layout, runs: Sequence[Recorded], **changes: Any) -> tuple[Layout, tuple[Recorded, ...]]:
    """A layout with changes, and the runs in it."""
    layout = replace(layout, **changes)
    return layout, tuple(replace(run, layout=layout, _kept=Kept()) for run in runs)
