"""Own parameters of a whole vehicle as unknowns of a fit: what its file states, and what no file does."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ...plant.actuators import Fin
from ...record.columns import channel_of
from ...rigid.layout import ADDED, AXES, COUPLED, COUPLED_AT, Layout
from ...rigid.places import OWN_OF_AXIS, OWN_OF_FINS, OWN_OF_THRUSTERS
from ...rigid.push import Push
from ...rigid.recorded import Recorded

Array = NDArray[np.float64]
T = TypeVar("T", Push, Fin)
SQUARE_RAD = 0.2  # [rad] by which a vehicle may start away from square to a wall; a guess
ROTOR = 1.0  # [-] share of the lag that is the rotor's, from none to all; a guess
OFF, FAR_OFF = 0.5, 1.05  # of the time between inputs, by which they act off their stamps, usually and at most; guesses
PATH = 1.0  # [-] from one input to the next: 0 held, 1 straight, 2 along a curve; how far off a file is, a guess
SUCTION = 0.5  # [-] of a leading edge: from that of a plate, 0, to that of a wing of great span, 1; a guess
HOLDS = 0.5  # [-] of its lift that a fin keeps beyond its stall, from none to all; a guess
LEANS = 0.5  # [-] of the part of a fin's force along the hull, from all of it to the opposite, as some have it; a guess
ASLANT = 1.0  # [-] of the power of the cosine with which a fin's force that has no such part goes; a guess
RATIO = 0.5  # [-] of the share of the flow's angle for which that takes a ratio of speeds, from none to all; a guess
STIFF = 0.9  # of the coupling at which added mass would weigh nothing along some direction; a guess
EACH = "own_gain"  # of a thruster beside others of its kind
LEAST, MOST = -0.95, 20.0  # of what the file has, by which a number may be less and more; choices
STEP = 1e-3  # of finite differences, as a share of the number or of its range


@dataclass(frozen=True)
class Unknown:
    """One unknown of a fit: slots that it moves, what it is added to there, prior and bounds about 0 change.

    stated: whether the vehicle file states it, whose numbers are trusted all alike. factor: whether it multiplies what
    is there by its exponential.
    """

    name: str
    slots: NDArray[np.int64]
    base: Array
    scale: float
    low: float
    high: float
    step: float
    stated: bool = True
    factor: bool = False


def own_unknowns(layout: Layout, runs: Sequence[Recorded]) -> list[Unknown]:
    """Drag, added mass and its moments, gain and lag of thrusters and lift of fins of a kind, where the file has them.

    Thrusters of a kind are wrong in alike, and each by a little of its own. And what no file states: when inputs act
    that are logged at instants (held from there on, on the way to the next, or until there; angles of fins that were
    measured otherwise than commands), whether rotors lag or their force, how a wall stands, how much of their lift fins
    pay for with drag, and keep beyond their stall, whether it has a part along the hull, and how it goes with an
    oblique flow where not.
    """
    asked = runs[0].moves
    alike = {
        "gain": _groups("thrusters", layout.pushes, _kind_and_way),
        "lag": _groups("thrusters", layout.pushes, _kind),
        "lift": _groups("fins", layout.vehicle.fins, _section),
    }
    groups = {f"{q}@{axis}": [f"{q}@{axis}"] for i, axis in enumerate(AXES) if asked[i] for q in OWN_OF_AXIS}
    groups |= {f"{q}@{place}": [f"{q}@{name}" for name in names] for q in alike for place, names in alike[q].items()}
    together = [names for names in alike["gain"].values() if len(names) > 1]
    return [
        *_sized(layout, groups),
        *_moments(layout, asked),
        *_flows(layout, asked),
        *_each(layout, together),
        *_unstated(layout, max(run.tick_s for run in runs)),
    ]


def _sized(layout: Layout, groups: dict[str, list[str]]) -> Iterator[Unknown]:
    """Numbers that the file has, each of a group by as much."""
    for name, slots in groups.items():
        at = layout.at(slots)
        at = at[layout.null[at] > 0.0]
        if at.size:
            share = (OWN_OF_AXIS | OWN_OF_THRUSTERS | OWN_OF_FINS)[name.partition("@")[0]]
            size = float(np.mean(layout.null[at]))
            yield Unknown(name, at, layout.null[at], share * size, LEAST * size, MOST * size, STEP * size)


def _moments(layout: Layout, asked: NDArray[np.bool_]) -> Iterator[Unknown]:
    """Moments of added mass, which the file has wrong as it has its masses."""
    p = layout.null
    for k, (i, j) in enumerate(COUPLED_AT):
        size = abs(p[COUPLED + k])
        if size > 0.0 and (asked[i] or asked[j]):
            room = STIFF * float(np.sqrt(p[ADDED + i] * p[ADDED + j]))
            name, at = layout.names[COUPLED + k], np.array([COUPLED + k])
            low, high = min(-room - p[COUPLED + k], 0.0), max(room - p[COUPLED + k], 0.0)
            yield Unknown(name, at, p[at], OWN_OF_AXIS["added_mass"] * size, low, high, STEP * size)


def _flows(layout: Layout, asked: NDArray[np.bool_]) -> Iterator[Unknown]:
    """What a simulator's water does beyond drag along each axis, which is off as drag is."""
    for i in np.flatnonzero(asked & layout.flow.sizes.any(axis=1)):
        at = layout.at([f"flow@{AXES[i]}"])
        yield Unknown(f"flow@{AXES[i]}", at, layout.null[at], OWN_OF_AXIS["quadratic_drag"], LEAST, MOST, STEP)


def _each(layout: Layout, together: Sequence[Sequence[str]]) -> Iterator[Unknown]:
    """The gain of each thruster beside that which it has together with others."""
    thrusters = {thruster.name for thruster in layout.vehicle.thrusters}
    for name in (name for names in together for name in names if name in thrusters):
        at, gain = layout.at([f"gain@{name}"]), float(layout.null[layout.slot(f"gain@{name}")])
        share = OWN_OF_THRUSTERS[EACH] * gain
        yield Unknown(f"{EACH}@{name}", at, np.zeros(1), share, LEAST * gain, MOST * gain, STEP * gain)


def _unstated(layout: Layout, tick_s: float) -> Iterator[Unknown]:
    """What no file states, and is not the simulator's; tick_s: between inputs [s]."""
    p = layout.null

    def free(name: str, slots: Sequence[str], scale: float, low: float, high: float, step: float) -> Unknown:
        at = layout.at(slots)
        return Unknown(name, at, p[at], scale, low, high, step, stated=False)

    def share(name: str, slots: Sequence[str], scale: float, least: float, most: float) -> Unknown:
        known = float(p[layout.at(slots)].max())
        return free(name, slots, scale, least - known, most - known, STEP)

    rotors = [push for push in layout.pushes if push.thruster and push.thruster.input != "N"]
    lagging = [push for push in rotors if p[layout.slot(f"lag@{push.name}")] > 0.0]
    for place, names in _groups("thrusters", lagging, _driven).items() if lagging else ():
        yield share(f"rotor@{place}", [f"rotor@{name}" for name in names], ROTOR, 0.0, 1.0)
    thrusters = [push for push in layout.pushes if push.thruster]
    moved = [fin.name for fin in layout.vehicle.fins if fin.limit_rad]
    told = [("delay", *group) for group in _groups("thrusters", thrusters, _told).items()] + [("late", "fins", moved)]
    for q, place, names in told if tick_s > 0.0 else ():
        if slots := [f"{q}@{name}" for name in names]:
            yield free(f"{q}@{place}", slots, OFF * tick_s, -FAR_OFF * tick_s, FAR_OFF * tick_s, STEP * tick_s)
            yield share(f"path@{place}", [f"path@{name}" for name in names], PATH, 0.0, 2.0)
    for q, scale, least, most in (
        ("suction", SUCTION, -SUCTION, 1.0), ("holds", HOLDS, 0.0, 1.0), ("leans", LEANS, -1.0, 1.0),
        ("aslant", ASLANT, 0.0, 2.0), ("ratio", RATIO, 0.0, 1.0),
    ):  # fmt: skip
        if fins := [f"{q}@{fin.name}" for fin in layout.vehicle.fins]:
            yield share(f"{q}@fins", fins, scale, least, most)
    ranges = [column for column in layout.columns if channel_of(column) == "range_m"]
    for sonar in dict.fromkeys(map(layout.vehicle.instrument, ranges)):
        name = f"wall_bearing@{sonar}"  # a vehicle need not start square to the wall
        yield replace(free(name, [name], SQUARE_RAD, -0.8, 0.8, STEP * SQUARE_RAD), base=np.zeros(1))


def _kind(push: Push) -> object:
    """What thrusters share that differ but in their place, and are wrong in alike."""
    return push.thruster and replace(push.thruster, name="", site="", direction=(1.0, 0.0, 0.0))


def _told(push: Push) -> object:
    """What thrusters share whose inputs are told of alike: speeds are measured, commands may be held."""
    return push.thruster and push.thruster.input


def _driven(push: Push) -> object:
    """What thrusters share whose inputs act in the same way."""
    return push.thruster and (push.thruster.input, push.thruster.lag_s)


def _kind_and_way(push: Push) -> object:
    """As `_kind`; what the hull takes of a thrust is another across its deck than along it."""
    return _kind(push), abs(push.direction[2]) > np.hypot(*push.direction[:2])


def _section(fin: Fin) -> object:
    """What fins share that differ but in where they stand, and are wrong in alike.

    A fixed one that stands for the lift of a hull is of no section: to the side a hull lifts otherwise than up.
    """
    return replace(fin, name="" if fin.limit_rad else fin.name, site="", axis=(0.0, 0.0, 1.0))


def _groups(together: str, parts: Sequence[T], alike: Callable[[T], object]) -> dict[str, list[str]]:
    """Names of thrusters or fins that are alike, by what they are called together; `together` where all are."""
    groups: dict[object, list[str]] = {}
    for part in parts:
        groups.setdefault(alike(part), []).append(part.name)
    if len(groups) == 1:
        return {together: [*groups.values()][0]}
    return {"/".join(names): names for names in groups.values()}
