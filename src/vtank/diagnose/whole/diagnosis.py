"""A whole vehicle diagnosed: verdict with places, probabilities, budget, and everything else as plain data."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...estimate.observed import stretches
from ...plant.vehicle import Vehicle
from ...record.columns import channel_of
from ...record.repeats import smallest_step
from ...record.run import Run
from ...rigid.filtered import TINY, shaken
from ...rigid.fit import Fit, log_likelihood
from ...rigid.layout import AXES, Layout
from ...rigid.noise import SURELY
from ...rigid.places import TWINS, Placed
from ...rigid.recordings import record
from ...rigid.thinned import samples, scatter
from ..given import telling
from ..likeness import Likeness, doubted
from ..ties import SEPARABLE
from .against import Plant, plant_of
from .budget import Budget, budget
from .model import PLAIN, Model
from .odds import explained, strange
from .plane import in_the_plane
from .selection import Selection, narrowed, select
from .unfinished import filed
from .unnamed import Block

Array = NDArray[np.float64]
NAMED = 0.5  # probability that an answer must have, a set of effects, no effect or none that has a name; a choice
RIVAL = 0.05  # probability from which a set is listed as a rival; a choice
STRAINED = 4.6  # log prior that own parameters lose in the place of an effect, from which they are none: odds of 100
SEEN = 0.03  # of the error of simulation that an effect must take off what is left without it; a choice
BETTER = 0.02  # share of the nominal's error by which a diagnosed model must be better on what was left out; a choice
COARSE = 1e-3  # of what a column usually reads, below which its steps are a file's last digit; a choice
UNPUNCTUAL = 0.05  # share of the time between rows, by which inputs turn off, from which a log is told of; a choice
PLAUSIBLE = 0.1  # share of an axis' usual force that a disturbance may have; a guess
OUTWEIGHS = 3.0  # times the log evidence that a plant mimics, beyond which it is not to blame for a gap; a choice
TURBULENT = 0.01  # [m/s2] of a disturbance that is plausible at any rate, of still tanks 0.1 to 5 mm/s2; a guess


@dataclass(frozen=True)
class Verdict:
    """What is said.

    Attributes:
        kind: none, parameters, effect, effects, unknown or undecided.
        effects, places: parallel, the effects that are named and where. rivals: what the data does not rule out.
        channel: hydrodynamics, actuator, sensor or None. probability: of the kind, or of the set.
        unexplained: where something is left that repeats and has no name. doubt: why it is undecided; "disturbance"
            where what has no name is a disturbance that no water makes.
    """

    kind: str
    effects: tuple[str, ...]
    places: tuple[str, ...]
    rivals: tuple[str, ...]
    channel: str | None
    probability: float
    unexplained: tuple[str, ...] = ()
    doubt: str = ""


@dataclass(frozen=True, eq=False)
class WholeDiagnosis:
    """A diagnosis of a whole vehicle; `document` is all of it as plain data, schema vtank.diagnosis/2."""

    vehicle: Vehicle
    selection: Selection = field(repr=False)
    verdict: Verdict
    budget: Budget = field(repr=False)
    notes: tuple[str, ...] = ()
    against: Likeness | None = field(default=None, repr=False)
    plant: Plant | None = field(default=None, repr=False)

    @property
    def probabilities(self) -> dict[str, float]:
        """Of none, parameters, every set that was fitted and unknown@PLACE, the most probable first."""
        return dict(sorted(self.selection.probabilities.items(), key=lambda item: -item[1]))

    @property
    def where(self) -> dict[str, float]:
        """Probability of each place: an axis, a thruster, an instrument, the vehicle."""
        return places_of(self.selection)

    @property
    def nominal(self) -> str:
        """The simulator's name."""
        return self.vehicle.name + (f" as fitted to {self.against.folder}" if self.against else "")

    @property
    def document(self) -> dict[str, Any]:
        """As plain data."""
        selection, best = self.selection, self.selection.best
        noise = best.fit.noise
        asked = [AXES[i] for i in range(6) if selection.runs[0].asked[i]]
        shown = {name: p for name, p in self.probabilities.items() if p >= 1e-4}
        strongest: dict[str, Block] = {}
        for block in selection.blocks:  # the strongest first; each column of an instrument has one
            strongest.setdefault(block.place, block)
        verdict = {
            "kind": self.verdict.kind, "effects": list(self.verdict.effects), "places": list(self.verdict.places),
            "class": list(self.verdict.rivals), "channel": self.verdict.channel,
            "probability": self.verdict.probability, "unexplained": list(self.verdict.unexplained),
            "doubt": self.verdict.doubt,
        }  # fmt: skip
        return {
            "schema": "vtank.diagnosis/2", "nominal": self.nominal, "axes": asked,
            "runs": [run.name for run in selection.runs], "verdict": verdict, "probabilities": shown,
            "where": self.where, "effects": [_effect(best, placed) for placed in best.effects],
            "parameters": _own(selection), "budget": [line.document() for line in self.budget.lines],
            "channels": {name: {"budget": [line.document() for line in lines], "rms": self.budget.rms[name]}
                         for name, lines in self.budget.columns.items()},
            "slow_errors": {name: {"size": float(size), "memory_s": float(memory)} for name, size, memory
                            in zip(selection.layout.columns, noise.slow, noise.slow_s, strict=True) if size > 0.0},
            "disturbance": {"sigma": dict(zip(AXES, map(float, selection.disturbance), strict=True)),
                            "memory_s": dict(zip(AXES, map(float, noise.memory_s), strict=True)),
                            "unit": "m/s2, rad/s2", "inputs_off": float(noise.timing),
                            "water_m_s": list(map(float, noise.sigma[:3])) if noise.flows else None},
            "unexplained": {"share": self.budget.left,
                            "blocks": {place: block.gain for place, block in strongest.items()},
                            "goes_with": {place: list(block.goes_with) for place, block in strongest.items()
                                          if block.repeats}},
            "notes": list(self.notes),
            **({"against": self.against.document} if self.against else {}),
        }  # fmt: skip


def _effect(model: Model, placed: Placed) -> dict[str, Any]:
    numbers = {n.name: n for n in placed.parameters}
    values = {name: {"value": value, "sd": sd, "unit": numbers[name].unit}
              for name, (value, sd) in model.values(placed).items()}  # fmt: skip
    return {"name": placed.effect, "place": placed.place, "column": placed.detail, "channel": placed.channel,
            "sentence": placed.sentence, "values": values}  # fmt: skip


def _own(selection: Selection) -> list[dict[str, Any]]:
    found, best = [], selection.best
    sd = best.sd
    for i, unknown in enumerate(best.unknowns):
        if not unknown.name.rpartition(".")[0]:
            nominal = float(np.mean(unknown.base))
            found.append({"name": unknown.name, "nominal": nominal, "value": nominal + float(best.theta[i]),
                          "sd": float(sd[i])})  # fmt: skip
    return found


def places_of(selection: Selection) -> dict[str, float]:
    """Probability that a place has an effect, named or not."""
    found: dict[str, float] = {}
    for name, chance in selection.probabilities.items():
        if name in selection.sets:
            places = {placed.place for placed in selection.sets[name].effects}
        else:
            places = {name.partition("@")[2]}
        for place in places:
            found[place] = found.get(place, 0.0) + chance
    return {place: p for place, p in sorted(found.items(), key=lambda item: -item[1]) if p >= 1e-3}


def disturbed(selection: Selection, axis: str, times: float) -> Selection:
    """The selection with the chance that a disturbance too large for water is a cause, where none is named.

    axis, times: of `too_large`.
    """
    if not axis or selection.best.effects:
        return selection
    chances = dict(selection.probabilities)
    name, calm = f"unknown@{axis}", max(chances.get("none", 0.0), chances.get("parameters", 0.0))
    chances[name] = chances.get(name, 0.0) + calm * float(np.exp(strange(times)))
    total = sum(chances.values())
    return replace(selection, probabilities={name: chance / total for name, chance in chances.items()})


def verdict_of(selection: Selection, spent: Budget, strange_axis: str = "") -> Verdict:
    """The verdict, from probabilities and budget; strange_axis: that of `too_large`."""
    chances = dict(sorted(selection.probabilities.items(), key=lambda item: -item[1]))
    unknown = {name: p for name, p in chances.items() if name.startswith("unknown@")}
    name, chance = next(iter(chances.items()))
    left = tuple(dict.fromkeys(block.place for block in selection.blocks if block.repeats))
    rivals = tuple(other for other, p in chances.items() if p >= RIVAL and other in selection.sets and other != name)
    plain, nameless = {key: chances.get(key, 0.0) for key in ("none", "parameters")}, sum(unknown.values())
    calm = sum(plain.values())
    if nameless >= chance or name in plain:  # no set of effects leads
        if max(nameless, calm) < NAMED:
            return Verdict("undecided", (), (), (name, *rivals), None, chance, left)
        if nameless >= calm:
            place = max(unknown, key=lambda key: unknown[key]).partition("@")[2]
            doubt = "disturbance" if place == strange_axis and place not in left else ""
            return Verdict("unknown", (), (place,), (), _channel(selection, place), nameless, left, doubt)
        name = max(plain, key=lambda key: plain[key])
        return Verdict(name, (), (), (), None, plain[name], left)
    model = selection.sets[name]
    effects, places = (tuple(getattr(p, part) for p in model.effects) for part in ("effect", "place"))
    alike = [(placed, f"{TWINS[placed.effect]}@{placed.place}") for placed in model.effects if placed.effect in TWINS]
    alike += [(placed, f"{placed.effect}@{placed.detail}") for placed in model.effects if placed.exchange]
    twins = tuple("+".join(sorted({*model.names} - {placed.name} | {other})) for placed, other in alike)
    same = tied(selection, name)
    chance += sum(chances.get(other, 0.0) for other in same)
    channels = {placed.channel for placed in model.effects}
    kind = "effect" if len(effects) == 1 else "effects"
    gained = [line.interval90[1] for line in spent.lines if line.kind == "effect"]  # at best
    doubt = "worse" if gained and max(gained) < -BETTER else ""
    if chance < NAMED or doubt:
        kind = "undecided"
    alone = channels.pop() if len(channels) == 1 else None
    every = tuple(dict.fromkeys((name, *twins, *same, *rivals)))
    return Verdict(kind, effects, places, every, alone, chance, left, doubt)


def tied(selection: Selection, name: str) -> list[str]:
    """Sets of as many effects as a named one that no instrument here tells from it, the most probable first.

    Their innovations differ by fewer than SEPARABLE deviations, as those of ties of surge do, those included by which
    own parameters are strained beyond what the named one takes: what else their probabilities differ by was held of
    them beforehand.
    """
    model = selection.sets[name]
    rivals = {key: other for key, other in selection.sets.items()
              if key != name and len(other.effects) == len(model.effects) and other.fit is model.fit}  # fmt: skip
    if not rivals:
        return []
    e = model.fit.residuals([other.vector() for other in (model, *rivals.values())], selection.found)
    apart = np.linalg.norm(e[:, 1:] - e[:, :1], axis=0)
    strain = [2.0 * max(other.strained - model.strained, 0.0) for other in rivals.values()]
    near = [key for key, far, more in zip(rivals, apart, strain, strict=True) if far**2 + more < SEPARABLE**2]
    return sorted(near, key=lambda key: -selection.probabilities.get(key, 0.0))


def too_large(selection: Selection, missed: Array | float = 0.0) -> tuple[str, float]:
    """The axis whose disturbance is too large for turbulence, held against its usual force, and how many times.

    Of those of which something tells; about an axis it is that of a point as far off it as its mass is on average.
    missed: disturbance that stands for what the nominal misses of the simulator that it was fitted to, (6,). "" and 1
    where all are plausible, or might as well be.
    """
    best = selection.best
    hull = selection.runs[0].hull(best.vector())
    sigma = np.sqrt(np.maximum(selection.disturbance**2 - np.square(missed), 0.0))
    inertia = np.diag(hull.body + hull.water)
    lever_m = np.append(np.ones(3), np.sqrt(inertia[3:] / inertia[:3].mean()))
    share = sigma * inertia / selection.sizes.force
    beyond = np.minimum(share / PLAUSIBLE, sigma * lever_m / TURBULENT) * selection.runs[0].asked
    for axis in np.argsort(-beyond)[: np.count_nonzero(beyond > 1.0)]:
        least = np.hypot(sigma / np.where(np.arange(6) == axis, beyond, 1.0), missed)
        if needed(selection, least):
            return AXES[axis], float(beyond[axis])
    return "", 1.0


def outweighs(selection: Selection, mimicry: Mapping[str, float]) -> bool:
    """Whether far more log evidence of a gap is in the recordings than in the runs of the simulator itself.

    Step by step, that is; a simulation that nothing holds to what was measured goes astray by little. mimicry: as of
    `plant_of`, taken off the free-form parts already.
    """
    most = max(mimicry.values(), default=0.0)
    parts = [block.gain for block in selection.blocks_alone if block.visible]
    gained = max([explained(selection.best, selection.own), *parts])
    return gained > OUTWEIGHS * most


def needed(selection: Selection, least: Array) -> bool:
    """Whether the recordings are clearly less likely with disturbances of these sizes, (6,), than with the likeliest.

    How large one is may be told by next to nothing. least: accelerations [m/s2, rad/s2].
    """
    best, fit = selection.best, selection.best.fit
    sigma = np.minimum(least / np.maximum(shaken(fit.noise, selection.found), TINY), 1.0)
    if fit.noise.flows:
        sigma[:3] = sigma[:3].min()  # water moves along all axes alike
    sigma *= fit.noise.sigma
    calmer = replace(fit, noise=replace(fit.noise, sigma=sigma)).filter(best.vector())
    return sum(map(log_likelihood, selection.found)) - sum(map(log_likelihood, calmer)) > SURELY


def _plain(selection: Selection, name: str) -> bool:
    """Whether an effect is a gap however little of the error it takes off.

    By its log likelihood, or since own parameters that do as well in its place would have to be too far off.
    """
    lesser, best = selection.lesser(name), selection.best
    return lesser.cost - best.cost > PLAIN or lesser.strained - best.strained > STRAINED


def _channel(selection: Selection, place: str) -> str | None:
    return next((block.channel for block in (*selection.blocks_alone, *selection.blocks) if block.place == place), None)


def diagnose(
    runs: Sequence[Run], vehicle: Vehicle, axes: Sequence[str] | None = None, effects: Sequence[str] | None = None,
    progress: Callable[[str], None] | None = None, against: Sequence[Run] | None = None, folder: str = "",
) -> WholeDiagnosis:  # fmt: skip
    """Where recordings of a whole vehicle and its simulator part, and which effect at which place causes it.

    runs: of the columns of a whole vehicle. vehicle: the nominal. axes: that are asked about (default: all that
    something tells of); the others are known motion where they were measured. effects: names, or names at places, to
    consider (default: all). against: runs of a simulator, in a folder, that takes the vehicle's place as the nominal
    (`plant_of`). One that was interrupted goes on where it was. InputError where nothing drives the vehicle, too little
    was measured, or no plant is like that simulator.
    """
    given = [part for run in (*runs, *(against or ())) for part in (run.name, *run.columns, *run.columns.values())]
    with filed(repr(vehicle), axes, effects, folder, *given):
        return _diagnosed(runs, vehicle, axes, effects, progress, against, folder)


def _diagnosed(
    runs: Sequence[Run], vehicle: Vehicle, axes: Sequence[str] | None, effects: Sequence[str] | None,
    progress: Callable[[str], None] | None, against: Sequence[Run] | None, folder: str,
) -> WholeDiagnosis:  # fmt: skip
    kept, said = telling(runs)
    plant, like = None, None
    if against is not None:
        plant, like = plant_of(stretches(against), kept, vehicle, axes, folder, progress or (lambda text: None))
    layout, seen, notes = plant.record(kept) if plant else record(kept, vehicle, axes)
    seen, flat = in_the_plane(layout, seen)
    selection = select(layout, seen, effects, progress, plant.mimicry if plant else None)
    if progress:
        progress("the gap budget")
    spent = budget(selection)
    hidden = {name for name, most in spent.visible.items() if most < SEEN}
    hidden |= {placed.name for placed in selection.best.effects if selection.best.tiny(placed)}
    hidden = {name for name in hidden if not _plain(selection, name)}
    if hidden:
        selection = narrowed(selection, hidden)
        notes += tuple(f"{name} is there, but too small for anybody to see" for name in sorted(hidden))
        spent = budget(selection)
    strange_axis, times = too_large(selection, plant.sigma if plant else 0.0)
    selection = disturbed(selection, strange_axis, times)
    verdict = verdict_of(selection, spent, strange_axis)
    if plant and like:
        like = like.beside({channel_of(name): (rms["nominal"], rms["noise"]) for name, rms in spent.rms.items()})
        if not outweighs(selection, plant.mimicry):
            verdict = doubted(verdict, like)
    notes += flat + said + _unlogged(selection.best.fit) + coarse(kept, layout)
    return WholeDiagnosis(vehicle, selection, verdict, spent, notes, like, plant)


def coarse(runs: Sequence[Run], layout: Layout) -> tuple[str, ...]:
    """What to say of columns whose readings come in steps as large as their white error, which pass for noise."""
    notes = []
    for name in layout.columns:
        told = [values for run in runs if name in run.columns and (values := samples(run, name)[1]).size]
        if not told:
            continue
        values = np.concatenate(told)
        step = smallest_step(values)
        if step > max(float(np.median([*map(scatter, told)])), COARSE * float(np.std(values))):
            notes.append(
                f"column {name} comes in steps of {step:.2g}, as large as its noise: taken for noise, not a gap"
            )
    return tuple(notes)


def _unlogged(fit: Fit) -> tuple[str, ...]:
    """What to say where the log does not tell what its inputs do, and when."""
    notes, timing = [], fit.noise.timing
    off = {run.name: run.phase_s for run in fit.runs if abs(run.phase_s) > UNPUNCTUAL * run.tick_s}
    if timing > UNPUNCTUAL:
        notes.append(f"inputs turn between the rows of the log, off by about {timing:.0%} of the time between these; "
                     "logged faster, they would hide less")  # fmt: skip
    if off:
        said = ", ".join(f"{abs(s) * 1e3:.0f} ms {'late' if s > 0.0 else 'early'} in {name}" for name, s in off.items())
        notes.append(f"beside those of the other runs the inputs act {said}: allowed for, as a clock of the log's own")
    return tuple(notes)
