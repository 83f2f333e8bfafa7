"""Forces of a simulator's flow fitted beside the own numbers of its plant, in steps of both together.

Each step is a least square of what residuals are to first order; a flow's sizes are normally distributed about zero, at
the likeliest width of each axis.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import lsq_linear

from ...rigid.flow import Flow, values
from ...rigid.layout import NOSE, TAIL
from ...rigid.recorded import relaid
from ...rigid.tangent import Path, follow_lanes
from .model import Model
from .score import Base, based
from .simulator import Usual

Array = NDArray[np.float64]
WIDTHS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0)  # of what a flow's terms do, as shares of an axis' usual force; choices
SWEEPS = 2  # over the axes, for their widths; a choice
LEAST = 1e-3  # of a term as it goes, below which it is not told from none; a choice
PARTS = (1.0, 0.5, 0.25, 0.1)  # of a step, which are tried; choices
AWAY, FARTHEST = 0.05, 6.0  # of the length, by which the centre of a hull may be off, and times that, at most; guesses
MOVED_M = 1e-3  # [m] by which it is moved to see what that does
STEPS, WORTH = 4, 1.0  # towards the flow, at most, and log-likelihood that each must gain; choices


def flowing(model: Model, did: Usual) -> Model:
    """The model and the flow beside it, after steps towards the likeliest of both."""
    for _ in range(STEPS):
        before, model = model, stepped(model, did)
        if model is before:
            break
    return model


def stepped(model: Model, did: Usual) -> Model:
    """Own numbers, centre and sizes of the flow, as far towards the likeliest as that takes off; or the model itself.

    Numbers are counted in deviations of their priors, sizes in shares of the usual force that a term makes as it goes.
    """
    found = model.fit.filter(model.vector())
    base, asked, layout = based(model, found), np.flatnonzero(model.fit.runs[0].asked), model.fit.runs[0].layout
    columns, unit = termwise(base, did, asked, layout.flow)
    away = AWAY * float(layout.null[NOSE] - layout.null[TAIL])
    numbers = [(u.scale, u.low, u.high) for u in model.unknowns] + 3 * [(away, -FARTHEST * away, FARTHEST * away)]
    scale, low, high = np.array(numbers).T
    now = np.concatenate([model.theta, layout.flow.centre]) / scale
    here = np.concatenate([now, layout.flow.sizes[asked].ravel() / unit])
    own, axis = scale.size, np.repeat(np.arange(asked.size), layout.flow.terms.shape[0])
    K = np.hstack([base.J * scale[:-3], centred(base, layout.flow) * away, columns])
    H, slope = K.T @ K, K.T @ base.e
    b = H @ here - slope
    ends, push = (low / scale, high / scale), slope[:own] + here[:own]
    held = ((here[:own] <= ends[0]) & (push > 0.0)) | ((here[:own] >= ends[1]) & (push < 0.0))
    width = likeliest(*beside(H, b, here, ~held), axis)[axis]
    weight = np.concatenate([np.ones(own), width**-2.0])
    x = bounded(H + np.diag(weight), b, *ends)

    def at(x: Array) -> Model:
        sizes = layout.flow.sizes.copy()
        sizes[asked] = (x[own:] * unit).reshape(asked.size, -1)
        theta, centre = np.split(np.clip(x[:own] * scale, low, high), [own - 3])
        _, runs = relaid(layout, model.fit.runs, flow=layout.flow.sized(sizes).about(centre))
        return replace(model, fit=replace(model.fit, runs=runs), theta=theta)

    def cost(x: Array) -> float:
        trial = at(x)
        e = trial.fit.residuals([trial.vector()], found)[:, 0]
        return 0.5 * float(e @ e + weight @ (x * x))

    least = cost(here)
    for part in PARTS:
        there = here + part * (x - here)
        if cost(there) < least - WORTH:
            return at(there)
    return model


def termwise(base: Base, did: Usual, asked: NDArray[np.int64], flow: Flow) -> tuple[Array, Array]:
    """What each term does on each axis to the residuals, (M, A Q), and its sizes [N, N m] that do that, (A Q,).

    They make the usual force of the axis, root mean square.
    """
    along = [np.empty((path.way.states.shape[0] - 1, flow.terms.shape[0])) for path in base.paths]
    for path, term in zip(base.paths, along, strict=True):
        states = path.way.states[:, 6:12]
        values(0.5 * (states[1:] + states[:-1]), flow, term)
    usually = np.maximum(np.sqrt(np.mean(np.concatenate(along) ** 2, axis=0)), LEAST)
    unit = (did.force[asked, None] / usually).ravel()
    out = np.empty((base.e.size, unit.size))

    def pushed(path: Path, term: Array, some: slice) -> tuple[Array, Array]:
        axis, which = np.divmod(np.arange(some.start, some.stop), usually.size)
        toward = unit[some] * path.hull.inverse[:, asked[axis]]
        return term[:, None, which] * toward, np.zeros((path.run.time_s.size, which.size))

    causes = [partial(pushed, path, term) for path, term in zip(base.paths, along, strict=True)]
    follow_lanes(base.paths, causes, out)
    return out, unit


def centred(base: Base, flow: Flow) -> Array:
    """What moving the centre of the hull does to the residuals, (M, 3) [1/m]."""

    def wrench(nu: Array, flow: Flow) -> Array:
        terms = np.empty((nu.shape[0], flow.terms.shape[0]))
        values(nu, flow, terms)
        return np.asarray(terms @ flow.sizes.T)

    parts = []
    for path in base.paths:
        states = path.way.states[:, 6:12]
        nu, moved = 0.5 * (states[1:] + states[:-1]), flow.centre + MOVED_M * np.eye(3)
        here = wrench(nu, flow)
        pushes = [(wrench(nu, flow.about(c)) - here) @ path.hull.inverse.T for c in moved]
        push = np.where(path.run.moves, np.stack(pushes) / MOVED_M, 0.0).transpose(1, 2, 0)
        parts.append(path.follow(push, np.zeros((path.run.time_s.size, 3))))
    return np.concatenate(parts)


def beside(H: Array, b: Array, here: Array, free: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Normal equations of the sizes, with the own numbers that are free taken up within priors of deviation 1."""
    own, some = free.size, np.flatnonzero(free)
    b = b - H[:, :own][:, ~free] @ here[:own][~free]
    inner = H[np.ix_(some, some)] + np.eye(some.size)
    taken = np.linalg.solve(inner, np.column_stack([H[some, own:], b[some]]))
    return H[own:, own:] - H[own:, some] @ taken[:, :-1], b[own:] - H[own:, some] @ taken[:, -1]


def likeliest(G: Array, b: Array, axis: NDArray[np.int64]) -> Array:
    """Width of the normal distribution of the sizes of each axis.

    G, b: normal equations of the sizes, (Q, Q), (Q,). axis: of each, from 0 on, (Q,).
    """

    def gain(widths: Array) -> float:
        s = widths[axis]
        factor = np.linalg.cholesky(np.eye(s.size) + s[:, None] * G * s)
        half = solve_triangular(factor, s * b, lower=True)
        return float(half @ half) - 2.0 * float(np.sum(np.log(np.diag(factor))))

    axes = np.arange(int(axis.max()) + 1)
    widths = max((np.full(axes.size, width) for width in WIDTHS), key=gain)
    for k in np.tile(axes, SWEEPS):
        widths = max((np.where(axes == k, width, widths) for width in WIDTHS), key=gain)
    return widths


def bounded(H: Array, b: Array, low: Array, high: Array) -> Array:
    """The least of x'Hx / 2 - b'x, (U,), where the first unknowns lie within bounds, and the others anywhere.

    The others are taken up first, so that bounds are sought among the few that have them.
    """
    own = low.size
    factor = np.linalg.cholesky(H[own:, own:])
    taken = solve_triangular(factor, np.column_stack([H[own:, :own], b[own:]]), lower=True)
    inner = np.linalg.cholesky(H[:own, :own] - taken[:, :-1].T @ taken[:, :-1])
    target = solve_triangular(inner, b[:own] - taken[:, :-1].T @ taken[:, -1], lower=True)
    first = np.asarray(lsq_linear(inner.T, target, (low, high), method="bvls").x)
    others = solve_triangular(factor, taken[:, -1] - taken[:, :-1] @ first, lower=True, trans="T")
    return np.concatenate([first, others])
