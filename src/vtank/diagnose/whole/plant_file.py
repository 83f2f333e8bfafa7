"""A plant that stands for a simulator, in a model file and back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...plant.vehicle import Vehicle
from ...record.table import Table
from ...rigid.flow import Flow, terms
from ...rigid.layout import AXES
from .against import Plant
from .curves import KNOTS, Bend


def plant_lines(plant: Plant) -> Iterator[str]:
    """Lines of the table [plant]."""
    moving = [AXES[i] for i in np.flatnonzero(plant.flow.most > 0.0)]
    yield "[plant]  # in place of the vehicle file's numbers, as fitted to a simulator's own runs"
    yield f"sigma = {_row(plant.sigma)}"
    yield "[plant.inputs]"
    yield from (f'"{name}" = "{column}"' for name, column in plant.inputs.items())
    yield "[plant.fitted]"
    yield from (f'"{name}" = {value:.12g}' for name, value in plant.fitted.items())
    for names in dict.fromkeys(bend.names for bend in plant.curves):
        some = {bend: force for bend, force in plant.curves.items() if bend.names == names}
        first = next(iter(some))
        yield "[[plant.curve]]  # corrections of the force at some multiples of `step`"
        yield f"thrusters = [{', '.join(f'{chr(34)}{name}{chr(34)}' for name in names)}]"
        yield f"step = {first.step:.12g}"
        yield f"knots = {_row(first.knots)}"
        yield f"force_N = {_row(list(some.values()))}"
    yield "[plant.flow]  # sizes of the terms of rigid/flow.py [N, N m], over usual speeds"
    yield f"axes = [{', '.join(f'{chr(34)}{axis}{chr(34)}' for axis in moving)}]"
    yield f"usual = {_row(plant.flow.usual)}"
    yield f"most = {_row(plant.flow.most)}"
    yield f"slower = {_row(plant.flow.slower)}"
    yield f"centre_m = {_row(plant.flow.centre)}"
    yield from (f"{axis} = {_row(row)}" for axis, row in zip(AXES, plant.flow.sizes, strict=True))


def _row(values: Sequence[float] | np.ndarray) -> str:
    return f"[{', '.join(f'{float(v):.12g}' for v in values)}]"


def read_plant(table: Table, vehicle: Vehicle, axes: tuple[str, ...]) -> Plant:
    """The plant of the table [plant]; InputError names file and key of what is wrong."""
    curves: dict[Bend, float] = {}
    for curve in table.tables("curve"):
        names, step = curve.texts("thrusters"), curve.positive("step")
        knots = tuple(int(n) for n in curve.numbers("knots", -KNOTS, KNOTS))
        for knot, force in zip(knots, curve.numbers("force_N"), strict=False):
            curves[Bend(names, step, knots, knot)] = force
    part, fitted, inputs = table.table("flow"), table.table("fitted"), table.table("inputs")
    found = terms([AXES.index(axis) for axis in part.texts("axes") if axis in AXES])
    sizes = {axis: part.numbers(axis) for axis in AXES}
    for axis, row in sizes.items():
        if len(row) != found.shape[0]:
            raise part.error(axis, f"expected {found.shape[0]} numbers, found {len(row)}")
    usual, most, slower = (np.array(part.numbers(key, 0.0)) for key in ("usual", "most", "slower"))
    centre = np.array(part.numbers("centre_m"))
    if centre.size != 3:
        raise part.error("centre_m", f"expected 3 numbers, found {centre.size}")
    return Plant(
        file=vehicle, axes=axes, curves=curves, fitted={name: fitted.number(name) for name in fitted.entries},
        flow=Flow(found, np.array(list(sizes.values())), usual, most, slower, centre),
        inputs={name: inputs.text(name) for name in inputs.entries},
        sigma=np.array(table.numbers("sigma", 0.0)),
    )  # fmt: skip
