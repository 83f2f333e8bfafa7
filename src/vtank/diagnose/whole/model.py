"""A hypothesis about a whole vehicle, fitted: own parameters and effects at places, their evidence at given gains.

Evidence is Laplace's at the optimum of innovations and priors (`estimate.optimum`'s cost), with the gains of one filter
for all that are compared, so that no hypothesis can hide misfit in noise of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...rigid.filtered import Filtered
from ...rigid.fit import Fit
from ...rigid.layout import AXES, Layout
from ...rigid.places import OWN_OF_AXIS, OWN_OF_THRUSTERS, Parameter, Placed

Array = NDArray[np.float64]
STEPS = 8  # of a fit, at most
PROMISE = 0.02  # log-likelihood that a further step must promise


@dataclass(frozen=True)
class Unknown:
    """One unknown of a fit: slots that it moves, what it is added to there, prior and bounds about 0 change."""

    name: str
    slots: NDArray[np.int64]
    base: Array
    scale: float
    low: float
    high: float
    step: float


def own_unknowns(layout: Layout, asked: NDArray[np.bool_]) -> list[Unknown]:
    """Drag, added mass, gain of all thrusters and their lag, each where the vehicle file has one."""
    p, found = layout.null, []
    groups = {f"{q}@{axis}": [f"{q}@{axis}"] for i, axis in enumerate(AXES) if asked[i] for q in OWN_OF_AXIS}
    groups |= {f"{q}@thrusters": [f"{q}@{push.name}" for push in layout.pushes] for q in OWN_OF_THRUSTERS}
    for name, slots in groups.items():
        at = layout.at(slots)
        at = at[p[at] > 0.0]
        if at.size:
            share = (OWN_OF_AXIS | OWN_OF_THRUSTERS)[name.partition("@")[0]]
            size = float(np.mean(p[at]))
            found.append(Unknown(name, at, p[at], share * size, -0.95 * size, 20.0 * size, 1e-3 * size))
    return found


def effect_unknowns(layout: Layout, placed: Placed) -> list[Unknown]:
    """The numbers of an effect that are free."""
    return [_unknown(layout, placed, number) for number in placed.parameters if number.scale > 0.0]


def _unknown(layout: Layout, placed: Placed, number: Parameter) -> Unknown:
    at = layout.at(number.slots)
    base = layout.null[at] if np.isfinite(number.null) else np.zeros(at.size)
    return Unknown(f"{placed.name}.{number.name}", at, base, number.scale, number.low, number.high, 1e-3 * number.scale)


@dataclass(frozen=True, eq=False)
class Model:
    """Effects at places beside own parameters, with the values found.

    Attributes:
        fit: runs, noise and fixed parameters. own: whether own parameters are free.
        effects: at places. unknowns: free numbers; theta: their changes. fixed: vector with what is not free.
        cost: half the sum of squared innovations and prior deviations. log_evidence: up to what all share.
        information: of the unknowns, prior included.
    """

    fit: Fit
    effects: tuple[Placed, ...]
    unknowns: tuple[Unknown, ...]
    theta: Array
    fixed: Array
    cost: float = np.inf
    log_evidence: float = -np.inf
    information: Array | None = None

    def vector(self, theta: Array | None = None) -> Array:
        """Parameters, (P,)."""
        return _vector(self.fixed, self.unknowns, self.theta if theta is None else theta)

    @property
    def sd(self) -> Array:
        """Standard deviations of theta."""
        if self.information is None or not self.theta.size:
            return np.zeros(self.theta.size)
        return np.asarray(np.sqrt(np.diag(np.linalg.inv(self.information))))

    @property
    def names(self) -> tuple[str, ...]:
        """Of the effects."""
        return tuple(placed.name for placed in self.effects)

    def values(self, placed: Placed) -> dict[str, tuple[float, float]]:
        """Numbers of an effect and their standard deviations, by name; a fixed one has 0."""
        found = {}
        sd = self.sd
        for number in placed.parameters:
            for i, unknown in enumerate(self.unknowns):
                if unknown.name == f"{placed.name}.{number.name}":
                    found[number.name] = float(self.theta[i]), float(sd[i])
            if number.scale == 0.0:
                found[number.name] = number.starts[0], 0.0
        return found


def _vector(fixed: Array, unknowns: Sequence[Unknown], theta: Array) -> Array:
    p = fixed.copy()
    for unknown, value in zip(unknowns, theta, strict=True):
        now = p[
            unknown.slots
        ]  # two unknowns of one slot add up: drag that the file has wrong, and drag that it has not
        p[unknown.slots] = np.where(np.isfinite(now), now, unknown.base) + value
    return p


def blank(fit: Fit, layout: Layout, effects: Sequence[Placed], own: Sequence[Unknown]) -> Model:
    """The hypothesis before it is fitted, with numbers where fits begin first."""
    fixed = layout.null.copy()
    for placed in effects:
        for number in placed.parameters:
            if number.scale == 0.0:
                fixed[layout.at(number.slots)] = layout.null[layout.at(number.slots)] + number.starts[0]
    unknowns = [*own, *(u for placed in effects for u in effect_unknowns(layout, placed))]
    numbers = [number for placed in effects for number in placed.parameters if number.scale > 0.0]
    begin = [0.0] * len(own) + [number.starts[0] if number.starts else 0.0 for number in numbers]
    return Model(fit, tuple(effects), tuple(unknowns), np.array(begin), fixed)


def refit(
    model: Model, found: Sequence[Filtered], theta: Array, held: Array | None = None, steps: int = STEPS
) -> Model:
    """Levenberg-Marquardt with the gains held, from theta; evidence at the end.

    held: derivative with respect to the first unknowns, (sum M, H), which is not made anew: own parameters hardly move.
    """
    first = 0 if held is None else held.shape[1]
    unknowns, scale = model.unknowns, np.array([u.scale for u in model.unknowns])
    low, high, step = (np.array([getattr(u, part) for u in unknowns]) for part in ("low", "high", "step"))
    weight, damping = scale**-2.0, 1e-4
    theta = np.clip(theta, low, high)

    def differentiated(at: Array) -> tuple[Array, Array]:
        side = np.where(at + step > high, -step, step)  # against a bound, from within
        moved = [at, *(at + side * (np.arange(at.size) == i) for i in range(first, at.size))]
        e = model.fit.residuals([_vector(model.fixed, unknowns, t) for t in moved], found)
        J = (e[:, 1:] - e[:, :1]) / side[first:]
        return e[:, 0], J if held is None else np.hstack([held, J])

    def cost_of(e: Array, at: Array) -> float:
        return 0.5 * float(e @ e + np.sum(weight * at * at))

    e, J = differentiated(theta)
    cost = cost_of(e, theta)
    for _ in range(steps if theta.size else 0):
        gradient, H = J.T @ e + weight * theta, J.T @ J + np.diag(weight)
        free = ~(((theta <= low) & (gradient > 0.0)) | ((theta >= high) & (gradient < 0.0)))
        move = np.zeros(theta.size)
        move[free] = -np.linalg.solve(H[np.ix_(free, free)], gradient[free])
        if -0.5 * gradient @ move < PROMISE:
            break
        trial = theta
        while -gradient @ move - 0.5 * move @ H @ move > PROMISE:
            A = H[np.ix_(free, free)] + damping * np.diag(np.diag(H)[free])
            move[free] = -np.linalg.solve(A, gradient[free])
            at = np.clip(theta + move, low, high)
            there = model.fit.residuals([_vector(model.fixed, unknowns, at)], found)[:, 0]
            if cost_of(there, at) < cost:
                trial = at
                break
            damping = max(damping, 1e-3) * 10.0
        if trial is theta:
            break
        theta, damping = trial, max(damping / 10.0, 1e-8)
        e, J = differentiated(theta)
        cost = cost_of(e, theta)
    H = J.T @ J + np.diag(weight) if theta.size else np.zeros((0, 0))
    inside = (theta > low) & (theta < high)
    whitened = np.eye(theta.size) + (J * scale).T @ (J * scale)
    occam = 0.5 * float(np.linalg.slogdet(whitened[np.ix_(inside, inside)])[1]) if inside.any() else 0.0
    return replace(model, theta=theta, cost=cost, information=H, log_evidence=-cost - occam + _bounded(unknowns))


def _bounded(unknowns: Sequence[Unknown]) -> float:
    """Log of two for every number whose prior reaches to one side only."""
    return float(np.log(2.0) * sum(u.low == 0.0 or u.high == 0.0 for u in unknowns))
