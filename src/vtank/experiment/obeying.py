"""Which orders a vehicle can obey, and how: by thrusters, or a depth by its pitch, on what its instruments measure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import InputError
from ..plant.vehicle import AXES, Vehicle
from .allocation import Allocation
from .orders import OPEN, Order
from .sensing import Sensing

UNDER_WAY_M_S = 1.0  # [m/s] speed that is foreseen where a force or an input may bring any; a choice
TIMES = 1000  # at which the ordered speed is looked up; a choice


def obeyed(
    vehicle: Vehicle, model: Any, orders: Sequence[Order], sensing: Sensing, duration_s: float
) -> tuple[Order, ...]:
    """The orders that are obeyed, in their order; InputError names one that must be and cannot, and why.

    model: of `tank.load_whole`. Those that may be left are left where they cannot be obeyed with all the others.
    """
    kept: list[Order] = []
    way = _way(orders, duration_s)
    for order in sorted(orders, key=_before_others):
        if found := _by_itself(vehicle, model, order, sensing, way):
            axes = sorted({o.axis for o in [*kept, found] if o.axis in AXES}, key=AXES.index)
            twice = any(o.axis == found.axis and {o.loop, found.loop}.isdisjoint(OPEN) for o in kept)
            if not twice and all(Allocation(vehicle, model, axes).able(axis, way) for axis in axes):
                kept.append(found)
            elif order.must:
                raise _cannot(order, f"cannot push along {order.target} beside the other ordered axes", vehicle)
    places = {order.table.name: i for i, order in enumerate(orders)}
    return tuple(sorted(kept, key=lambda order: places[order.table.name]))


def _way(orders: Sequence[Order], duration_s: float) -> float:
    """The highest speed ahead that is ordered [m/s], by which fins can be asked for a moment."""
    if any(order.loop in OPEN and (order.target == "surge" or order.target not in AXES) for order in orders):
        return UNDER_WAY_M_S
    ticks = np.linspace(0.0, duration_s, TIMES)
    ahead = [order.signal for order in orders if (order.target, order.loop) == ("surge", "speed")]
    return float(max((np.max(signal.command(ticks, duration_s)[0]) for signal in ahead), default=0.0))


def _before_others(order: Order) -> tuple[bool, int]:
    """What must be obeyed comes first, then depth before the pitch that it may take."""
    return not order.must, AXES.index(order.target) if order.target in AXES else 0


def _by_itself(vehicle: Vehicle, model: Any, order: Order, sensing: Sensing, way: float) -> Order | None:
    """The order, or how it can be obeyed if it is the only one; None where it may be left."""
    if order.target in AXES:
        own = Allocation(vehicle, model, [order.target])
        if not own.able(order.target, way):
            if (order.target, order.loop) != ("heave", "place") or not own.steers("pitch"):
                if order.must:
                    raise _cannot(order, f"cannot push along {order.target} alone", vehicle)
                return None
            order = replace(order, through="pitch")
    if missing := sensing.missing(order):
        if order.must:
            what = f"{order.target} needs {missing}, which no sensor of {vehicle.name} measures"
            raise order.table.error("axis" if order.target in AXES else "kind", what)
        return None
    return order


def _cannot(order: Order, what: str, vehicle: Vehicle) -> InputError:
    fins = "; its fins turn it under way only" * bool(vehicle.fins)
    return order.table.error("axis", f"the thrusters of {vehicle.name} {what}{fins}")
