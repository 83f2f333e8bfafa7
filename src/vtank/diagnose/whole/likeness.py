"""How like a simulator of a whole vehicle its plant is, by column, and what was fitted."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ...plant.vehicle import Vehicle
from ...record.columns import channel_of
from ...rigid.fit import Fit
from ...rigid.layout import AXES, Layout, masses
from ...rigid.recorded import Recorded
from ..likeness import Likeness
from .budget import STRETCH_S, free_errors
from .curves import Bend
from .model import Model, blank

Array = NDArray[np.float64]
SIMULATED = "simulated "  # before an instrument of the recordings that stands for columns of a simulator
TOLD = 3.0  # deviations of the recordings' noise that a column must move by to tell something; a choice


def likeness(fit: Fit, noise: Array, folder: str, found: tuple[tuple[str, float, float], ...]) -> Likeness:
    """Error of free simulation through stretches, and what a column does in as long a time.

    fit: runs of the simulator with the plant as their nominal. noise: variance that recordings have in each column,
    (C,), infinite where they have none like it; where they have none at all, every column tells something.
    """
    runs = fit.runs
    layout = runs[0].layout
    squares, counts = (part.sum(axis=0) for part in free_errors(blank(fit, layout, (), [])))
    columns, shares = {}, []
    for c, name in enumerate(layout.columns):
        if not layout.judged[c]:
            continue
        moves = float(np.sqrt(np.mean(np.concatenate([_about_mean(run, c) for run in runs]) ** 2)))
        error = float(np.sqrt(squares[c] / max(counts[c], 1)))
        columns[channel_of(name)] = {"error": error, "moves": moves}
        if moves > TOLD * np.sqrt(noise[c]) or (np.isinf(noise).all() and moves > 0.0):
            shares.append(error / moves)
    share = float(np.sqrt(np.mean(np.square(shares)))) if shares else 1.0
    return Likeness(folder, tuple(run.name for run in runs), columns, share, found)


def _about_mean(run: Recorded, c: int) -> Array:
    """Values of a column about their means over stretches of time."""
    time, value = run.time_s[run.column == c], run.value[run.column == c]
    part = ((time - run.time_s[0]) / STRETCH_S).astype(int)
    return np.asarray(value - (np.bincount(part, value) / np.maximum(np.bincount(part), 1))[part])


def parameters(
    file: Layout, vehicle: Vehicle, model: Model, free: Sequence[Bend]
) -> Iterator[tuple[str, float, float]]:
    """Name, the file's number, and the fitted one; body and water together, and of curves the force at some inputs.

    vehicle: with the curves that were found.
    """
    layout, p, every = model.fit.runs[0].layout, model.vector(), np.ones(6, bool)
    before, after = (np.diag(np.add(*masses(q, every)[:2])) for q in (file.null, p))
    for unknown in model.unknowns:
        quantity, _, place = unknown.name.partition("@")
        slot = layout.names[unknown.slots[0]]
        if quantity == "added_mass" and place in AXES:
            i = AXES.index(place)
            yield f"moving_mass@{place}", float(before[i]), float(after[i])
        elif slot in file.slots:
            yield unknown.name.replace(SIMULATED, ""), float(file.null[file.slot(slot)]), float(p[layout.slot(slot)])
    given, found = ({t.name: t for t in v.thrusters} for v in (file.vehicle, vehicle))
    for bend in free:
        name, asked = bend.names[0], np.array([bend.at])
        before_N, after_N = (float(t[name].force_N(asked)[0]) for t in (given, found))
        yield f"force_N@{name}:{bend.at:.3g}", before_N, after_N
