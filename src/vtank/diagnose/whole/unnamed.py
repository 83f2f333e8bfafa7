"""What has no name: a free-form force along an axis, of a thruster, a fin or all thrusters, or an error of a column.

Each is a smooth function of one or two of: what the vehicle does and did a moment ago, what drives it, where it is, and
time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from ...record.columns import ATTITUDE, channel_of
from ...rigid.filtered import Filtered, Noise
from ...rigid.fit import Fit, log_likelihood
from ...rigid.layout import AXES
from ...rigid.noise import LEAST_SIGMA, resolution
from ...rigid.places import Sizes
from ...rigid.recorded import Recorded
from ...rigid.tangent import Path, follow_lanes
from ..freeform.dictionary import COARSE, PERIODS
from ..freeform.events import waves
from ..freeform.functions import functions_of, products_of, ways_of
from ..freeform.motion import RINGS_RAD_S, faded, rung
from .model import PLAIN, RUNS_AWAY, VISIBLE, Model, at_noise, even, refit
from .pursuit import pursue
from .score import PIECE, Base, based
from .settling import sought

Array = NDArray[np.float64]
Push = Callable[[Path], Array]  # acceleration of a path's steps per unit of a function, (6,) or (N, 6)
Cause = Callable[[Array], tuple[Array, Array]]  # of functions, (N, W): pushes, (N, 6, W), shifts of readings, (M, W)
Causes = Callable[[Path, int], Cause]  # of a run and its number
FORCES = 4  # the strongest, that are sought once more in calmer water; a choice
PAIRED = 9  # columns of a function of two variables; the rest carries little
MEMORIES_S = (1.0, 4.0)  # [s] over which what was done or asked for a moment ago is remembered; a choice
LOADS_S = (4.0, 15.0)  # [s] over which a drive warms up, wears its supply down or draws air; choices
TURNED_RAD = 0.01  # [rad] by which a fin is turned to see what that does
NAMELESS = "unknown"  # a cause without a name, wherever
ALL_THRUSTERS = "thrusters"  # the place of what all of them have in common
BINS = 60  # of a run, for what acts for a while; a choice
SUSPECTS = 2  # columns whose innovations are the least white, which are looked at; a choice
REPEATS = 4.6  # log evidence from which a free-form part is there: odds of a hundred
NOWHERE_NEAR = 0.3  # share of what is ahead, less PLAIN, below which a free-form part is no rival; a choice
QUIETER = 4.0  # factor by which a disturbance is taken down to see what it may hide; a choice


@dataclass(frozen=True)
class Groups:
    """Free-form functions: what each goes with, its columns for a run, and the instants of each run, (N,).

    lacking: of each run, (N,), that of which a share is off for a while; a steady amount by default.
    """

    names: list[str]
    columns: Callable[[int], list[Array]]
    times: Sequence[Array]
    lacking: Sequence[Array] | None = None

    def made(self, n: int) -> list[Array]:
        """Columns for a run, and bins of time of every run, which are empty but for its own."""
        bins = _bins(self.times[n]) * (1.0 if self.lacking is None else self.lacking[n][:, None])
        return [*self.columns(n), *(bins if k == n else np.zeros_like(bins) for k in range(len(self.times)))]


@dataclass(frozen=True, eq=False)
class Block:
    """A free-form part: where it acts, its gain of log evidence, what it goes with, and its root mean square.

    seen: gain of log likelihood. size: over the usual force of an axis, the full force of a thruster, or the deviation
    of a column. course: of each run, accelerations over its steps, (N, 6) [m/s2, rad/s2], or errors of its
    measurements, (M,) [their units].
    """

    place: str
    channel: str
    gain: float
    seen: float
    goes_with: tuple[str, ...]
    size: float
    course: tuple[Array, ...] = ()

    @property
    def repeats(self) -> bool:
        """Whether it is there beyond doubt, and large enough for anybody to see."""
        return self.gain > REPEATS and self.visible

    @property
    def visible(self) -> bool:
        """Whether anybody would call it a gap."""
        return self.size > VISIBLE or self.seen > PLAIN


Seeker = Callable[[Base], Block]


def unnamed(
    model: Model, found: Sequence[Filtered], base: Base, sizes: Sizes, rival: float = 0.0,
    least: Array | float = 0.0,
) -> list[Block]:  # fmt: skip
    """A block for every axis that is asked about, all that drives, and the least white columns, the strongest first.

    A disturbance follows a force that nobody has named, and slow errors of instruments what they miss: beside a
    free-form part that does as well they can be smaller, or none. And so may all of the noise beside the strongest.
    rival: log evidence by which another explanation is ahead of the model; what comes nowhere near is not looked at
    again. least: variances, (C,), below which no noise is believed.
    """
    runs = model.fit.runs
    asked = [int(i) for i in np.flatnonzero(runs[0].moves)]
    seekers: list[Seeker] = [partial(_axis, sizes=sizes, axis=axis) for axis in asked]
    seekers += [partial(_thruster, k=k) for k in range(len(runs[0].layout.pushes))]
    seekers += [partial(_fin, f=f) for f, fin in enumerate(runs[0].layout.vehicle.fins) if fin.limit_rad > 0.0]
    seekers += [_together] if len(runs[0].layout.pushes) > 1 else []
    forces, columns = len(seekers), _suspects(runs, found)
    seekers += [partial(_column, c=c) for c in columns]
    blocks = _sought(base, seekers)
    if max(block.gain for block in blocks) < NOWHERE_NEAR * rival - PLAIN:
        return sorted(blocks, key=lambda block: -block.gain)
    here = refit(model, found, model.theta, steps=0).log_evidence

    def strongest() -> list[int]:
        return sorted(range(len(blocks)), key=lambda n: -blocks[n].gain)

    def again(other: Model, there: list[Filtered], n: int) -> None:
        block = seekers[n](based(other, there))
        block = replace(block, gain=block.gain + min(other.log_evidence - here, 0.0))
        blocks[n] = max(blocks[n], block, key=lambda block: block.gain)

    for k, c in enumerate(columns):
        for other, there in even(model, c):
            again(other, there, forces + k)
    right = sum(map(log_likelihood, found))  # what noise hides is less beside a part that is right
    for n in strongest()[:1]:
        if _likelihood(model, blocks[n]) > right:
            again(*_unhidden(model, blocks[n], least), n)
    for calm, there in _calm(model) if forces else ():
        some = [n for n in strongest() if n < forces][:FORCES]
        tried = zip(_sought(based(calm, there), [seekers[n] for n in some]), some, strict=True)
        block, n = max(tried, key=lambda pair: pair[0].gain)
        if _likelihood(model, block) > right:
            again(*_unhidden(calm, block, least), n)
    return sorted(blocks, key=lambda block: -block.gain)


def _sought(base: Base, seekers: Sequence[Seeker]) -> list[Block]:
    """What seekers find beside a linearisation, which nothing holds on to once they are through."""
    return [seek(base) for seek in seekers]


def at_place(base: Base, sizes: Sizes, place: str) -> list[Block]:
    """Free-form parts at a place: an axis, a thruster, a fin, or the columns of an instrument."""
    layout = base.paths[0].run.layout
    if place in AXES:
        return [_axis(base, sizes, AXES.index(place))]
    blocks = [_thruster(base, k) for k, push in enumerate(layout.pushes) if push.name == place]
    blocks += [_fin(base, f) for f, fin in enumerate(layout.vehicle.fins) if fin.name == place]
    owners = [layout.vehicle.instrument(name) or "recording" for name in layout.columns]
    columns = [c for c, owner in enumerate(owners) if owner == place and layout.judged[c]]
    return blocks + [_column(base, c) for c in columns]


def _calm(model: Model) -> list[tuple[Model, list[Filtered]]]:
    """The refit at far less of a disturbance, and no instrument drifting, and its innovations; nothing if no filter is.

    Where rounding leaves nothing of a covariance it is too quiet for one.
    """
    noise = calmed(model.fit.noise.even, QUIETER)
    fit = replace(model.fit, noise=noise)
    there = fit.filter(model.vector())
    if sum(map(log_likelihood, there)) == -np.inf:
        return []
    return [(refit(replace(model, fit=fit), there, model.theta), there)]


def calmed(noise: Noise, factor: float) -> Noise:
    """A noise whose disturbances, where there are any, are less by a factor."""
    calm = np.maximum(noise.sigma / factor, LEAST_SIGMA)
    return replace(noise, sigma=np.where(noise.sigma > 0.0, calm, 0.0))


def _unhidden(model: Model, block: Block, least: Array | float) -> tuple[Model, list[Filtered]]:
    """The refit, without a free-form part, at the noise that is likeliest beside it; and its innovations."""
    return at_noise(model, sought(_beside(model, block), model.vector(), model.fit.noise.variance, least))


def _likelihood(model: Model, block: Block) -> float:
    """Log likelihood of the model beside a free-form part, at its noise."""
    return sum(map(log_likelihood, _beside(model, block).filter(model.vector())))


def _beside(model: Model, block: Block) -> Fit:
    """The runs beside a free-form part."""
    p, fit = model.vector(), model.fit
    runs = tuple(run.beside(p, course) for run, course in zip(fit.runs, block.course, strict=True))
    return replace(fit, runs=runs)


def _axis(base: Base, sizes: Sizes, axis: int) -> Block:
    """A free-form force along or about an axis."""
    hull = base.paths[0].hull
    unit = sizes.force[axis] / (hull.body[axis, axis] + hull.water[axis, axis])
    moving = [i for i in range(6) if sizes.speed[i] > 2e-4]
    variables: dict[str, list[Array]] = {}
    for i in moving:
        variables[f"{AXES[i]} speed"] = [path.way.states[:-1, 6 + i] for path in base.paths]
    for i, name in ((axis, "thrust"), *((i, f"{AXES[i]} thrust") for i in range(3) if i != axis)):
        variables[name] = [path.drive.thrust[:, i] for path in base.paths]
    variables["place" if axis < 3 else "attitude"] = [path.way.states[:-1, axis] for path in base.paths]
    own, place = f"{AXES[axis]} speed", "place" if axis < 3 else "attitude"
    others = [f"{AXES[i]} speed" for i in moving if i != axis]
    thrusts = [name for name in variables if name.endswith("thrust")]  # whose wash a hull and its fins stand in
    pairs = [(own, name) for name in (*others, *thrusts, place)]
    pairs += [(name, other) for n, name in enumerate(others) for other in others[n + 1 :]]
    pairs += [(name, place) for name in others]
    times = [path.run.steps.now for path in base.paths]
    for name in (own, "thrust"):
        if name in variables:
            variables |= _remembered(name, variables[name], times)
    push = np.zeros(6)
    push[axis] = unit
    groups = _ringing(
        _groups(variables, pairs, times, (own, place)), [path.acceleration[:, axis] for path in base.paths]
    )
    return _forced(base, AXES[axis], "hydrodynamics", groups, lambda path: push)


def _remembered(
    name: str, values: Sequence[Array], times: Sequence[Array], memories_s: Sequence[float] = MEMORIES_S
) -> dict[str, list[Array]]:
    """Values of each run as they are remembered over a while, by name."""
    return {f"{name} of the last {memory:g} s": [faded(t, v, memory) for t, v in zip(times, values, strict=True)]
            for memory in memories_s}  # fmt: skip


def _driven(
    base: Base, place: str, inputs: list[Array], along: list[Array], push: Push, lacking: list[Array] | None = None
) -> Block:
    """What a thruster or a fin does otherwise: of what it is told and was told, which way that goes, and how hard.

    The flow along it, and time.
    """
    times = [path.run.steps.now for path in base.paths]
    told = _remembered("input", inputs, times)
    load = _remembered("size of the input", [np.abs(some) for some in inputs], times, LOADS_S)
    variables = {"input": inputs, "flow along it": along, **told, **load, "time": times}
    pairs = [("input", "flow along it"), ("input", "time"), *(("input", name) for name in (*told, *load))]
    groups = replace(_groups(variables, pairs, times, ("input",)), lacking=lacking)
    return _forced(base, place, "actuator", groups, push)


def _thruster(base: Base, k: int) -> Block:
    """A free-form force of a thruster, in the direction in which it pushes."""
    first = base.paths[0]
    gear, name = first.hull.gears[k], first.run.layout.pushes[k].name
    push = first.hull.inverse @ gear * float(np.abs(first.run.tables[k]).max(initial=1e-9))
    inputs, thrust = [], []
    for path in base.paths:
        at = np.searchsorted(path.run.stamps, path.run.steps.now + 1e-9, side="right") - 1
        inputs.append(np.where(at >= 0, path.run.inputs[np.maximum(at, 0), k], 0.0))
        table, reach = path.run.tables[k], path.run.reach[k]
        steady = np.interp(inputs[-1], np.linspace(-reach, reach, table.size), table)
        thrust.append(steady / float(np.abs(table).max(initial=1e-9)))
    along = [path.way.states[:-1, 6:12] @ gear for path in base.paths]
    return _driven(base, name, inputs, along, lambda path: push, thrust)


def _fin(base: Base, f: int) -> Block:
    """A free-form error of the angle of a fin, over what it is usually turned by."""
    layout = base.paths[0].run.layout
    name = layout.vehicle.fins[f].name
    angles = [path.drive.fins[:, f] for path in base.paths]
    usual = float(np.std(np.concatenate(angles))) or TURNED_RAD

    def push(path: Path) -> Array:
        turned = path.p.copy()
        turned[layout.at([f"offset@{name}"])] += TURNED_RAD
        caused = path.cause(turned)
        assert caused is not None
        return caused[0] * (usual / TURNED_RAD)

    return _driven(base, name, angles, [path.way.states[:-1, 6] for path in base.paths], push)


def _together(base: Base) -> Block:
    """A free-form share of the force of all thrusters: of their load, of the depth, the way, and time."""
    times, first, load = [path.run.steps.now for path in base.paths], base.paths[0], _load(base.paths)
    variables = {"load": load, "depth": [path.way.states[:-1, 2] for path in base.paths],
                 "surge speed": [path.way.states[:-1, 6] for path in base.paths], "time": times,
                 **_remembered("load", load, times)}  # fmt: skip
    pairs = [("load", name) for name in variables if name != "load"]

    def push(path: Path) -> Array:
        return np.where(path.run.moves, path.drive.thrust @ first.hull.inverse.T, 0.0)

    return _forced(base, ALL_THRUSTERS, "actuator", _groups(variables, pairs, times, ("load",)), push)


def _load(paths: Sequence[Path]) -> list[Array]:
    """How hard thrusters work on average over the steps of each run, of the most that each was asked for, (N,)."""
    most = np.max([path.drive.asked.max(axis=0, initial=1e-9) for path in paths], axis=0)
    return [np.mean(path.drive.asked / most, axis=1) for path in paths]


def _forced(base: Base, place: str, channel: str, groups: Groups, push: Push) -> Block:
    """The block of groups of functions along the steps that push the vehicle by `push` [m/s2, rad/s2] at one."""

    def causes(path: Path, n: int) -> Cause:
        one = np.atleast_2d(push(path))[:, :, None]
        return lambda told: (told[:, None, :] * one, np.zeros((path.run.time_s.size, told.shape[1])))

    block = _block(base, place, channel, groups, causes)
    pushed = [told[:, None] * np.atleast_2d(push(path)) for path, told in zip(base.paths, block.course, strict=True)]
    return replace(block, course=tuple(pushed))


def _column(base: Base, c: int) -> Block:
    """A free-form error of a column: of what it was expected to read, without its own noise, and of the motion."""
    runs = [path.run for path in base.paths]
    column = runs[0].layout.columns[c]
    mine = [run.column == c for run in runs]
    unit = float(np.std(np.concatenate([run.value[at] for run, at in zip(runs, mine, strict=True)]))) or 1.0
    if channel_of(column) in ATTITUDE:
        unit = min(unit, 1.0)  # [rad]: an error of a heading is no smaller for the turns that were made
    told = [path.run.value[at] - path.f.innovation[at] for path, at in zip(base.paths, mine, strict=True)]
    before = [path.way.before[at] for path, at in zip(base.paths, mine, strict=True)]
    variables = {"reading": told}
    for i in map(int, np.flatnonzero(runs[0].moves)):
        variables[f"{AXES[i]} speed"] = [x[:, 6 + i] for x in before]
    for i, name in ((3, "roll"), (4, "pitch"), (5, "heading")):
        variables[name] = [np.arctan2(np.sin(x[:, i]), np.cos(x[:, i])) for x in before]
    pairs = [("reading", name) for name in variables if name != "reading"]
    times = [run.time_s[at] for run, at in zip(runs, mine, strict=True)]
    if runs[0].layout.pushes:
        loads = zip(_load(base.paths), base.paths, mine, strict=True)
        variables["load"] = [load[_before(path)][at] for load, path, at in loads]
        variables |= _remembered("load", variables["load"], times)
    felt = [_felt(path) for path in base.paths]
    for i in map(int, np.flatnonzero(runs[0].moves[:3])):
        name = f"{AXES[i]} acceleration"
        variables[name] = [a[at, i] for a, at in zip(felt, mine, strict=True)]
        variables |= _remembered(name, variables[name], times)
    groups = _periodic(_groups(variables, pairs, times, ("reading",)), told, resolution(runs, c))

    def causes(path: Path, n: int) -> Cause:
        def shifting(told: Array) -> tuple[Array, Array]:
            shifts = np.zeros((path.run.time_s.size, told.shape[1]))
            shifts[mine[n]] = unit * told
            return np.zeros((path.run.steps.now.size, 6, told.shape[1])), shifts

        return shifting

    block = _block(base, runs[0].layout.vehicle.instrument(column) or column, "sensor", groups, causes)
    errors = [np.zeros(run.time_s.size) for run in runs]
    for error, at, told_error in zip(errors, mine, block.course, strict=True):
        error[at] = unit * told_error
    return replace(block, course=tuple(errors))


def _felt(path: Path) -> Array:
    """Acceleration of the vehicle's origin along its axes, with what their turning makes, at measurements, (M, 3)."""
    velocity = path.way.states[:-1, 6:12]
    return np.asarray(path.acceleration[:, :3] + np.cross(velocity[:, 3:], velocity[:, :3]))[_before(path)]


def _before(path: Path) -> NDArray[np.int64]:
    """The step before the last one before each measurement, (M,).

    The last one's end already answers to the reading, as do filter and pilot, and would explain its noise.
    """
    steps, before = path.run.steps, np.empty(path.run.time_s.size, np.int64)
    before[steps.which] = np.maximum(steps.upto - 2, 0)
    return before


def _groups(
    variables: dict[str, list[Array]],
    pairs: Sequence[tuple[str, str]],
    times: Sequence[Array],
    sticky: Sequence[str] = (),
) -> Groups:
    """Smooth functions of each variable and of pairs of them, and a function of time.

    And of which way the sticky ones went last.
    """
    spans, every = dict[str, tuple[float, float]](), {**variables, "time": times}
    for name, values in every.items():
        low, high = np.percentile(np.concatenate(values), [0.1, 99.9])
        if high - low > 1e-9:
            spans[name] = low, high
    both = [(first, second) for first, second in pairs if first in spans and second in spans]
    went = [name for name in sticky if name in spans]
    names = [*spans, *(f"{a} and {b}" for a, b in both), *(f"which way the {name} went last" for name in went)]

    def columns(n: int) -> list[Array]:
        share = {name: (every[name][n] - low) / (high - low) for name, (low, high) in spans.items()}
        made = {name: functions_of(values) for name, values in share.items()}
        mixed = (products_of(made[a], made[b], PAIRED) for a, b in both)
        return [*made.values(), *mixed, *(ways_of(share[name]) for name in went)]

    return Groups(names, columns, times)


def _bins(times: Array) -> Array:
    """Bins of time of a run, (N, BINS)."""
    first, last = (times.min(), times.max()) if times.size else (0.0, 0.0)  # a run may lack a column
    place = ((times - first) / max(last - first, 1e-9) * BINS).astype(int)
    return np.asarray(np.minimum(place, BINS - 1)[:, None] == np.arange(BINS), dtype=np.float64)


def _ringing(groups: Groups, felt: list[Array]) -> Groups:
    """The groups, and what rings on after an acceleration: a load that swings, water in a tank."""
    usual = float(np.sqrt(np.mean(np.concatenate(felt) ** 2))) or 1.0
    count = RINGS_RAD_S.size

    @cache
    def rings(n: int) -> list[Array]:
        return np.split(rung(groups.times[n], felt[n] / usual), count, axis=1)

    def ringing(n: int) -> list[Array]:
        return [*groups.columns(n), *rings(n)]

    return Groups([*groups.names, *["ringing after the acceleration"] * count], ringing, groups.times)


def _periodic(groups: Groups, told: list[Array], step: float) -> Groups:
    """The groups, and waves over what was to be read: of an instrument that sticks, or errs by its own divisions.

    step: of a coarse reading, which is off by a period of its own, and known.
    """
    low, span = float(np.min(np.concatenate(told))), float(np.ptp(np.concatenate(told)))
    periods = PERIODS[PERIODS * COARSE * step < span]

    def waving(n: int) -> list[Array]:
        phase = 2.0 * np.pi * (told[n] - low) / max(span, 1e-9)
        return [*groups.columns(n), *(waves(phase[:, None] * k) for k in periods)]

    return Groups([*groups.names, *["reading, periodic"] * periods.size], waving, groups.times)


def _block(base: Base, place: str, channel: str, groups: Groups, causes: Causes) -> Block:
    """The block of groups of functions that cause what `causes` says; these are made run by run, twice."""
    made = groups.made
    sizes = [values.shape[1] for values in made(0)]
    ends = np.cumsum([1, *sizes])
    parts = [slice(int(end) - size, int(end)) for size, end in zip(sizes, ends[1:], strict=True)]
    names = [*groups.names, *(f"a while in run {n + 1}" for n in range(len(groups.times)))]
    rows = np.cumsum([0, *(path.run.time_s.size for path in base.paths)])

    def columns() -> Iterator[Array]:
        for n, path in enumerate(base.paths):
            answers = _answers(path, causes(path, n), np.hstack(made(n)), base.e[rows[n] : rows[n + 1]])
            yield from (answers[first : first + PIECE] for first in range(0, len(answers), PIECE))

    with np.errstate(over="ignore", invalid="ignore"):
        gram = base.gram(columns())
    lost = ~(np.abs(np.diag(gram)) < RUNS_AWAY**2)
    gram[lost], gram[:, lost] = 0.0, 0.0
    count = len(groups.names)
    gain, seen, chosen, c = pursue(gram, parts[:count], parts[count:])
    told = [np.hstack(made(n)) @ c for n in range(len(base.paths))]
    size = float(np.sqrt(np.mean(np.concatenate(told) ** 2)))
    return Block(place, channel, gain, seen, tuple(dict.fromkeys(names[n] for n in chosen)), size, tuple(told))


def _answers(path: Path, cause: Cause, told: Array, e: Array) -> Array:
    """Innovations e, (M,), and what each of some functions, (N, L), changes them by, (M, 1 + L)."""
    out = np.zeros((e.size, 1 + told.shape[1]))
    out[:, 0] = e

    def caused(some: slice) -> tuple[Array, Array] | None:
        return cause(told[:, some]) if told[:, some].any() else None  # else it acts for a while in another run

    follow_lanes([path], [caused], out[:, 1:])
    return out


def _suspects(runs: Sequence[Recorded], found: Sequence[Filtered]) -> list[int]:
    """The columns whose innovations, slow errors not foreseen, are the least white.

    By their first autocorrelation in deviations.
    """

    def unwhite(c: int) -> float:
        most = 0.0
        for run, f in zip(runs, found, strict=True):
            mine = run.column == c
            z = (f.innovation + f.told.slow)[mine] / np.sqrt(f.told.apart[mine])
            most = max(most, abs(float(z[1:] @ z[:-1])) / np.sqrt(max(z.size, 1)))
        return most

    told = np.unique(np.concatenate([run.column for run in runs]))
    told = told[runs[0].layout.judged[told]]
    return [int(c) for c in told[np.argsort([unwhite(c) for c in told])[::-1][:SUSPECTS]]]
