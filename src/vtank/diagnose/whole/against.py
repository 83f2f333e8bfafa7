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
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...plant.vehicle import Vehicle
from ...record.run import Run
from ...rigid.fit import Fit
from ...rigid.flow import Flow
from ...rigid.layout import AXES, Layout, masses
from ...rigid.noise import first_noise
from ...rigid.recorded import TELLS, Recorded, channel, record
from .budget import STRETCH_S, free_errors
from .curves import Bend, bends, bent, corrected
from .mimicry import mimicry
from .model import Model, blank, refit
from .selection import settled
from .simulator import flowing, shared, unknowns, usual

Array = NDArray[np.float64]
Say = Callable[[str], None]
POOR = 0.5  # share of what the columns do that a plant may miss; a choice
HARDLY = 0.01  # share of what a column does that matters little where no recording has its like; a choice
TELLS_SOMETHING = 3.0  # deviations of the recordings' noise that a column must move by to count; a choice
SIMULATED = "simulated "  # before the name of an instrument of the recordings whose columns a simulator has no name for
TURNS = 2  # of flow and own parameters, each beside the other


@dataclass(frozen=True, eq=False)
class Plant:
    """A simulator, as the vehicle's equations have it.

    Attributes:
        vehicle: with the curves that were found. axes: that are asked about, or None for all.
        fitted, flow: of `Layout`, in place of the file's.
        likeness: by column of its runs, `error` of the plant and what the column `moves` by, root mean squares.
        share: of the motion that the plant misses, root mean square over the columns that tell anything.
        sigma: disturbance that stands for what it misses of each axis [m/s2, rad/s2], (6,).
        mimicry: log evidence that effects find in the simulator's own runs, by `selection.trace`.
        parameters: name, the file's number, the fitted one. runs: names. inputs: column of each thruster's input.
        notes: what is told of the columns.
    """

    vehicle: Vehicle
    axes: tuple[str, ...] | None
    fitted: Mapping[str, float]
    flow: Flow
    likeness: Mapping[str, Mapping[str, float]]
    share: float
    sigma: Array
    mimicry: Mapping[str, float]
    parameters: tuple[tuple[str, float, float], ...]
    runs: tuple[str, ...]
    inputs: Mapping[str, str]
    notes: tuple[str, ...] = ()

    def record(self, runs: Sequence[Run]) -> tuple[Layout, tuple[Recorded, ...], tuple[str, ...]]:
        """Layout and runs with the plant as their nominal; as `rigid.record`."""
        layout, seen, notes = record(runs, self.vehicle, self.axes)
        other = {push.name for push in layout.pushes if self.inputs.get(push.name) != push.column}
        fitted = {name: value for name, value in self.fitted.items() if name.partition("@")[2] not in other}
        for sensor in layout.sensors:
            late = self.fitted.get(f"latency@{SIMULATED}{sensor}", 0.0)
            fitted.setdefault(f"latency@{sensor}", float(layout.null[layout.slot(f"latency@{sensor}")]) + late)
        return *relaid(layout, seen, fitted=fitted, flow=self.flow), notes


def relaid(layout: Layout, runs: Sequence[Recorded], **changes: Any) -> tuple[Layout, tuple[Recorded, ...]]:
    """A layout with changes, and the runs in it."""
    layout = replace(layout, **changes)
    return layout, tuple(replace(run, layout=layout, _drives={}) for run in runs)


def plant_of(
    simulated: Sequence[Run], recorded: Sequence[Run], vehicle: Vehicle, axes: Sequence[str] | None, say: Say
) -> Plant:
    """The plant of a simulator's runs, to diagnose recordings against; InputError where it is too unlike them.

    vehicle: layout and first guesses. axes: as of `diagnose`; by default those of which both tell.
    """
    heard, listened, _ = record(recorded, vehicle, axes)
    simulated = [_instrumented(run, heard) for run in simulated]
    common = tuple(axes or _told_by_both(listened[0], simulated))
    file, seen, notes = record(simulated, vehicle, common)
    layout, seen = relaid(file, seen, fitted=shared(file))
    variance = _floor(layout, seen, heard, listened)
    say("a plant for the simulator")
    noise = first_noise(seen)
    did, noise = usual(layout, seen, replace(noise, variance=np.maximum(noise.variance, variance)))
    free, flow = bends(layout, seen), did.flow
    layout, seen = bent(layout, seen, free)
    model = blank(Fit(seen, noise), layout, (), unknowns(layout, seen[0], did, free))
    model = refit(model, model.fit.filter(model.vector()), model.theta)
    for _ in range(TURNS):
        flow, theta = flowing(model, model.fit.filter(model.vector()), did, flow)
        layout, seen = relaid(layout, seen, flow=flow)
        model = replace(model, fit=replace(model.fit, runs=seen), theta=theta)
        model, _ = settled(model, noise.variance)
    p = model.vector()
    found = {name: float(value) for name, value in zip(layout.names, p, strict=True)}
    changed = {name: found[name] for u in model.unknowns for name in (layout.names[i] for i in u.slots)}
    plant = Plant(
        vehicle=corrected(vehicle, free, {push.name: found[f"gain@{push.name}"] for push in layout.pushes}),
        axes=common, fitted=shared(file) | {name: v for name, v in changed.items() if "#" not in name}, flow=flow,
        likeness={}, share=0.0, sigma=model.fit.noise.sigma, mimicry={}, parameters=(),
        runs=tuple(run.name for run in seen), inputs={push.name: push.column for push in file.pushes}, notes=notes,
    )  # fmt: skip
    say("the plant against the simulator's own runs")
    layout, seen, _ = plant.record(simulated)
    fit = Fit(seen, model.fit.noise)
    likeness, share = _likeness(Model(fit, (), (), np.array([]), layout.null), variance)
    told = tuple(_parameters(file, plant, model, free))
    found = {name.replace(SIMULATED, ""): gain for name, gain in mimicry(layout, fit).items()}
    return replace(plant, likeness=likeness, share=share, mimicry=found, parameters=told)


def _instrumented(run: Run, heard: Layout) -> Run:
    """The run with columns of no instrument named after the recordings' that measure the same, as at the origin.

    What an instrument of the recordings seems to do is then sought in the same columns of the simulator.
    """
    names = {channel(name): f"{SIMULATED}{name}" for name in heard.columns[::-1] if "." in name}
    return replace(run, columns={names.get(name, name): values for name, values in run.columns.items()})


def _told_by_both(recorded: Recorded, simulated: Sequence[Run]) -> tuple[str, ...]:
    """Axes of which recordings and simulator's runs tell."""
    told = {
        axis for run in simulated for name in run.columns if channel(name) in TELLS for axis in TELLS[channel(name)]
    }
    common = tuple(AXES[i] for i in np.flatnonzero(recorded.asked) if i in told)
    if not common:
        wanted = ", ".join(AXES[i] for i in np.flatnonzero(recorded.asked))
        raise InputError(f"the simulator's runs tell of no axis that the recordings tell of; expected some of {wanted}")
    return common


def _floor(layout: Layout, seen: Sequence[Recorded], heard: Layout, listened: Sequence[Recorded]) -> Array:
    """Variance of each column below which nothing has to be met: the recordings' noise, or what hardly matters."""
    noise = dict(zip(heard.columns, first_noise(listened).variance, strict=True))
    found = []
    for c, name in enumerate(layout.columns):
        same = [v for column, v in noise.items() if channel(column) == channel(name)]
        values = np.concatenate([run.value[run.column == c] for run in seen])
        found.append(min(same) if same else (HARDLY * float(np.std(values))) ** 2)
    return np.array(found)


def _likeness(model: Model, variance: Array) -> tuple[dict[str, dict[str, float]], float]:
    """Error of free simulation by column, what the column moves by in as long a time, and the share that is missed."""
    runs = model.fit.runs
    squares, counts = (part.sum(axis=0) for part in free_errors(model))
    found, shares = {}, []
    for c, name in enumerate(runs[0].layout.columns):
        moves = float(np.sqrt(np.mean(np.concatenate([_about_mean(run, c) for run in runs]) ** 2)))
        error = float(np.sqrt(squares[c] / max(counts[c], 1)))
        found[name] = {"error": error, "moves": moves}
        if moves > TELLS_SOMETHING * np.sqrt(variance[c]):
            shares.append(error / moves)
    return found, float(np.sqrt(np.mean(np.square(shares)))) if shares else 1.0


def _about_mean(run: Recorded, c: int) -> Array:
    """Values of a column about their means over stretches of time."""
    time, value = run.time_s[run.column == c], run.value[run.column == c]
    part = ((time - run.time_s[0]) / STRETCH_S).astype(int)
    return np.asarray(value - (np.bincount(part, value) / np.maximum(np.bincount(part), 1))[part])


def _parameters(file: Layout, plant: Plant, model: Model, free: Sequence[Bend]) -> Iterator[tuple[str, float, float]]:
    """What was fitted: name, the file's number, the one that was found; of a curve the force at some inputs [N]."""
    layout, names = model.fit.runs[0].layout, [u.name for u in model.unknowns]
    every = np.ones(6, bool)
    total = [np.diag(sum(masses(p, every)[:2])) for p in (file.null, model.vector())]
    found = model.vector()
    for name in names:
        quantity, _, place = name.partition("@")
        if quantity == "added_mass" and place in AXES:
            i = AXES.index(place)
            yield f"moving_mass@{place}", float(total[0][i]), float(total[1][i])
        elif "#" not in name:
            slot = name.replace("@thrusters", f"@{layout.pushes[0].name}")
            yield name, float(file.null[file.slot(slot)]), float(found[layout.slot(slot)])
    before, after = ({t.name or t.site: t for t in v.thrusters} for v in (file.vehicle, plant.vehicle))
    for bend in free:
        asked, name = np.array([bend.at]), bend.names[0]
        yield (
            f"force@{name} at {bend.at:.3g}",
            float(before[name].force_N(asked)[0]),
            float(after[name].force_N(asked)[0]),
        )
