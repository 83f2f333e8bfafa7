"""A recording of a whole vehicle as the estimators see it: held inputs, measurements in order of time, known motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..effects.coulomb_friction import REVERSAL_M_S
from ..errors import InputError
from ..plant.recorded import check_inputs
from ..plant.vehicle import Vehicle
from ..record.columns import ATTITUDE, MOTION, SPEEDS, channel_of
from ..record.run import TIME, Run
from ..record.toml import meant
from .kernels import Record
from .known import known_motion, onward
from .layout import (
    AXES,
    BUOYED,
    CENTRE,
    FRICTION,
    HULL,
    LATE,
    LATENCY,
    LINEAR,
    LOSS,
    QUADRATIC,
    SENSOR,
    SITE,
    THRUSTER,
    TRIM,
    WATERLINE,
    WEIGHT,
    Hull,
    Layout,
    masses,
)  # fmt: skip
from .motion import gears
from .push import Push, pushes
from .readings import CHANNELS, POSITION, RANGE
from .steps import Drive, Steps, held, plan, thrusts

Array = NDArray[np.float64]
BIN_S, ALMOST = 0.1, 1.2  # over which samples of a channel that come (clearly) faster are averaged: no hull is quicker
MOST = 150_000  # measurements of all runs; beyond, some stretches are looked at, so that memory holds; a choice
JUMP = 0.1  # of an input's range, by which what it pushes jumps: no average goes across that; a choice
STRETCH_S, BEFORE_S = 60.0, 30.0  # [s] of such a stretch at least, and of inputs before it that still act; choices
TELLS = {  # channel -> axes whose motion it tells
    "range_m": (0,), "position_m": (0,), "north_m": (0, 1), "east_m": (0, 1), "depth_m": (2,), "roll_rad": (3,),
    "pitch_rad": (4,), "heading_rad": (5,), **{name: (i,) for i, name in enumerate(SPEEDS)},
    "accel_x_m_s2": (0,), "accel_y_m_s2": (1,), "accel_z_m_s2": (2,),
}  # fmt: skip
STEP_SHARE, STEPS_S = 0.8, (0.02, 0.2)  # of an axis' shortest time; [s] bounds of a step: choices, errors of 0.01 sd
RINGING, PARTS = 0.7, 12  # of a step in which friction turns round, from which none rings; most parts of one: choices
UNTOLD_M_S, DRIFTING_M_S = 0.02, 0.2  # [m/s] deviation of a speed at the start of which nothing tells; guesses
WOUND_S = 0.15  # [s] by which a motion is wound back at most where an instrument is later than was thought; a choice
ANYWHERE_M = 100.0  # [m] how far a place may be from where its first sample has it; a choice
ASKEW = 0.4  # [rad] between the headings at which runs start before one wall; a choice
ANSWERED = 4.5  # deviations of a correlation from which inputs answer the noise of a column
KEPT = 2  # drives of a run: what pushes now, and as is tried beside it
TICK_S = 1e-6  # by which stamps of one time may differ: a recording has so many digits
BEYOND = 1.5  # times the largest input, to which the tables of forces go; a choice
FEWEST = 20  # measurements of a channel below which it says nothing; a choice


@dataclass(frozen=True, eq=False)
class Driven:
    """What drives a run: stamps of changes [s], (I,), inputs of thrusters, (I, K), and angles of fins [rad], (I, F)."""

    stamps: Array
    inputs: Array
    angles: Array

    @cached_property
    def jumps(self) -> Array:
        """Stamps at which an input or angle changes by more than JUMP of its range [s]."""
        table = np.hstack((self.inputs, self.angles))
        far = np.abs(np.diff(table, axis=0)) > JUMP * np.ptp(table, axis=0)
        return np.asarray(self.stamps[1:][far.any(axis=1)])


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
        tables: steady force of what pushes over inputs from -reach to reach, (K, T); reach: (K,).
        time_s, kind, sensor, column, value: of the measurements, (M,).
        start: first guess of place, attitude and velocity, (12,), and its standard deviations.
        wall: distance to the wall ahead of the start [m]; facing: heading [rad] near which one is square to it.
        later: delay of each instrument beyond its nominal one at which measurements are put in order, (S,) [s].
        resting: whether the thrusters have not pushed yet when it begins.
    """

    name: str
    layout: Layout
    asked: NDArray[np.bool_]
    knows: NDArray[np.bool_]
    known: tuple[Array, Array]
    followed: NDArray[np.bool_]
    stamps: Array
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
    _drives: dict[bytes, Drive] = field(default_factory=dict, repr=False)
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
        return replace(self, tied=True, _drives={}) if self.followed.any() else self

    @property
    def switched(self) -> Recorded | None:
        """The run, begun with thrusters that have not pushed yet, or have long; None where none of them lags."""
        if not any(push.lag_s > 0.0 for push in self.layout.pushes):
            return None
        return replace(self, resting=not self.resting, _drives={})

    @property
    def drifting(self) -> Recorded | None:
        """The run, begun less at rest along the axes of whose speed nothing tells; None where all are told of."""
        untold = self.moves & (self.spread[6:12] == UNTOLD_M_S) & (np.arange(6) < 3)
        if not untold.any():
            return None
        spread = self.spread.copy()
        spread[6:12][untold] = DRIFTING_M_S
        return replace(self, spread=spread)

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
        return replace(self, **parts, _drives={})

    def hull(self, p: Array, soft: bool = False) -> Hull:
        """Parameters for the kernels; soft: with dry friction that turns round so slowly that one step follows it."""
        turn, losses = gears(p, self.layout.counts[0]), p[HULL + LOSS : self.layout.starts[1] : THRUSTER]
        key = p[:LINEAR].tobytes() + p[TRIM : TRIM + 4].tobytes()
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
            flow=self.layout.flow, wall=self.wall, facing=self.facing, sonar_m=self.layout.vehicle.sonar_x_m,
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
        return replace(self, later=later, _drives={})

    @cached_property
    def steps(self) -> Steps:
        """Steps of a simulation through the instants at which measurements were true.

        Inputs begin a step where they stay as they are for longer than one; what comes faster is averaged.
        """
        slow = self.stamps.size < 2 or float(np.median(np.diff(self.stamps))) >= self.longest_s
        return Steps(*plan(self.time_s - self.late, self.stamps if slow else self.stamps[:0], self.longest_s))

    @cached_property
    def longest_s(self) -> float:
        """Longest Runge-Kutta step [s]: a share of the shortest time of any axis that moves, at its largest speed."""
        p = self.layout.null
        body, water, _ = masses(p, self.moves)
        fastest = np.full(6, 0.5)  # [m/s, rad/s] where it was not measured; a guess
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
        key = p[HULL:sensors].tobytes()
        if key not in self._drives:
            if len(self._drives) >= KEPT:
                self._drives.clear()
            force, swing, size = thrusts(
                steps.now, steps.length, self.stamps, self.inputs, self.tables, self.reach, p, self.inputs.shape[1],
                self.resting,
            )  # fmt: skip
            angles = held(steps.now, steps.length, self.stamps, self.angles, p, fins + LATE)
            turn = gears(p, self.layout.counts[0])
            self._drives[key] = Drive(force @ turn, swing @ turn, size.copy(), angles, self._along, self.held)
        return self._drives[key]

    @cached_property
    def _along(self) -> Array:
        """Known motion at the start of each step, (N, 15)."""
        grid, values = self.known
        known = np.zeros((self.steps.now.size, 15))
        for i in np.flatnonzero(self.knows):
            known[:, i] = np.interp(self.steps.now, grid, values[:, i])
        return known


def record(
    runs: Sequence[Run], vehicle: Vehicle, axes: Sequence[str] | None = None
) -> tuple[Layout, tuple[Recorded, ...], tuple[str, ...]]:
    """The layout that fits a vehicle and its recordings, the runs, and what is told of columns that are not used.

    axes: that are asked about, of AXES (default: all of whose motion something is told). InputError where nothing
    drives the vehicle, nothing is measured of an axis that is asked about, or an input is of no thruster and one's own
    is missing.
    """
    named = {name for run in runs for name, values in run.columns.items() if np.isfinite(values).any()}
    pushed = pushes(vehicle, named)
    seen = sorted((name for name in named if channel_of(name) in MOTION), key=lambda n: (vehicle.instrument(n), n))
    told_of = {axis for name in seen for axis in TELLS[channel_of(name)]}
    asked = np.zeros(6, dtype=bool)
    for axis in axes or ():
        if axis not in AXES:
            raise InputError(f"no axis '{axis}'{meant(axis, AXES)}")
        if AXES.index(axis) not in told_of:
            raise InputError(f"axis {axis}: nothing that was recorded tells its motion")
        asked[AXES.index(axis)] = True
    if not axes:
        asked[list(told_of)] = True
    speeds = {channel_of(name) for name in seen}
    known = ~asked & bool(axes)
    at_rest = [i for i in np.flatnonzero(known) if SPEEDS[i] not in speeds and (i < 3 or ATTITUDE[i - 3] not in speeds)]
    placed = {i for i in range(3) if asked[i] and SPEEDS[i] in speeds}
    judged = [name for name in seen if _says(channel_of(name), asked, known, placed)]
    if not judged:
        raise InputError("no measurement to fit; expected velocity, attitude or place of an axis that is asked about")
    motion = {name for name in seen if channel_of(name) in (*SPEEDS, *ATTITUDE) and known[TELLS[channel_of(name)][0]]}
    used = [name for name in seen if name in motion or name in judged]
    sensors, followed = tuple(dict.fromkeys(map(vehicle.instrument, used))), frozenset(motion)
    layout = Layout(vehicle, pushed, sensors, tuple(used), followed=followed)
    driving = {push.column for push in pushed} | {fin.column for fin in vehicle.fins}
    notes = [f"column {name} is {'known motion' if name in motion else 'not used'}"
             for name in sorted(named - driving - set(judged)) if name != TIME]  # fmt: skip
    notes += [f"{AXES[i]} was not measured: taken as at rest" for i in at_rest]
    names = [sensor.name for sensor in vehicle.sensors]
    strange = sorted({owner for name in judged if (owner := name.rpartition(".")[0]) and owner not in names})
    missing = [push.column for push in pushed if push.column not in named]
    missing += [t.column for t in vehicle.thrusters if t.name not in {push.name for push in pushed}]
    if missing:
        for run in runs:
            check_inputs(run, vehicle)
    notes += [f"no column {name}: taken as at rest" for name in missing]
    notes += [
        f"{vehicle.path} has no sensor '{name}'{meant(name, names or ['none'])}: taken to sit at the origin"
        for name in strange
    ]
    reach = _reach(runs, pushed)
    tables = np.array([push.table(most) for push, most in zip(pushed, reach, strict=True)]).reshape(len(pushed), -1)
    inputs = [_inputs(run, layout) for run in runs]
    bins, share = _bins(runs, layout, inputs)
    pieces = [piece for run, told in zip(runs, inputs, strict=True) for piece in _stretches(run, told, share)]
    recordings = [_recorded(run, layout, asked, known, reach, tables, told, bins) for run, told in pieces]
    if len(pieces) > len(runs) or any(piece is not run for (piece, _), run in zip(pieces, runs, strict=False)):
        looked_at = sum(float(np.ptp(piece.time_s)) for piece, _ in pieces)
        notes.append(f"a long recording: {len(pieces)} stretches of it, {looked_at:.0f} s in all, are looked at")
    told = {int(c) for run in recordings for c in np.unique(run.column)}
    notes += [f"column {name} is not used: fewer than {FEWEST} samples"
              for c, name in enumerate(used) if c not in told and name in judged]  # fmt: skip
    return layout, _facing_walls(recordings), tuple(notes)


def _reach(runs: Sequence[Run], pushed: Sequence[Push]) -> Array:
    """Input to which the table of each force goes, (K,): beyond what any of its kind was asked for, and misread."""
    most = [max(np.nanmax(np.abs(run.columns[push.column]), initial=0.0) for run in runs if push.column in run.columns)
            for push in pushed]  # fmt: skip
    kinds = [push.kind for push in pushed]
    return np.array([BEYOND * max(m for m, k in zip(most, kinds, strict=True) if k == kind) + 1e-9 for kind in kinds])


def _says(name: str, asked: NDArray[np.bool_], known: NDArray[np.bool_], measured: set[int]) -> bool:
    """Whether a channel tells of axes that are asked about; a place only where their speed is not measured itself."""
    axes = TELLS[name]
    if not known.any():
        return any(asked[a] for a in axes)
    if len(axes) > 1 or name in ("position_m", "range_m"):
        return any(asked[a] and a not in measured for a in axes)
    return bool(asked[axes[0]])


def _recorded(
    run: Run, layout: Layout, asked: NDArray[np.bool_], known: NDArray[np.bool_], reach: Array, tables: Array,
    driven: Driven, bins: dict[str, float],
) -> Recorded:  # fmt: skip
    """One run; driven: of `_inputs`. InputError where it holds nothing that was asked for."""
    parts = [
        (c, *_thinned(*_samples(run, name), bins[name], driven.stamps, driven.jumps + _latency_s(layout, name)))
        for c, name in enumerate(layout.columns)
        if name in run.columns
    ]
    parts = [part for part in parts if part[1].size >= FEWEST]
    if not parts:
        raise InputError(f"run {run.name}: fewer than {FEWEST} samples of {', '.join(layout.columns)}")
    column = np.concatenate([np.full(time.size, c) for c, time, _ in parts])
    time, value = (np.concatenate([part[i] for part in parts]) for i in (1, 2))
    order = np.argsort(time, kind="stable")
    kind = np.array([CHANNELS.index(channel_of(name)) for name in layout.columns])[column]
    sensor = np.array([layout.sensors.index(layout.vehicle.instrument(name)) for name in layout.columns])[column]
    start, spread = _start(layout, run)
    grid, knows, motion = known_motion(run, layout.vehicle, known)
    start[3:12] = np.where(knows[:9], [np.interp(time.min(), grid, motion[:, i]) for i in range(9)], start[3:12])
    told = {TELLS[channel_of(layout.columns[c])][0] for c, *_ in parts if layout.columns[c] in layout.followed}
    followed = np.isin(np.arange(6), list(told))
    measured = {"time_s": time, "kind": kind, "sensor": sensor, "column": column, "value": value}
    recorded = Recorded(
        name=run.name, layout=layout, asked=asked, knows=knows, known=(grid, motion), followed=followed,
        stamps=driven.stamps, inputs=driven.inputs, angles=driven.angles, reach=reach, tables=tables,
        start=start, spread=spread,
        wall=0.0, facing=float(start[5]), later=np.zeros(len(layout.sensors)),
        resting=bool(np.all(np.abs(start[6:12]) <= spread[6:12])),
        **{name: a[order] for name, a in measured.items()},
    )  # fmt: skip
    spread[3:12][recorded.held[:9]] = 0.0
    return recorded


def _stretches(run: Run, driven: Driven, share: float) -> list[tuple[Run, Driven]]:
    """Stretches with a share of a run's time, evenly over it and by its own clock, and what drove it; or the run.

    What goes with the time, as a battery or a clock, is so seen from beginning to end; averages over longer times would
    take lever arms and what is quick for something else.
    """
    first, duration_s = float(run.time_s[0]), float(np.ptp(run.time_s))
    count = max(int(share * duration_s / STRETCH_S), 1)
    length_s = max(share * duration_s / count, STRETCH_S)
    if share >= 1.0 or duration_s <= length_s:
        return [(run, driven)]
    found = []
    for start in first + np.linspace(0.0, duration_s - length_s, count):
        kept = (run.time_s >= start - TICK_S) & (run.time_s <= start + length_s)
        before, after = np.searchsorted(driven.stamps, [start - BEFORE_S, start + length_s])
        acts = slice(max(int(before) - 1, 0), int(after))
        columns = {name: values[kept] for name, values in run.columns.items()}
        name = f"{run.name}_{start - first:.0f}-{start - first + length_s:.0f}s"
        found.append(
            (
                Run(name, run.time_s[kept], columns),
                Driven(driven.stamps[acts], driven.inputs[acts], driven.angles[acts]),
            )
        )
    return found


def _bins(runs: Sequence[Run], layout: Layout, driven: Sequence[Driven]) -> tuple[dict[str, float], float]:
    """Time over which samples of each column are averaged [s], and the share of all time that can be looked at."""
    bins, count = dict[str, float](), 0.0
    for name in layout.columns:
        late_s = _latency_s(layout, name)
        each = [
            (*_samples(run, name), told, late_s) for run, told in zip(runs, driven, strict=True) if name in run.columns
        ]
        bins[name] = min(_bin_s(*samples) for samples in each)
        count += sum(min(time.size, np.ptp(time) / bins[name] + told.jumps.size) for time, _, told, _ in each)
    return bins, min(MOST / max(count, 1.0), 1.0)


def _latency_s(layout: Layout, name: str) -> float:
    """By how much a column is late, as the vehicle file has its instrument [s]."""
    owner = layout.vehicle.instrument(name)
    return sum(sensor.latency_s for sensor in layout.vehicle.sensors if sensor.name == owner)


def _bin_s(time: Array, value: Array, driven: Driven, late_s: float) -> float:
    """Time over which averaging leaves no more that is faster than a parabola than there was, at most BIN_S [s].

    And no longer than inputs are held that answer the noise of these samples: an average would hold what a pilot has
    answered meanwhile.
    """
    stamps, jumps, bin_s, least = driven.stamps, driven.jumps + late_s, BIN_S, scatter(value)
    if _interval_s(stamps) < BIN_S and _answered(time, value, driven):
        bin_s = _interval_s(stamps)
    while bin_s > ALMOST * _interval_s(time) and scatter(_thinned(time, value, bin_s, stamps, jumps)[1]) > least:
        bin_s *= 0.5
    return bin_s


def _answered(time: Array, value: Array, driven: Driven) -> bool:
    """Whether some input steps, at the stamp after a sample, with what is fast in it."""
    stamps, inputs = driven.stamps, np.hstack((driven.inputs, driven.angles))
    fast, at = np.diff(value, 2), np.searchsorted(stamps, time[2:] - TICK_S)
    there = (at > 0) & (at < stamps.size)
    fast, steps = fast[there], inputs[at[there]] - inputs[at[there] - 1]
    size = np.sqrt(np.sum(fast**2) * np.sum(steps**2, axis=0)) + 1e-300
    return bool(np.any(np.abs(fast @ steps) > ANSWERED * size / np.sqrt(max(fast.size, 1))))


def _interval_s(time: Array) -> float:
    return float(np.median(np.diff(time))) if time.size > 1 else np.inf


def _thinned(time: Array, value: Array, bin_s: float, stamps: Array, jumps: Array) -> tuple[Array, Array]:
    """Samples that come faster averaged over bins of a time [s], each from after a stamp of the input up to another.

    A pilot that goes by these samples answers their noise: an average that held it, about a time after the answer,
    would seem to have foreseen it. What averaging takes off where a series curves, half its curvature times the spread
    of the times, is given back. No bin goes across a jump of the inputs, nor is a series curved there: an average of
    what was before and after would seem to have followed at another time.
    """
    if time.size < 3 or bin_s <= ALMOST * _interval_s(time):
        return time, value
    edges = np.union1d(_edges(time[0], time[-1], bin_s, stamps), jumps)
    bins = np.searchsorted(edges, time - TICK_S, side="right")
    count = np.bincount(bins)
    full = count > 0
    at, mean, square = (np.bincount(bins, series)[full] / count[full] for series in (time, value, time * time))
    ahead, behind = at[2:] - at[1:-1], at[1:-1] - at[:-2]
    bend = 2.0 * ((mean[2:] - mean[1:-1]) / ahead - (mean[1:-1] - mean[:-2]) / behind) / (ahead + behind)
    since = np.searchsorted(jumps, at)
    bend[since[2:] > since[:-2]] = 0.0
    mean[1:-1] -= 0.5 * (square - at * at)[1:-1] * bend
    return at, mean


def _edges(first: float, last: float, bin_s: float, stamps: Array) -> Array:
    """Ends of bins: a time apart, each moved to the nearest stamp within half of it."""
    ends = first + bin_s * np.arange(1.0, np.ceil((last - first) / bin_s) + 1.0)
    after = np.searchsorted(stamps, ends)
    around = np.r_[-np.inf, stamps, np.inf]
    before, behind = around[after], around[after + 1]
    near = np.where(ends - before < behind - ends, before, behind)
    return np.unique(np.where(np.abs(near - ends) <= 0.5 * bin_s, near, ends))


def _samples(run: Run, name: str) -> tuple[Array, Array]:
    """Samples of a column; angles go on beyond half a turn."""
    time, value = run.samples(name)
    return time, onward(value) if channel_of(name) in ATTITUDE else value


def _inputs(run: Run, layout: Layout) -> Driven:
    """Stamps at which any input changes, and all inputs and fin angles from there on; what has no column rests."""
    fins = [fin.column for fin in layout.vehicle.fins]
    columns = [push.column for push in layout.pushes] + fins
    has = [name for name in columns if name in run.columns]
    rows = np.any([~np.isnan(run.columns[name]) for name in has], axis=0) if has else np.zeros(run.time_s.size, bool)
    if not rows.any():
        raise InputError(f"run {run.name}: no value of {', '.join(columns)}; nothing drives the vehicle")
    table = np.zeros((int(rows.sum()), len(columns)))
    for i, name in enumerate(columns):
        if name in run.columns:
            values = run.columns[name][rows]
            last = np.maximum.accumulate(np.where(np.isnan(values), -1, np.arange(values.size)))
            table[:, i] = np.where(last < 0, 0.0, values[np.maximum(last, 0)])
    keep = np.r_[True, np.any(np.diff(table, axis=0) != 0.0, axis=1)]
    split = len(layout.pushes)
    parts = (np.ascontiguousarray(part) for part in (table[keep, :split], table[keep, split:]))
    return Driven(run.time_s[rows][keep], *parts)


def _start(layout: Layout, run: Run) -> tuple[Array, Array]:
    """Place, attitude and velocity that the first samples of the quietest channels tell, and how sure that is.

    Of a place as good as nothing is known beforehand, so that a depth cell of another sign, unit or scale is not held
    against where its first sample had put the vehicle.
    """
    start = np.zeros(12)
    spread = np.array([0.0, 0.0, 0.0, 0.05, 0.05, 0.0] + [UNTOLD_M_S] * 3 + [0.05] * 3)
    states = {name: i for i, name in enumerate(("north_m", "east_m", "depth_m", *ATTITUDE, *SPEEDS))}
    told: dict[int, tuple[float, float]] = {}  # state -> spread, first sample
    for name in layout.columns:
        state = states.get(channel_of(name))
        _, value = _samples(run, name) if name in run.columns else (None, np.empty(0))
        if state is not None and value.size:
            first, sure = float(value[0]), max(4.0 * scatter(value), 1e-4)
            told[state] = min(told.get(state, (np.inf, 0.0)), (sure, first))
    for state, (sure, first) in told.items():
        start[state], spread[state] = first, max(ANYWHERE_M, 2.0 * abs(first)) if state < 3 else sure
    return start, spread


def _facing_walls(runs: Sequence[Recorded]) -> tuple[Recorded, ...]:
    """The runs before their walls: one wall for all that start at about one heading.

    A wall stands still, while the first sample of a heading has its noise: of a wall of its own for each run, some
    metres to the side a sonar would tell another heading than the compass.
    """
    found, facing = list[Recorded](), list[float]()
    for run in runs:
        heading, wall = float(run.start[5]), bool((run.kind == RANGE).any() and not (run.kind == POSITION).any())
        near = (other for other in facing if abs(np.angle(np.exp(1j * (heading - other)))) < ASKEW)
        square = next(near, heading) if wall else heading
        facing += [square] if wall else []
        found.append(replace(run, facing=square, wall=_wall(run, square)))
    return tuple(found)


def _wall(run: Recorded, facing: float) -> float:
    """Distance ahead of the start to the wall that the first ranges tell, by where their sonar sits [m]; 0 without."""
    heard, layout = np.flatnonzero(run.kind == RANGE), run.layout
    if not heard.size:
        return 0.0
    at = layout.starts[2] + SENSOR * run.sensor[heard[0]] + SITE
    roll, pitch, heading = run.start[3:6]
    ahead = Rotation.from_euler("ZYX", [heading - facing, pitch, roll]).as_matrix()[0]
    first = run.value[heard[run.sensor[heard] == run.sensor[heard[0]]][:5]]
    return float(np.median(first) * ahead[0] + ahead @ layout.null[at : at + 3])


def scatter(series: Array) -> float:
    """Standard deviation of what is faster than a parabola through neighbours, by third differences, robustly.

    The third difference of white noise has 20 times its variance.
    """
    if series.size < 8:
        return float(np.std(series)) + 1e-12
    third = np.diff(series, 3)
    return float(1.4826 * np.median(np.abs(third)) / np.sqrt(20.0)) + 1e-12
