"""What is free of a simulator of any make when the vehicle's equations are fitted to runs that it has flown.

Masses, drag, couplings, lag and delay are unknowns with wide priors about the vehicle file's numbers; thrusters' curves
(`curves`) and forces of the water beyond drag along each axis (`rigid.flow`) are free beside them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...rigid.filtered import Noise
from ...rigid.fit import Fit
from ...rigid.flow import Flow, terms
from ...rigid.layout import ADDED, AXES, COUPLED, COUPLED_AT, COUPLES, NOSE, TAIL, WEIGHT, XYZ, Layout, masses
from ...rigid.recorded import Recorded
from .curves import Bend
from .own import Unknown, own_unknowns

Array = NDArray[np.float64]
OWN_MASS = 0.3  # share of the body's mass that stays the body's; a choice
SHARE = 0.3  # of an axis' usual force that a drag the file has not may make; a guess
ROOM = 0.1  # share of the usual force that a file may be off, when the fit begins; a guess
LAG_S, DELAY_S = 0.3, 0.1  # [s] prior deviations; guesses
STEP = 1e-3  # of finite differences, as a share of a prior deviation
MOVES = 1e-4  # [m/s, rad/s] usual speed from which an axis moves; a choice


@dataclass(frozen=True, eq=False)
class Usual:
    """Root mean square force and speed of each axis, its largest speed over that, and body and added mass; (6,).

    The speed along all axes is that of the fastest; slower: times by which each goes more slowly, (3,).
    """

    force: Array
    speed: Array
    most: Array
    slower: Array
    mass: Array

    @property
    def flow(self) -> Flow:
        """All terms of the axes that move, at size 0."""
        found = terms([i for i in range(6) if self.most[i] > 0.0])
        return Flow(found, np.zeros((6, found.shape[0])), self.speed, self.most, self.slower, np.zeros(3))


def usual(layout: Layout, runs: tuple[Recorded, ...], noise: Noise) -> tuple[Usual, Noise]:
    """What the vehicle did, and the noise with a disturbance that leaves room for a file that is off."""
    p, moves = layout.null, runs[0].moves
    body, water, _ = masses(p, moves)
    mass = np.diag(body + water)
    force = np.max([np.sqrt(np.mean(run.drive(p).thrust ** 2, axis=0)) for run in runs], axis=0)
    noise = replace(noise, sigma=np.where(moves, np.maximum(noise.sigma, ROOM * force / mass), 0.0))
    nu = np.concatenate([f.way.states[:, 6:12] for f in Fit(runs, noise).filter(p)])
    speed = np.sqrt(np.mean(nu**2, axis=0))
    moving, most = speed > MOVES, np.abs(nu).max(axis=0)
    speed = np.where(moving, speed, 1.0)
    along = np.r_[np.full(3, np.max(speed[:3], initial=0.0, where=moving[:3]) or 1.0), speed[3:]]
    did = Usual(
        force=np.maximum(force, 0.2 * mass * speed * moving), speed=along, most=np.where(moving, most / along, 0.0),
        slower=(along / speed)[:3], mass=mass,
    )  # fmt: skip
    return did, noise


def shared(layout: Layout) -> dict[str, float]:
    """Most of the body's mass counted in the numbers of the water's: motion alone does not tell them apart.

    One number has both then, that stays positive wherever their sum does. How much was lent is told beside it.
    """
    p, own = layout.null, {}
    for name in ("mass@hull", *(f"inertia@{axis}" for axis in AXES[3:])):
        own[name] = OWN_MASS * p[layout.slot(name)]
    lent = (1.0 / OWN_MASS - 1.0) * np.array([own["mass@hull"]] * 3 + [own[f"inertia@{axis}"] for axis in AXES[3:]])
    added = dict(zip(layout.names[ADDED : ADDED + 6], p[ADDED : ADDED + 6] + lent, strict=True))
    return {name: float(value) for name, value in (own | added | {"lent@hull": lent[0]}).items()}


def unknowns(layout: Layout, runs: Sequence[Recorded], did: Usual, free: Sequence[Bend]) -> list[Unknown]:
    """Numbers of a simulator that are free; a mass stays above a tenth of what counts as the water's.

    And what else is unknown of any vehicle: gains of thrusters beside a curve that they share, how inputs act, fins.
    """
    p, found, asked = layout.null, [], [int(i) for i in np.flatnonzero(runs[0].asked)]
    names = [push.name for push in layout.pushes]

    def add(name: str, scale: float, low: float = -np.inf, high: float = np.inf, slots: Sequence[str] = ()) -> None:
        at = layout.at(slots or (name,))
        found.append(Unknown(name, at, p[at], scale, low, high, STEP * scale))

    for i in asked:
        axis, force, speed = AXES[i], SHARE * did.force[i], did.speed[i]
        for name, size in ((f"quadratic_drag@{axis}", force / speed**2), (f"linear_drag@{axis}", force / speed)):
            own = float(p[layout.slot(name)])
            add(name, max(0.5 * own, size), -own)
        add(f"added_mass@{axis}", 0.5 * did.mass[i], -0.9 * p[ADDED + i])
        add(f"drag_asymmetry@{axis}", 0.3, -1.0, 1.0)
        if axis in COUPLES:
            add(f"coupling@{axis}", 0.5 * did.mass[{4: 2, 5: 1}.get(i, i)])
    for i, (a, b) in enumerate(COUPLED_AT):
        if a in asked and b in asked:
            root = float(np.sqrt(did.mass[a] * did.mass[b]))
            add(layout.names[COUPLED + i], 0.1 * root, -0.2 * root, 0.2 * root)
    if names:
        least = min(push.lag_s for push in layout.pushes)
        add("lag@thrusters", LAG_S, -least, slots=[f"lag@{name}" for name in names])
        add("delay@thrusters", DELAY_S, -5.0 * DELAY_S, slots=[f"delay@{name}" for name in names])
    for fin in layout.vehicle.fins:
        add(f"lift@{fin.name}", 0.5 * fin.lift_per_rad, -0.9 * fin.lift_per_rad)
        add(f"late@{fin.name}", DELAY_S, -5.0 * DELAY_S, 5.0 * DELAY_S)
    if 2 in asked:
        add("buoyancy@hull", 0.03 * float(p[WEIGHT]))
    if 3 in asked or 4 in asked:
        for part in XYZ:
            add(f"centre_of_buoyancy_{part}@hull", 0.03 * float(p[NOSE] - p[TAIL]))
    for sensor in layout.sensors[1:]:  # the first keeps the time: all late together is the thrusters' delay
        add(f"latency@{sensor}", DELAY_S, -5.0 * DELAY_S, 5.0 * DELAY_S)
    for bend in free:
        add(bend.name, 0.1 * bend.largest_N, slots=[f"gain@{bend.named(name)}" for name in bend.names])
    taken = {slot for unknown in found for slot in unknown.slots}
    return [*found, *(own for own in own_unknowns(layout, runs) if taken.isdisjoint(own.slots))]
