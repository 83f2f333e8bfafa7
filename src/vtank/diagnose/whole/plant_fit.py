"""The fit of a plant to a simulator's runs: unknowns by least squares, and forces of the flow in closed form with them.

The flow's sizes are normally distributed about zero at the likeliest width.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...rigid.filtered import Filtered
from ...rigid.fit import Fit
from ...rigid.flow import Flow, values
from ...rigid.layout import Layout
from ...rigid.noise import KEPT, cut, first_noise
from ...rigid.recorded import Kept, Recorded
from .curves import Bend, bends, bent
from .model import Model, blank, refit
from .score import based
from .settling import settled
from .simulator import Usual, shared, unknowns, usual

Array = NDArray[np.float64]
WIDTHS = (0.003, 0.01, 0.03, 0.1, 0.3)  # of the sizes of a flow's terms, as shares of an axis' usual force; choices
ENOUGH = 30_000  # measurements that a plant is fitted to; a choice, for the memory it takes
PARTS = (1.0, 0.5, 0.25, 0.1)  # of a step, which are tried; choices
TURNS = 2  # of flow and own parameters, each beside the other; a choice


def relaid(layout: Layout, runs: Sequence[Recorded], **changes: Any) -> tuple[Layout, tuple[Recorded, ...]]:
    """A layout with changes, and the runs in it."""
    layout = replace(layout, **changes)
    return layout, tuple(replace(run, layout=layout, _kept=Kept()) for run in runs)


@dataclass(frozen=True, eq=False)
class Begun:
    """A plant before its flow is sought: the model, what the vehicle did, and the corrections of thrusters' curves."""

    model: Model
    did: Usual
    free: list[Bend]


def begun(layout: Layout, seen: tuple[Recorded, ...], variance: Array) -> Begun:
    """The first fit of a plant to a simulator's runs.

    variance: of each column's errors below which nothing has to be met, (C,).
    """
    layout, seen = relaid(layout, cut(seen, ENOUGH), fitted=shared(layout))
    noise = first_noise(seen)
    did, noise = usual(layout, seen, replace(noise, variance=np.maximum(noise.variance, variance)))
    free = bends(layout, seen)
    layout, seen = bent(*relaid(layout, seen, flow=did.flow), free)
    model = blank(Fit(seen, noise), layout, (), unknowns(layout, seen, did, free))
    return Begun(refit(model, model.fit.filter(model.vector()), model.theta), did, free)


def fitted(first: Begun) -> Model:
    """The plant with the flow beside it, and what it misses."""
    model, variance = first.model, first.model.fit.noise.variance
    for _ in range(TURNS):
        model, _ = settled(flowing(model, first.did), variance, KEPT * variance)
    return model


def flowing(model: Model, did: Usual) -> Model:
    """The model with the flow beside it that is likeliest, as far along the way there as takes off residuals."""
    found, before = model.fit.filter(model.vector()), model.fit.runs[0].layout.flow
    flow, theta = likeliest_flow(model, found, did, before)

    def squares(trial: Model) -> float:
        e = trial.fit.residuals([trial.vector()], found)[:, 0]
        return float(e @ e)

    least = squares(model)
    for part in PARTS:
        sizes = before.sizes + part * (flow.sizes - before.sizes)
        _, runs = relaid(model.fit.runs[0].layout, model.fit.runs, flow=Flow(flow.terms, sizes, flow.usual, flow.most))
        there = model.theta + part * (theta - model.theta)
        trial = replace(model, fit=replace(model.fit, runs=runs), theta=there)
        if squares(trial) < least:
            return trial
    return model


def likeliest_flow(model: Model, found: Sequence[Filtered], did: Usual, flow: Flow) -> tuple[Flow, Array]:
    """The likeliest flow beside a model, and the model's unknowns with it, (U,)."""
    base, asked, parts = based(model, found), np.flatnonzero(model.fit.runs[0].asked), []
    for path in base.paths:
        states, along = path.way.states[:, 6:12], np.empty((path.way.states.shape[0] - 1, flow.terms.shape[0]))
        values(0.5 * (states[1:] + states[:-1]), flow, along)
        pushes = [np.outer(f, did.force[i] * path.hull.inverse[i]) for i in asked for f in along.T]
        parts.append(path.follow(np.stack(pushes, axis=-1), np.zeros((path.run.time_s.size, len(pushes)))))
    columns = np.concatenate(parts)
    gram = base.gram([np.column_stack([base.e, columns])])
    shares = likeliest(gram[1:, 1:], gram[1:, 0])
    sizes = flow.sizes.copy()
    sizes[asked] += shares.reshape(asked.size, -1) * did.force[asked, None]
    scale, low, high = (np.array([getattr(u, part) for u in model.unknowns]) for part in ("scale", "low", "high"))
    move = np.linalg.solve(base.J.T @ base.J + np.diag(scale**-2.0), base.J.T @ (columns @ shares))
    return Flow(flow.terms, sizes, flow.usual, flow.most), np.clip(model.theta - move, low, high)


def likeliest(G: Array, b: Array) -> Array:
    """Sizes, normally distributed at the likeliest width, that take the most off residuals, (Q,).

    G: inner products of what they do, (Q, Q); b: those with the residuals, (Q,).
    """
    eigen, vectors = np.linalg.eigh(0.5 * (G + G.T))
    eigen, b = np.maximum(eigen, 0.0), vectors.T @ b

    def gain(width: float) -> float:
        s2 = width**2
        return float(np.sum(s2 * b * b / (1.0 + s2 * eigen)) - np.sum(np.log1p(s2 * eigen)))

    s2 = max(WIDTHS, key=gain) ** 2
    return np.asarray(-vectors @ (s2 * b / (1.0 + s2 * eigen)))
