"""A blind case of a whole vehicle: drawn, flown with and without what is wrong, and told apart by its instruments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ....errors import InputError
from ....experiment.allocation import able
from ....experiment.readings import WRAPPED
from ....experiment.whole_scenario import WholeScenario, fly_whole, scenario_of
from ....plant.vehicle import AXES, Vehicle, load_vehicle
from ....record import Run
from ....record.table import Table
from ....record.writer import run_bytes
from ....tank.places import CATALOGUE, Placed, partners, places, read_placed
from ..cause import log_uniform
from .scenarios import FAMILIES, draw_scenario
from .sizes import entries
from .strange import draw_strange, strange

CRAFT = ("bluerov2", "kingfisher", "phoenix", "remus100")
KINDS = {"none": 0.15, "parameters": 0.1, "single": 0.6, "unknown": 0.15}  # shares, choices
GIVEN, HELD = (2, 4), 1  # runs
SPREAD = 0.1  # deviation of the logarithm of each drag and added mass over the file's; a choice
SIZES = (0.5, 4.0)  # drawn log-uniformly
SEEN, LARGER, TRIES = 1.0, 2.5, 4  # least signal, factor on a size that is not seen, and how often; choices
SHIFTED = ("north_m", "east_m", "depth_m", "heading_rad", "range_m")  # where a vehicle starts, nothing else tells
QUIET = 1e-3  # noise of an instrument that states none, in its unit; a choice


@dataclass(frozen=True)
class WholeCase:
    """One case: its runs, given ones first, the number of these, and its truth but for names of files.

    plain: the given flights without the cause, their noise the same.
    """

    runs: tuple[Run, ...]
    plain: tuple[Run, ...]
    given: int
    vehicle: str
    truth: Mapping[str, Any]


def draw_whole(seed: int, number: int, attempt: int) -> WholeCase | None:
    """Case `number`, flown; None where it cannot be flown or its cause is not seen: then it is drawn anew.

    An attempt keeps vehicle and kind.
    """
    what = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(11, number)))
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(12, number, attempt)))
    name, kind = str(what.choice(CRAFT)), str(what.choice(list(KINDS), p=list(KINDS.values())))
    nominal = load_vehicle(name)
    given = int(random.integers(GIVEN[0], GIVEN[1] + 1))
    texts = [draw_scenario(random, nominal, str(random.choice(FAMILIES))) for _ in range(given + HELD)]
    scenarios = [scenario_of(text, f"run_{k}") for k, text in enumerate(texts, 1)]
    flown = nominal if kind == "none" else other_numbers(random, nominal)
    drawn = _draw_effect(random, nominal) if kind == "single" else None
    axis, strange = str(random.choice(able(nominal))), int(random.integers(2**31))
    size = log_uniform(random, *SIZES)
    try:
        plain = [_run(scenario, flown, ()) for scenario in scenarios]
        for _ in range(TRIES if kind in ("single", "unknown") else 1):
            effects, told = _effects(drawn, nominal, size) if drawn else ((), {})
            if kind == "unknown":
                force = draw_strange(np.random.default_rng(strange), nominal, axis, size, scenarios[0].duration_s)
                effects, told = (force,), {force.name: dict(force.values)}
            runs = [_run(scenario, flown, effects) for scenario in scenarios] if effects else plain
            signals = signal(nominal, plain[:given], runs[:given])
            if not effects or max(signals.values()) >= SEEN:
                for run in runs:
                    run_bytes(run)  # InputError for readings that nobody would believe, such as angles in degrees
                label = next(iter(told)) if kind == "single" else kind
                truth = {"kind": kind, "vehicle": name, "label": label, "effects": told, "signal": signals,
                         "given": given, "scenarios": texts, "own": _numbers(flown)}  # fmt: skip
                return WholeCase(tuple(runs), tuple(plain[:given]), given, name, truth)
            size *= LARGER
    except InputError:
        pass
    return None


def caused(truth: Mapping[str, Any]) -> tuple[Vehicle, tuple[Placed, ...]]:
    """The vehicle of a sealed case as it was flown, and what is wrong with it."""
    nominal, own = load_vehicle(truth["vehicle"]), truth["own"]
    flown = replace(
        nominal,
        linear_drag=np.array(own["linear"]),
        quadratic_drag=np.array(own["quadratic"]),
        added_mass=np.array(own["added_mass"]).reshape(6, 6),
    )
    if truth["kind"] == "unknown":
        named = [(*name.split("@"), values) for name, values in truth["effects"].items()]
        return flown, tuple(strange(family, axis, values) for family, axis, values in named)
    return flown, read_placed(Table(Path("trial"), "effects", dict(truth["effects"])), nominal)


def other_numbers(random: np.random.Generator, vehicle: Vehicle) -> Vehicle:
    """The vehicle with other drag and added mass along every axis than its file has."""
    drag, mass = np.exp(SPREAD * random.normal(size=6)), np.exp(0.5 * SPREAD * random.normal(size=6))
    return replace(
        vehicle,
        linear_drag=drag * vehicle.linear_drag,
        quadratic_drag=drag * vehicle.quadratic_drag,
        added_mass=vehicle.added_mass * np.sqrt(np.outer(mass, mass)),
    )


def signal(vehicle: Vehicle, plain: Sequence[Run], runs: Sequence[Run]) -> dict[str, float]:
    """How far each measured channel departs from the same flights without the cause: RMS over its noise.

    That a place is another all along, from the start on, can be seen by nobody.
    """
    found = {}
    for sensor in vehicle.sensors:
        for channel, noise in zip(sensor.channels, sensor.each("noise"), strict=True):
            column, off = f"{sensor.name}.{channel}", []
            for one, other in zip(plain, runs, strict=True):
                if column in one.columns and column in other.columns:
                    (t, z), (at, x) = one.samples(column), other.samples(column)
                    gap = x - np.interp(at, t, z)
                    gap = (gap + np.pi) % (2.0 * np.pi) - np.pi if channel in WRAPPED else gap
                    off.append(gap - gap.mean() if channel in SHIFTED else gap)
            if off:
                found[column] = float(np.sqrt(np.mean(np.concatenate(off) ** 2)) / (noise or QUIET))
    return found


def _draw_effect(random: np.random.Generator, vehicle: Vehicle) -> tuple[Any, str, int]:
    """An effect, its place and a seed of its values; every effect that the vehicle has room for is as likely."""
    there, pushed = places(vehicle), able(vehicle)
    known = {}
    for effect in CATALOGUE:
        at = [p for p in effect.places if p in pushed] if effect.kind == "axis" else list(there[effect.kind])
        if effect.channels:
            has = {s.name for s in vehicle.sensors if set(s.channels) & set(effect.channels)}
            at = [p for p in at if p in has]
        if effect.text == "other":
            at = [p for p in at if partners(vehicle, p)]
        if at:
            known[effect.name, effect.kind] = effect, at
    effect, at = known[list(known)[int(random.integers(len(known)))]]
    return effect, str(random.choice(at)), int(random.integers(2**31))


def _effects(drawn: tuple[Any, str, int], vehicle: Vehicle, size: float) -> tuple[tuple[Placed, ...], dict[str, Any]]:
    effect, place, seed = drawn
    told = {f"{effect.name}@{place}": entries(np.random.default_rng(seed), effect, place, vehicle, size)}
    return read_placed(Table(Path("trial"), "effects", dict(told)), vehicle), told


def _run(scenario: WholeScenario, vehicle: Vehicle, effects: tuple[Placed, ...]) -> Run:
    """A flight of the vehicle as it is, by a pilot who knows its file."""
    return fly_whole(replace(scenario, effects=effects), vehicle).run


def _numbers(vehicle: Vehicle) -> dict[str, Any]:
    """Drag and added mass that were flown."""
    return {
        "linear": vehicle.linear_drag.tolist(),
        "quadratic": vehicle.quadratic_drag.tolist(),
        "added_mass": vehicle.added_mass.ravel().tolist(),
        "axes": list(AXES),
    }
