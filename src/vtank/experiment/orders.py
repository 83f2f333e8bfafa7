"""What a whole vehicle is told to do along its axes: excitations, in open or closed loop, and what is held meanwhile.

The unit of a key tells the loop: `_N`, `_N_m` a force in open loop, `_share` that of the largest the vehicle can make,
`_m`, `_rad` a place and `_m_s`, `_rad_s` a speed, both followed in closed loop on what the instruments read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..plant.vehicle import AXES, Vehicle
from ..record.table import Table
from .excitation import SIGNALS, Excitation, Signal, read_signal

Array = NDArray[np.float64]
BANDWIDTH_RAD_S = 0.5  # of a loop for which none is stated; a choice
LINEAR = {"_N": "force", "_share": "share", "_m": "place", "_m_s": "speed"}  # ending of a key -> loop
ANGULAR = {"_N_m": "force", "_share": "share", "_rad": "place", "_rad_s": "speed"}
INPUT = {"": "input"}
OPEN = ("force", "share", "input")


class Timed(Protocol):
    """What has a value and a rate at every time."""

    def command(self, time_s: Array, duration_s: float) -> Signal:
        """Value and rate, of the shape of time_s."""


@dataclass(frozen=True)
class Spiral:
    """Dieudonne's spiral: from one side to the other in steps, and back, each kept until the turn is steady.

    Attributes:
        amplitude: of the first step. levels: from one side to the other. dwell_s: at each [s].
    """

    amplitude: float
    levels: int
    dwell_s: float

    def command(self, time_s: Array, duration_s: float) -> Signal:
        """The present level, and no rate; after the last one nothing."""
        down = np.linspace(self.amplitude, -self.amplitude, self.levels)
        steps = np.concatenate([down, down[-2::-1], [0.0]])
        return steps[np.minimum((time_s / self.dwell_s + 1e-9).astype(int), steps.size - 1)], np.zeros_like(time_s)


@dataclass(frozen=True)
class Order:
    """One axis of AXES, or one input by its column, and what is asked of it.

    Attributes:
        loop: force, share or input (open), place or speed (closed).
        signal: over time; of a zig-zag the sign is the pilot's.
        bandwidth_rad_s: of a closed loop [rad/s].
        turns_at_rad: heading to either side at which a zig-zag goes over; 0 for none [rad].
        held: whether it is a [[hold]]; must: whether a vehicle that cannot is refused.
        through: axis that is pushed instead, of a depth that is held by pitching.
        table: of the file, for messages.
    """

    target: str
    loop: str
    signal: Timed
    table: Table
    bandwidth_rad_s: float = BANDWIDTH_RAD_S
    turns_at_rad: float = 0.0
    held: bool = False
    must: bool = True
    through: str = ""

    @property
    def axis(self) -> str:
        """The axis that is pushed."""
        return self.through or self.target

    @property
    def closed(self) -> bool:
        """Whether it needs readings."""
        return self.loop not in OPEN or self.turns_at_rad > 0.0


def read_excite(table: Table, vehicle: Vehicle) -> Order:
    """One [[excite]]; InputError names file and key."""
    if table.either("axis", "input") == "axis":
        target = table.choice("axis", AXES)
        loops = LINEAR if target in AXES[:3] else ANGULAR
    else:
        fins = [fin.column for fin in vehicle.fins if fin.limit_rad]
        target = table.choice("input", tuple([*(t.column for t in vehicle.thrusters), *fins]))
        loops = INPUT
    kind = table.choice("kind", (*SIGNALS, "zigzag", "spiral"))
    word = "amplitudes" if kind == "multisine" else "amplitude"
    alone = kind in ("zigzag", "spiral")
    endings = [ending for ending, loop in loops.items() if loop in OPEN or not alone]
    ending = table.either(*(word + ending for ending in endings)).removeprefix(word)
    order = Order(
        target=target,
        loop=loops[ending],
        signal=_turning(table, kind, word + ending) if alone else read_signal(table, ending),
        table=table,
        bandwidth_rad_s=_bandwidth(table) if loops[ending] not in OPEN else BANDWIDTH_RAD_S,
        turns_at_rad=table.positive("heading_rad", None, np.pi) if kind == "zigzag" else 0.0,
    )
    table.close()
    return order


def _turning(table: Table, kind: str, key: str) -> Timed:
    """A spiral, or the steady value of a zig-zag."""
    size = table.positive(key, None, 1.0 if key.endswith("_share") else 1e6)
    if kind == "zigzag":
        return Excitation("station", "force", (), offset=size)
    return Spiral(size, table.integer("levels", 9, 2, 1000), table.positive("dwell_s"))


def read_hold(table: Table) -> Order:
    """One [[hold]]; InputError names file and key."""
    axis = table.choice("axis", AXES)
    place, speed = ("at_m", "speed_m_s") if axis in AXES[:3] else ("at_rad", "speed_rad_s")
    loop = "speed" if speed in table.entries else "place"
    if loop == "speed":
        table.either(place, speed)
    order = Order(
        target=axis,
        loop=loop,
        signal=Excitation("station", "position", (), offset=table.number(speed if loop == "speed" else place, 0.0)),
        table=table,
        bandwidth_rad_s=_bandwidth(table),
        held=True,
        must=table.choice("otherwise", ("refuse", "leave"), "refuse") == "refuse",
    )
    table.close()
    return order


def _bandwidth(table: Table) -> float:
    return table.positive("bandwidth_rad_s", BANDWIDTH_RAD_S, 100.0)


def check_orders(orders: tuple[Order, ...]) -> None:
    """InputError where an axis has two loops."""
    for number, order in enumerate(orders):
        if order.loop not in OPEN and (order.target, True) in [(o.target, o.loop not in OPEN) for o in orders[:number]]:
            raise order.table.error("axis", f"{order.target} is held or moved in closed loop already; expected it once")
