"""Diagnosis against a simulator of any make, of which there is nothing but runs that it has flown.

A plant, the vehicle's own equations, is fitted to these runs, and takes the place of the nominal. What the plant misses
of the simulator enters in three ways. Its runs are weighed with the noise of the recordings, so that only what these
could show has to be met. What is left is told as the likeness, by column; where it is poor, nothing is said. And the
plant is diagnosed against the simulator's own runs first: evidence that an effect finds there is mimicry, since both
are meant to be the same, and it is taken off what the effect finds in the recordings. An effect is named only by what
recordings show of it beyond that. Comparing run by run would do without a plant, but needs the same inputs from the
same start, which closed loops and other people's simulators seldom have; so runs need not be paired.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...plant.vehicle import Vehicle
from ...record.columns import SPEEDS, channel_of
from ...record.run import Run
from ...rigid.fit import Fit
from ...rigid.flow import Flow
from ...rigid.layout import AXES, Layout
from ...rigid.noise import first_noise
from ...rigid.recorded import Recorded, relaid
from ...rigid.recordings import TELLS, record
from ..given import telling
from ..likeness import Likeness
from .curves import Bend, corrected
from .likeness import SIMULATED, likeness, parameters
from .mimicry import mimicry
from .model import Model
from .plant_fit import Begun, begun, fitted
from .simulator import shared

Array = NDArray[np.float64]
HARDLY = 0.01  # share of what a column does that matters little where no recording has its like; a choice
FASTER = 1.2  # times a simulator's speed from which it is told that recordings go faster; a choice


@dataclass(frozen=True, eq=False)
class Plant:
    """A simulator, as the vehicle's equations have it.

    Attributes:
        file: the vehicle that gave layout and first guesses. axes: that are asked about.
        curves: corrections of its thrusters' curves [N]. fitted, flow: of `Layout`, in place of the file's.
        inputs: column of each thruster's input, whose curve, lag and delay were found.
        sigma: disturbance that stands for what the plant misses of each axis [m/s2, rad/s2], (6,).
        mimicry: log evidence that is found in the simulator's own runs, as of `mimicry`.
    """

    file: Vehicle
    axes: tuple[str, ...]
    curves: Mapping[Bend, float]
    fitted: Mapping[str, float]
    flow: Flow
    inputs: Mapping[str, str]
    sigma: Array
    mimicry: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def vehicle(self) -> Vehicle:
        """With the curves that were found."""
        return corrected(self.file, self.curves)

    def record(self, runs: Sequence[Run]) -> tuple[Layout, tuple[Recorded, ...], tuple[str, ...]]:
        """Layout and runs with the plant as their nominal; as `rigid.record`."""
        layout, seen, notes = record(runs, self.vehicle, self.axes)
        other = {push.name for push in layout.pushes if self.inputs.get(push.name) != push.column}
        fitted = {name: value for name, value in self.fitted.items() if name.partition("@")[2] not in other}
        for sensor in layout.sensors:
            name = f"latency@{sensor}"
            late = self.fitted.get(f"latency@{SIMULATED}{sensor}", 0.0)
            fitted.setdefault(name, float(layout.null[layout.slot(name)]) + late)
        layout, seen = relaid(layout, seen, fitted=fitted, flow=self.flow)
        return layout, seen, notes + tuple(self._faster(layout, seen))

    def _faster(self, layout: Layout, seen: Sequence[Recorded]) -> Iterator[str]:
        """Axes along which recordings go faster than the simulator's runs."""
        for c, name in enumerate(layout.columns):
            if channel_of(name) in SPEEDS:
                i = SPEEDS.index(channel_of(name))
                known = float(self.flow.most[i] * self.flow.usual[i])
                values = np.abs(np.concatenate([run.value[run.column == c] for run in seen]))
                reached = float(np.percentile(values, 99.0))
                if reached > FASTER * known:
                    yield f"{name} reaches {reached:.3g}, in the simulator's runs {known:.3g}: beyond, drag is a guess"


def plant_of(
    simulated: Sequence[Run], recorded: Sequence[Run], vehicle: Vehicle, axes: Sequence[str] | None, folder: str,
    say: Callable[[str], None],
) -> tuple[Plant, Likeness]:  # fmt: skip
    """The plant of a simulator's runs, and how like it is; InputError where that is not enough to say anything.

    vehicle: layout and first guesses. axes: as of `diagnose`; by default those of which both tell. folder: of the runs.
    """
    say("a plant for the simulator")
    heard, listened, _ = record(recorded, vehicle, axes)
    try:
        flown = telling(simulated)[0]
        asked = tuple(axes or _told_by_both(listened[0], flown))
        readings = [_read(runs, vehicle, asked, heard, listened) for runs in _instrumented(flown, heard)]
        read = max(readings, key=lambda reading: reading.first.model.log_evidence)
        model, free = fitted(read.first), read.first.free
        plant = _plant(read.layout, model, free, asked)
        say("the plant against the simulator's own runs")
        own, again, _ = plant.record(read.runs)
        fit = Fit(again, model.fit.noise)
        told = tuple(parameters(read.layout, plant.vehicle, model, free))
        like = likeness(fit, read.noise, folder, told)
    except InputError as e:
        raise InputError(f"the simulator's runs in {folder}: {e}") from None
    like.checked()
    longer = max(1.0, sum(run.time_s.size for run in listened) / sum(run.time_s.size for run in again))
    found = {name.replace(SIMULATED, ""): longer * gain for name, gain in mimicry(own, fit).items()}
    return replace(plant, mimicry=found), like


def _plant(file: Layout, model: Model, free: Sequence[Bend], axes: tuple[str, ...]) -> Plant:
    """What was found, to be laid into other recordings."""
    layout, p = model.fit.runs[0].layout, model.vector()
    found = {layout.names[i]: float(p[i]) for u in model.unknowns for i in u.slots}
    return Plant(
        file=file.vehicle, axes=axes, curves={bend: found[f"gain@{bend.name}"] for bend in free},
        fitted=shared(file) | {name: value for name, value in found.items() if name in file.slots}, flow=layout.flow,
        inputs={push.name: push.column for push in file.pushes}, sigma=model.fit.noise.sigma,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Reading:
    """A simulator's runs as they are read, the variance of recordings in their columns, (C,), and a plant begun."""

    runs: list[Run]
    layout: Layout
    noise: Array
    first: Begun


def _read(
    runs: list[Run], vehicle: Vehicle, asked: Sequence[str], heard: Layout, listened: Sequence[Recorded]
) -> _Reading:
    layout, seen, _ = record(runs, vehicle, asked)
    noise = _noise(layout, heard, listened)
    variance = np.where(np.isinf(noise), _hardly(layout, seen), noise)
    return _Reading(runs, layout, noise, begun(layout, seen, variance))


def _instrumented(runs: Sequence[Run], heard: Layout) -> Iterator[list[Run]]:
    """The runs with columns of no instrument read as at the origin, and as by those that would measure the same.

    Both are named after these: what an instrument of the recordings seems to do is then sought in the same columns of
    the simulator. A simulator's `surge_m_s` is the hull's in one, and what its log would hold in another.
    """
    told = {channel_of(name): heard.vehicle.instrument(name) for name in heard.columns[::-1]}
    bare = {name: told.get(name) or heard.vehicle.instrument(name) for run in runs for name in run.columns}
    bare = {name: own for name, own in bare.items() if own and "." not in name}
    for stands in (SIMULATED, "") if bare else ("",):
        names = {name: f"{stands}{own}.{name}" for name, own in bare.items()}
        yield [replace(run, columns={names.get(name, name): x for name, x in run.columns.items()}) for run in runs]


def _told_by_both(recorded: Recorded, simulated: Sequence[Run]) -> list[str]:
    """Axes of which recordings and simulator's runs tell."""
    told = {axis for run in simulated for name in run.columns for axis in TELLS.get(channel_of(name), ())}
    asked = np.flatnonzero(recorded.asked)
    common = [AXES[i] for i in asked if i in told]
    if not common:
        wanted = ", ".join(AXES[i] for i in asked)
        raise InputError(f"they tell of no axis that the recordings tell of; expected motion along some of {wanted}")
    return common


def _noise(layout: Layout, heard: Layout, listened: Sequence[Recorded]) -> Array:
    """Variance of the noise of recordings in each of a simulator's columns; infinite where they have none like it."""
    noise = list(zip(map(channel_of, heard.columns), first_noise(listened).variance, strict=True))
    return np.array(
        [min((v for same, v in noise if same == channel_of(name)), default=np.inf) for name in layout.columns]
    )


def _hardly(layout: Layout, seen: Sequence[Recorded]) -> Array:
    """Variance of each column that matters little."""
    values = [np.concatenate([run.value[run.column == c] for run in seen]) for c in range(len(layout.columns))]
    return np.array([(HARDLY * float(np.std(v))) ** 2 for v in values])
