"""Recordings of a whole vehicle taken in: the layout that fits them, each run as estimators see it, what is told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..plant.recorded import check_inputs
from ..plant.vehicle import Vehicle
from ..record.columns import ATTITUDE, MOTION, SPEEDS, channel_of
from ..record.run import TIME, Run
from ..record.toml import meant
from .driven import Driven, driven
from .known import known_motion, sensor_of
from .layout import AXES, Layout
from .motion import rotation
from .push import Push, pushes
from .readings import CHANNELS
from .recorded import UNTOLD_M_S, Recorded
from .thinned import TICK_S, bins_of, latency_s, samples, scatter, thinned
from .walls import facing_walls

Array = NDArray[np.float64]
STRETCH_S, BEFORE_S = 60.0, 30.0  # [s] of such a stretch at least, and of inputs before it that still act; choices
TELLS = {  # channel -> axes whose motion it tells
    "range_m": (0,), "position_m": (0,), "north_m": (0, 1), "east_m": (0, 1), "depth_m": (2,), "roll_rad": (3,),
    "pitch_rad": (4,), "heading_rad": (5,), **{name: (i,) for i, name in enumerate(SPEEDS)},
    "accel_x_m_s2": (0,), "accel_y_m_s2": (1,), "accel_z_m_s2": (2,),
}  # fmt: skip
ANYWHERE_M = 100.0  # [m] how far a place may be from where its first sample has it; a choice
BEYOND = 1.5  # times the largest input, to which the tables of forces go; a choice
HEAVED_M = 0.05  # [m] by which a craft may be off its waterline when it begins, standard deviation; a guess
STEEP = 1.3  # [rad] of pitch, beyond which roll and heading are hardly told apart; a choice
UPRIGHT = 1.75  # [rad] that no pitch in radians exceeds, an instrument's errors included; a choice
FEWEST = 20  # measurements of a channel below which it says nothing; a choice


def record(
    runs: Sequence[Run], vehicle: Vehicle, axes: Sequence[str] | None = None
) -> tuple[Layout, tuple[Recorded, ...], tuple[str, ...]]:
    """The layout that fits a vehicle and its recordings, the runs, and what is told of columns that are not used.

    axes: that are asked about, of AXES (default: all of whose motion something is told). InputError where nothing
    drives the vehicle, nothing is measured of an axis that is asked about, or an input is of no thruster and one's own
    is missing.
    """
    laid = _laid_out(runs, vehicle, axes)
    layout, notes = laid.layout, list(laid.notes)
    reach = _reach(runs, layout.pushes)
    tables = np.array([push.table(most) for push, most in zip(layout.pushes, reach, strict=True)])
    tables = tables.reshape(len(layout.pushes), -1)
    upright = [_upright(run, driven(run, layout)) for run in runs]
    notes += [
        f"run {run.name} pitches beyond {np.degrees(STEEP):.0f} deg, where roll and heading are one: looked at from "
        f"{piece.time_s[0]:.4g} to {piece.time_s[-1]:.4g} s"
        for run, (piece, _) in zip(runs, upright, strict=True) if piece is not run
    ]  # fmt: skip
    bins, share = bins_of([run for run, _ in upright], layout, [drove for _, drove in upright])
    pieces = [piece for run, drove in upright for piece in _stretches(run, drove, share)]
    recordings = [_recorded(run, layout, laid.asked, laid.known, reach, tables, drove, bins) for run, drove in pieces]
    if any(piece is not run for (piece, _), (run, _) in zip(pieces, upright, strict=False)):
        looked_at = sum(float(np.ptp(piece.time_s)) for piece, _ in pieces)
        notes.append(f"a long recording: {len(pieces)} stretches of it, {looked_at:.0f} s in all, are looked at")
    told = {int(c) for run in recordings for c in np.unique(run.column)}
    notes += [f"column {name} is not used: fewer than {FEWEST} samples"
              for c, name in enumerate(layout.columns) if c not in told and name in laid.judged]  # fmt: skip
    return layout, facing_walls(recordings), tuple(notes)


class _Laid(NamedTuple):
    """A layout, axes asked about and of known motion, (6,), columns that are judged by, and what is told of others."""

    layout: Layout
    asked: NDArray[np.bool_]
    known: NDArray[np.bool_]
    judged: list[str]
    notes: list[str]


def _laid_out(runs: Sequence[Run], vehicle: Vehicle, axes: Sequence[str] | None) -> _Laid:
    """What recordings have of a vehicle. InputError as of `record`."""
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
    moving = known & np.isin(np.arange(6), list(told_of))
    judged = [name for name in seen if _says(channel_of(name), asked, moving, placed)]
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
    return _Laid(layout, asked, known, judged, notes)


def _reach(runs: Sequence[Run], pushed: Sequence[Push]) -> Array:
    """Input to which the table of each force goes, (K,): beyond what any of its kind was asked for, and misread."""
    most = [max(np.nanmax(np.abs(run.columns[push.column]), initial=0.0) for run in runs if push.column in run.columns)
            for push in pushed]  # fmt: skip
    kinds = [push.kind for push in pushed]
    return np.array([BEYOND * max(m for m, k in zip(most, kinds, strict=True) if k == kind) + 1e-9 for kind in kinds])


def _says(name: str, asked: NDArray[np.bool_], known: NDArray[np.bool_], measured: set[int]) -> bool:
    """Whether a channel tells of axes that are asked about.

    Beside axes whose motion is known, a place does only where their speed is not measured itself.
    """
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
    since_s = min(float(run.time_s[0]), *driven.stamps[:1])
    told = {name: _told(run, layout, name, since_s) for name in layout.columns if name in run.columns}
    parts = [
        (c, *thinned(*told[name], bins[name], driven.stamps, driven.jumps + latency_s(layout, name)))
        for c, name in enumerate(layout.columns)
        if name in told
    ]
    parts = [part for part in parts if part[1].size >= FEWEST]
    if not parts:
        raise InputError(f"run {run.name}: fewer than {FEWEST} samples of {', '.join(layout.columns)}")
    column = np.concatenate([np.full(time.size, c) for c, time, _ in parts])
    time, value = (np.concatenate([part[i] for part in parts]) for i in (1, 2))
    order = np.argsort(time, kind="stable")
    kind = np.array([CHANNELS.index(channel_of(name)) for name in layout.columns])[column]
    sensor = np.array([layout.sensors.index(layout.vehicle.instrument(name)) for name in layout.columns])[column]
    start, spread, tellers = _start(told, afloat=layout.vehicle.heave_N_per_m > 0.0)
    grid, knows, motion = known_motion(run, layout.vehicle, known)
    start -= _off_origin(start, layout.vehicle, tellers)
    start[3:12] = np.where(knows[:9], [np.interp(time.min(), grid, motion[:, i]) for i in range(9)], start[3:12])
    axes = {TELLS[channel_of(layout.columns[c])][0] for c, *_ in parts if layout.columns[c] in layout.followed}
    followed = np.isin(np.arange(6), list(axes))
    measured = {"time_s": time, "kind": kind, "sensor": sensor, "column": column, "value": value}
    stamps, inputs, angles = driven.told()
    recorded = Recorded(
        name=run.name, layout=layout, asked=asked, knows=knows, known=(grid, motion), followed=followed,
        stamps=stamps, tick_s=driven.tick_s, inputs=inputs, angles=angles, reach=reach, tables=tables,
        start=start, spread=spread,
        wall=0.0, facing=float(start[5]), later=np.zeros(len(layout.sensors)),
        resting=bool(np.all(np.abs(start[6:12]) <= spread[6:12])),
        **{name: a[order] for name, a in measured.items()},
    )  # fmt: skip
    spread[3:12][recorded.held[:9]] = 0.0
    return recorded


def _told(run: Run, layout: Layout, name: str, since_s: float) -> tuple[Array, Array]:
    """Samples of a column but what an instrument's latency lets it tell of before that time.

    Nobody recorded what drove the vehicle then; a simulated instrument tells of the start instead.
    """
    time, value = samples(run, name)
    known = time - latency_s(layout, name) >= since_s - TICK_S
    return time[known], value[known]


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
    return [
        _stretch(
            run, driven, start, start + length_s, f"{run.name}_{start - first:.0f}-{start - first + length_s:.0f}s"
        )
        for start in first + np.linspace(0.0, duration_s - length_s, count)
    ]


def _stretch(run: Run, driven: Driven, start: float, end: float, name: str) -> tuple[Run, Driven]:
    """What was recorded from start to end [s], and what drove it then and just before."""
    kept = (run.time_s >= start - TICK_S) & (run.time_s <= end)
    before, after = np.searchsorted(driven.stamps, [start - BEFORE_S, end])
    acts = slice(max(int(before) - 1, 0), int(after))
    columns = {name: values[kept] for name, values in run.columns.items()}
    drove = {part: getattr(driven, part)[acts] for part in ("stamps", "inputs", "angles", "before")}
    return Run(name, run.time_s[kept], columns), replace(driven, **drove)


def _upright(run: Run, driven: Driven) -> tuple[Run, Driven]:
    """The longest stretch of a run without steep pitch, and what drove it; or the run.

    Straight up or down, roll and heading are one angle, of which neither has a rate. A sample that stands alone is an
    instrument's.
    """
    steep = [np.zeros(0)]
    for name in run.columns:
        time, pitch = samples(run, name) if channel_of(name) == "pitch_rad" else (np.zeros(0), np.zeros(0))
        size = np.sort(np.abs([pitch[:-2], pitch[1:-1], pitch[2:]]), axis=0)[1] if pitch.size > 2 else pitch[:0]
        if size.max(initial=0.0) < UPRIGHT:
            steep.append(time[1:-1][size > STEEP] if size.size else size)
    if not np.concatenate(steep).size:
        return run, driven
    ends = np.sort(np.concatenate([[run.time_s[0] - 2.0 * TICK_S], *steep, [run.time_s[-1] + 2.0 * TICK_S]]))
    longest = int(np.argmax(np.diff(ends)))
    return _stretch(run, driven, ends[longest] + 2.0 * TICK_S, ends[longest + 1] - 2.0 * TICK_S, run.name)


def _start(series: Mapping[str, tuple[Array, Array]], afloat: bool) -> tuple[Array, Array, dict[int, str]]:
    """Place, attitude and velocity that the first samples of the quietest channels tell, how sure that is, and which.

    A craft that is held at its waterline need not begin there, whether or not anything tells of its heave.

    Of a place as good as nothing is known beforehand, so that a depth cell of another sign, unit or scale is not held
    against where its first sample had put the vehicle.
    """
    start = np.zeros(12)
    spread = np.array([0.0, 0.0, HEAVED_M if afloat else 0.0, 0.05, 0.05, 0.0] + [UNTOLD_M_S] * 3 + [0.05] * 3)
    states = {name: i for i, name in enumerate(("north_m", "east_m", "depth_m", *ATTITUDE, *SPEEDS))}
    told: dict[int, tuple[float, float, str]] = {}  # state -> spread, first sample, column
    for name, (_, value) in series.items():
        state = states.get(channel_of(name))
        if state is not None and value.size:
            first, sure = float(value[0]), max(4.0 * scatter(value), 1e-4)
            told[state] = min(told.get(state, (np.inf, 0.0, "")), (sure, first, name))
    for state, (sure, first, _) in told.items():
        start[state], spread[state] = first, max(ANYWHERE_M, 2.0 * abs(first)) if state < 3 else sure
    return start, spread, {state: name for state, (*_, name) in told.items()}


def _off_origin(start: Array, vehicle: Vehicle, tellers: Mapping[int, str]) -> Array:
    """By how much place and velocity of the instruments that told of the start are off those of the origin, (12,)."""
    off, R = np.zeros(12), np.array(rotation(*start[3:6])).reshape(3, 3)
    for state, name in tellers.items():
        sensor = sensor_of(vehicle, name)
        if sensor and state < 3:
            off[state] = R[state] @ sensor.position_m
        elif sensor and 6 <= state < 9:
            off[state] = np.cross(start[9:12], sensor.position_m)[state - 6]
    return off
