"""Thrusters' curves set free: a bench curve and a correction of it, by its values at some inputs.

A correction of 1 N at one input is a thruster of its own at the same place, whose curve is a cardinal spline; so a fit
sees but one number more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...plant.actuators import Thruster
from ...plant.vehicle import Vehicle
from ...rigid.layout import Layout
from ...rigid.recorded import Recorded

Array = NDArray[np.float64]
KNOTS = 8  # inputs on either side of rest at which a curve is corrected; a choice
FINE = 2401  # points of a corrected curve; a choice
BEYOND = 3.0  # times the largest input up to which a curve is drawn; its correction stays as it is beyond; a choice


@dataclass(frozen=True, eq=False)
class Bend:
    """A correction of 1 N at the input `at` of the thrusters of these names, which share a curve; shapes (FINE,)."""

    names: tuple[str, ...]
    at: float
    asked: Array
    force: Array
    largest_N: float

    @property
    def name(self) -> str:
        """By which its size is told."""
        return f"force@{self.names[0]}#{self.at:.3g}"

    def named(self, name: str) -> str:
        """The thruster that stands for this correction beside the one of that name."""
        return f"{name}#{self.at:.3g}"


def bends(layout: Layout, runs: Sequence[Recorded]) -> list[Bend]:
    """Corrections at all inputs about which something was asked."""
    alike: dict[tuple[object, ...], list[int]] = {}
    for k, push in enumerate(layout.pushes):
        if (t := push.thruster) is not None:
            alike.setdefault((t.input, t.gain, t.curve, t.limit_N, t.dead_band), []).append(k)
    found = []
    for members in alike.values():
        asked = np.concatenate([run.inputs[:, k] for run in runs for k in members])
        reach = float(np.abs(asked).max(initial=1e-9))
        names = tuple(layout.pushes[k].name for k in members)
        largest = max(float(np.abs(layout.pushes[k].table(reach)).max()) for k in members)
        points, steps = BEYOND * reach * np.linspace(-1.0, 1.0, FINE), asked / reach * KNOTS
        knots = [n for n in range(-KNOTS, KNOTS + 1) if n and np.any(np.abs(steps - n) < 1.0)]
        within = np.clip(points / reach * KNOTS, min(knots, default=0), max(knots, default=0))
        found += [Bend(names, n * reach / KNOTS, points, _cardinal(within - n), largest) for n in knots]
    return found


def _cardinal(x: Array) -> Array:
    """Catmull and Rom's spline of 1 at 0 and 0 at all other whole numbers; nothing at rest moves."""
    x = np.abs(x)
    near, far = 1.0 - 2.5 * x**2 + 1.5 * x**3, 2.0 - 4.0 * x + 2.5 * x**2 - 0.5 * x**3
    return np.asarray(np.where(x < 1.0, near, np.where(x < 2.0, far, 0.0)))


def bent(layout: Layout, runs: Sequence[Recorded], free: Sequence[Bend]) -> tuple[Layout, tuple[Recorded, ...]]:
    """Layout and runs with a thruster for every correction, each at 0 N."""
    pairs = [(bend, k) for bend in free for k, push in enumerate(layout.pushes) if push.name in bend.names]
    more = []
    for bend, k in pairs:
        push, curve = layout.pushes[k], tuple(zip(bend.asked.tolist(), bend.force.tolist(), strict=True))
        law = replace(push.thruster, curve=curve, limit_N=np.inf, dead_band=0.0) if push.thruster else None
        more.append(replace(push, name=bend.named(push.name), thruster=law))
    pushes = (*layout.pushes, *more)
    wide = replace(layout, pushes=pushes, fitted={**layout.fitted, **{f"gain@{push.name}": 0.0 for push in more}})
    which = np.array([*range(len(layout.pushes)), *(k for _, k in pairs)], dtype=np.int64)
    found = []
    for run in runs:
        reach = np.r_[run.reach, [bend.asked[-1] for bend, _ in pairs]]
        tables = np.array([push.table(most) for push, most in zip(pushes, reach, strict=True)])
        inputs = np.ascontiguousarray(run.inputs[:, which])
        found.append(replace(run, layout=wide, inputs=inputs, reach=reach, tables=tables, _drives={}))
    return wide, tuple(found)


def corrected(vehicle: Vehicle, free: Sequence[Bend], forces_N: Mapping[str, float]) -> Vehicle:
    """The vehicle with its thrusters' curves corrected; forces_N: of each thruster that stands for a correction."""
    return replace(vehicle, thrusters=tuple(_corrected(t, free, forces_N) for t in vehicle.thrusters))


def _corrected(thruster: Thruster, free: Sequence[Bend], forces_N: Mapping[str, float]) -> Thruster:
    name = thruster.name or thruster.site
    mine = [bend for bend in free if name in bend.names]
    if not mine:
        return thruster
    asked = mine[0].asked
    force = thruster.force_N(asked) + sum(forces_N[bend.named(name)] * bend.force for bend in mine)
    curve = tuple(zip(asked.tolist(), np.asarray(force).tolist(), strict=True))
    return replace(thruster, curve=curve, limit_N=np.inf, dead_band=0.0)
