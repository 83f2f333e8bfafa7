"""A run as the estimators see it: one held input, and every sample of range, position and speed in time order."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..channels import channels
from ..errors import InputError
from ..plant.plant import Plant
from ..plant.surge import STANDOFF, SURGE
from ..record.columns import MOTION, channel_of, column
from ..record.manifest import DataSetWarning
from ..record.repeats import own_readings
from ..record.run import INPUTS, Run
from .kernels import Record, Steps

RANGE, POSITION, SPEED = 0, 1, 2
CHANNELS = {row.name: kind for kind, row in enumerate(channels(SURGE))}
PAUSE_SAMPLES, PAUSE_S = 100, 10.0  # [sampling periods, s] without a row beyond which recording had stopped; choices
BEYOND = 1e9  # [m, m/s, N, rev/s] what no vehicle reaches, while squares of it are still numbers; a choice
FEWEST = 50  # rows with a measurement of a stretch between pauses that is kept: five seconds at 10 Hz; a choice


@dataclass(frozen=True, eq=False)
class Observed:
    """Input and measurements of one run, for the compiled kernels.

    Attributes:
        name: the run's name.
        input_name: "n_rev_s", "command" or "thrust_N".
        input_time_s: stamps of the input, shape (I,).
        input: input values, held from each stamp to the next, shape (I,).
        time_s: stamps of the measurements, ascending, shape (M,).
        value: measurements [m or m/s], shape (M,).
        kind: channel of each, its place in the plant's table, here RANGE, POSITION or SPEED, shape (M,).
        lone: how far each input value that stands alone lies off, 0 where it does not (default everywhere), shape (I,).
        plant: whose inputs and measurements these are.
        straight: whether the input went straight from sample to sample; then `input` holds the mean over each step.
        loud: the disturbance in this run over what it is in all of them [-].
        thinned: whether readings between these were left out, to which a controller may have answered all the same.
    """

    name: str
    input_name: str
    input_time_s: np.ndarray
    input: np.ndarray
    time_s: np.ndarray
    value: np.ndarray
    kind: np.ndarray
    lone: np.ndarray = field(default_factory=lambda: np.zeros(0))
    plant: Plant = SURGE
    straight: bool = False
    loud: float = 1.0
    thinned: bool = False

    def __post_init__(self) -> None:
        """Fill in `lone`; InputError where there is no input or no measurement: no kernel can step through nothing."""
        if self.time_s.size == 0 or self.input.size == 0:
            missing = "measurement" if self.time_s.size == 0 else f"value of {self.input_name}"
            raise InputError(f"run '{self.name}': no {missing}, expected at least one")
        if self.lone.shape != self.input.shape:
            object.__setattr__(self, "lone", np.zeros(self.input.shape))

    def __repr__(self) -> str:
        """The run's name and what was recorded."""
        names = ", ".join(channels(self.plant)[kind].name for kind in self.first)
        return f"Observed({self.name}: {self.input.shape[0]} of {self.input_name}, {self.time_s.size} of {names})"

    @cached_property
    def record(self) -> Record:
        """The same for the compiled kernels."""
        stamp, reading, lone, time, value = (
            np.ascontiguousarray(a, dtype=float)
            for a in (self.input_time_s, self.input, self.lone, self.time_s, self.value)
        )
        return Record(stamp, reading, lone, time, value, np.ascontiguousarray(self.kind, dtype=np.int64), self.coloured)

    @cached_property
    def plans(self) -> dict[tuple[float, ...], Steps]:
        """Step plans of this run, by the delays they were made for."""
        return {}

    @cached_property
    def residuals(self) -> dict[tuple[bytes | None, ...], np.ndarray]:
        """Its last simulation's errors, by the model they are of."""
        return {}

    @cached_property
    def has_position(self) -> bool:
        """Whether any channel fixes the hull's place, and not only its speed."""
        return bool(np.any(self.placed))

    @cached_property
    def placed(self) -> np.ndarray:
        """Which measurements fix the hull's place, shape (M,) of bool: those of channels that tell a place."""
        places = {axis.place for axis in self.plant.axes}
        return np.array([row.state in places for row in channels(self.plant)])[self.kind]

    @cached_property
    def coloured(self) -> np.ndarray:
        """1 where a measurement's error may have a coloured part, else 0, shape (M,).

        That of a speed over ground, in which the water's own drift is, counts only where no place is measured.
        """
        some = np.array([row.coloured for row in channels(self.plant)])[self.kind]
        return (some & (self.placed | (not self.has_position))).astype(float)

    @cached_property
    def first(self) -> dict[int, float]:
        """First value of each channel that was measured."""
        kinds, index = np.unique(self.kind, return_index=True)
        return {int(kind): float(self.value[k]) for kind, k in zip(kinds, index, strict=True)}

    @cached_property
    def standoff(self) -> float | None:
        """Distance from sonar to wall where x = 0, at the start of the run [m]; None where there is no sonar."""
        if self.plant is not SURGE or RANGE not in self.first:
            return None
        opening = self.value[self.kind == RANGE][:5]  # a median of five, since any ping may be an outlier
        return float(np.median(opening)) + self.first.get(POSITION, 0.0)

    def start(self, p: np.ndarray) -> np.ndarray:
        """First guess of the states at the first measurement, shape (S,); 0 where none is told.

        p: parameters, shape (P,); or (P, L), and the states are of shape (S, L).
        """
        start, rows = np.zeros((len(self.plant.states), *p.shape[1:])), channels(self.plant)
        for kind, value in self.first.items():
            if (state := rows[kind].state) is not None:
                start[state] = rows[kind].begins(value, p)
        return start

    def told(self, lagging: Sequence[str]) -> tuple[int, ...]:
        """Indices of the initial states to be found: those that a channel tells, all speeds, and these lagging ones."""
        plant, rows = self.plant, channels(self.plant)
        seen = {state for kind in self.first if (state := rows[kind].state) is not None}
        return tuple(sorted(seen | {a.speed for a in plant.axes} | {plant.states.index(name) for name in lagging}))

    def here(self, p: np.ndarray) -> np.ndarray:
        """A copy of parameters p, shape (P,), with what is the run's own: its stand-off."""
        p = p.copy()
        if self.standoff is not None:
            p[STANDOFF] = self.standoff
        return p


def stretches(runs: Sequence[Run]) -> tuple[Run, ...]:
    """The runs, cut where recording paused: what the vehicle did meanwhile, nobody knows, and its state is new after.

    Each has a clock of its own, which begins with its first row. A stretch is named after the run and its span; short
    ones are left out. Readings that a logger wrote again are left out, too. A DataSetWarning says so.
    """
    return tuple(part for run in runs for part in _stretches(_read_once(run)))


def _read_once(run: Run) -> Run:
    """The run without what was not read: a reading that is written again says nothing new, and is old by then."""
    columns, shares = dict(run.columns), list[str]()
    for name in (name for name in run.columns if channel_of(name) in MOTION):
        values = run.columns[name].copy()
        there = np.flatnonzero(~np.isnan(values))
        own = own_readings(values[there])
        if not own.all():
            values[there[~own]] = np.nan
            columns[name] = values
            shares.append(f"{np.mean(~own):.0%} of {name}")
    if not shares:
        return run
    warnings.warn(
        f"run {run.name}: readings written again by the logger are left out: {', '.join(shares)}",
        DataSetWarning,
        stacklevel=4,
    )
    return replace(run, columns=columns)


def _stretches(run: Run) -> list[Run]:
    step = np.diff(run.time_s)
    ends = np.flatnonzero(step > PAUSE_S) + 1
    ends = ends[step[ends - 1] > PAUSE_SAMPLES * np.median(step)] if ends.size else ends
    if ends.size == 0:
        return [run.from_start()]
    rows = np.split(np.arange(run.time_s.size), ends)
    none = np.zeros(run.time_s.size, dtype=bool)
    driven, seen = (np.any([none, *(~np.isnan(run.columns[name]) for name in names)], axis=0) for names in _both(run))
    kept = [part for part in rows if driven[part].any() and seen[part].sum() >= FEWEST] or [max(rows, key=len)]
    spans = [f"{run.time_s[part[0]]:.10g}-{run.time_s[part[-1]]:.10g}s" for part in kept]
    warnings.warn(
        f"run {run.name}: nothing was recorded for {step[ends - 1].max():.4g} s; taken as stretches with initial "
        f"states of their own: {', '.join(spans)}" + f"; {len(rows) - len(kept)} short ones left out" * (kept != rows),
        DataSetWarning,
        stacklevel=4,
    )
    found = []
    for part, span in zip(kept, spans, strict=True):
        columns = {name: values[part] for name, values in run.columns.items()}
        found.append(Run(f"{run.name}_{span}", run.time_s[part], columns).from_start())
    return found


def _both(run: Run) -> tuple[list[str], list[str]]:
    """What drove the vehicle and what it did: the columns of a run along one axis, or of a whole vehicle."""
    if set(INPUTS) & run.columns.keys():
        return [run.input], list(run.outputs)
    driving = [name for name in run.columns if (found := column(name)) and found.role == "input"]
    return driving, [name for name in run.columns if channel_of(name) in MOTION]


def observe(run: Run) -> Observed:
    """Collect a run's input and measurements; InputError where it has nothing to fit.

    Time counts from the run's first row, wherever the recorder's clock began: laws and effects may depend on it.
    """
    run = run.from_start()
    input_time, values = run.samples(run.input)
    parts = [(CHANNELS[name], *run.samples(name)) for name in CHANNELS if name in run.columns]
    if not parts:
        raise InputError(f"run '{run.name}': no measurement to fit; expected one of {', '.join(CHANNELS)}")
    kind = np.concatenate([np.full(time.size, kind) for kind, time, _ in parts])
    time = np.concatenate([time for _, time, _ in parts])
    value = np.concatenate([value for _, _, value in parts])
    for name in (run.input, *(name for name in CHANNELS if name in run.columns)):
        if not (most := float(np.nanmax(np.abs(run.columns[name]), initial=0.0))) <= BEYOND:
            raise InputError(f"run '{run.name}': {name} reaches {most:.3g}, expected at most {BEYOND:g} either way")
    order = np.argsort(time, kind="stable")
    return Observed(run.name, run.input, input_time, values, time[order], value[order], kind[order])
