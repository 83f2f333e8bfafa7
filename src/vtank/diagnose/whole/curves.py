"""Thrusters' curves set free: a bench curve and a correction of it, by its values at some inputs.

A correction of 1 N at one input is a thruster of its own at the same place, whose curve is a cardinal spline; so a fit
sees but one number more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...plant.actuators import Curve, Thruster
from ...plant.vehicle import Vehicle
from ...rigid.layout import Layout
from ...rigid.recorded import Kept, Recorded

Array = NDArray[np.float64]
KNOTS = 8  # inputs on either side of rest at which a curve is corrected; a choice
FINE = 2401  # points of a corrected curve; a choice
BEYOND = 3.0  # times the largest input up to which a curve is drawn; its correction stays as it is beyond; a choice


@dataclass(frozen=True)
class Bend:
    """A correction of 1 N at one input of thrusters that share a curve.

    Attributes:
        names: of the thrusters. step: between inputs at which they are corrected, in the input's unit.
        knots: all of these, in steps; knot: this one. largest_N: that the curve makes.
    """

    names: tuple[str, ...]
    step: float
    knots: tuple[int, ...]
    knot: int
    largest_N: float = 0.0

    @property
    def at(self) -> float:
        """The input."""
        return self.knot * self.step

    @property
    def name(self) -> str:
        """By which its size is told."""
        return self.named(self.names[0])

    def named(self, name: str) -> str:
        """The thruster that stands for this correction beside the one of that name."""
        return f"{name}#{self.knot}"

    def asked(self) -> Array:
        """Inputs at which the curve is drawn, (FINE,)."""
        return np.asarray(BEYOND * KNOTS * self.step * np.linspace(-1.0, 1.0, FINE))

    def force(self) -> Array:
        """The correction there, (FINE,) [N]: Catmull and Rom's spline, as at the last of the knots beyond them."""
        within = np.clip(self.asked() / self.step, self.knots[0], self.knots[-1])
        x = np.abs(within - self.knot)
        near, far = 1.0 - 2.5 * x**2 + 1.5 * x**3, 2.0 - 4.0 * x + 2.5 * x**2 - 0.5 * x**3
        return np.asarray(np.where(x < 1.0, near, np.where(x < 2.0, far, 0.0)))


def bends(layout: Layout, runs: Sequence[Recorded]) -> list[Bend]:
    """Corrections at all inputs near which something was asked; rest makes no force."""
    alike: dict[tuple[object, ...], list[int]] = {}
    for k, push in enumerate(layout.pushes):
        if (t := push.thruster) is not None:
            alike.setdefault((t.input, t.gain, t.curve, t.limit_N, t.dead_band), []).append(k)
    found = []
    for members in alike.values():
        asked = np.concatenate([run.inputs[:, k] for run in runs for k in members])
        step = float(np.abs(asked).max(initial=1e-9)) / KNOTS
        names = tuple(layout.pushes[k].name for k in members)
        largest = max(float(np.abs(layout.pushes[k].table(KNOTS * step)).max()) for k in members)
        knots = tuple(n for n in range(-KNOTS, KNOTS + 1) if n and np.any(np.abs(asked / step - n) < 1.0))
        found += [Bend(names, step, knots, n, largest) for n in knots]
    return found


def bent(layout: Layout, runs: Sequence[Recorded], free: Sequence[Bend]) -> tuple[Layout, tuple[Recorded, ...]]:
    """Layout and runs with a thruster for every correction, each at 0 N."""
    pairs = [(bend, k) for bend in free for k, push in enumerate(layout.pushes) if push.name in bend.names]
    more = []
    for bend, k in pairs:
        push = layout.pushes[k]
        law = _drawn(push.thruster, bend.asked(), bend.force()) if push.thruster else None
        more.append(replace(push, name=bend.named(push.name), thruster=law))
    pushes = (*layout.pushes, *more)
    wide = replace(layout, pushes=pushes, fitted={**layout.fitted, **{f"gain@{push.name}": 0.0 for push in more}})
    which = np.array([*range(len(layout.pushes)), *(k for _, k in pairs)], dtype=np.int64)
    found = []
    for run in runs:
        reach = np.r_[run.reach, [BEYOND * KNOTS * bend.step for bend, _ in pairs]]
        tables = np.array([push.table(most) for push, most in zip(pushes, reach, strict=True)])
        inputs = np.ascontiguousarray(run.inputs[:, which])
        found.append(replace(run, layout=wide, inputs=inputs, reach=reach, tables=tables, _kept=Kept()))
    return wide, tuple(found)


def corrected(vehicle: Vehicle, sizes: Mapping[Bend, float]) -> Vehicle:
    """The vehicle with its thrusters' curves corrected by so many newtons each."""
    return replace(vehicle, thrusters=tuple(_corrected(t, sizes) for t in vehicle.thrusters))


def _corrected(thruster: Thruster, sizes: Mapping[Bend, float]) -> Thruster:
    mine = [bend for bend in sizes if thruster.name in bend.names]
    if not mine:
        return thruster
    asked = mine[0].asked()
    return _drawn(thruster, asked, thruster.force_N(asked) + sum(sizes[bend] * bend.force() for bend in mine))


def _drawn(thruster: Thruster, asked: Array, force: Array) -> Thruster:
    """The thruster with a curve."""
    curve: Curve = tuple(zip(asked.tolist(), force.tolist(), strict=True))
    return replace(thruster, curve=curve, limit_N=np.inf, dead_band=0.0)
