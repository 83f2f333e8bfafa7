"""A hypothesis about a whole vehicle, fitted: own parameters and effects at places, their evidence at given gains.

Evidence is Laplace's at the optimum of innovations and priors (`estimate.optimum`'s cost), with the gains of one filter
for all that are compared, so that no hypothesis can hide misfit in noise of its own.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...rigid.filtered import Filtered, Noise
from ...rigid.fit import Fit, level
from ...rigid.layout import Layout
from ...rigid.noise import FIRST_SIGMA, against
from ...rigid.places import Parameter, Placed
from ...rigid.tangent import Path
from ..bounds import within
from .descent import PROMISE, descend, strayed
from .own import Unknown
from .unfinished import digest, step

Array = NDArray[np.float64]
STEPS = 16  # of a fit, at most
VISIBLE = 0.02  # of what is usual at its place, below which nobody would call anything a gap; a choice
PLAIN = 50.0  # log likelihood from which it is a gap all the same: ten deviations of the noise; a choice
LED = 2.0  # square of the residuals, over their number, from which a fit is led to where it begins; a choice
LEADS = (1.0, 0.1)  # shares of the disturbances that a search begins with, by which it is led; choices
ROUGHLY = 1e-3  # log-likelihood of each measurement that a step of a fit that is led must promise; a choice
RUNS_AWAY = 1e100  # [deviations] from which a linearised motion has run away, and tells nothing


def effect_unknowns(layout: Layout, placed: Placed) -> list[Unknown]:
    """The numbers of an effect that are free."""
    return [_unknown(layout, placed, number) for number in placed.parameters if number.scale > 0.0]


def _unknown(layout: Layout, placed: Placed, number: Parameter) -> Unknown:
    at = layout.at(number.slots)
    base = layout.null[at] if np.isfinite(number.null) else np.zeros(at.size)
    name, step = f"{placed.name}.{number.name}", 1e-3 * number.scale
    return Unknown(name, at, base, number.scale, number.low, number.high, step, factor=number.factor)


@dataclass(frozen=True, eq=False)
class Model:
    """Effects at places beside own parameters, with the values found.

    Attributes:
        fit: runs and noise.
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
    def strained(self) -> float:
        """Half the sum of squared prior deviations of own parameters."""
        own = [u.name.rpartition(".")[0] not in self.names for u in self.unknowns]
        return 0.5 * float(np.sum(self._off[own] ** 2))

    @property
    def pulled(self) -> float:
        """Half the sum of squared prior deviations of all unknowns."""
        return 0.5 * float(np.sum(self._off**2))

    @property
    def _off(self) -> Array:
        """Prior deviations of the unknowns, (U,)."""
        return self.theta / np.array([u.scale for u in self.unknowns])

    @property
    def names(self) -> tuple[str, ...]:
        """Of the effects."""
        return tuple(placed.name for placed in self.effects)

    def strayed(self, theta: Array) -> bool:
        """Whether the first unknowns are farther from theta, (N,), than they can be told apart, all of them taken."""
        if self.information is None:
            return False
        return strayed(self.theta[: theta.size] - theta, self.information[: theta.size, : theta.size])

    def tiny(self, placed: Placed) -> bool:
        """Whether all free numbers of an effect are below VISIBLE of what is usual: of timing, mounting, form of a law.

        No simulator and no recording agree with one another more closely than that.
        """
        off = [self._off[i] for i, u in enumerate(self.unknowns) if u.name.rpartition(".")[0] == placed.name]
        return bool(off) and max(map(abs, off)) < VISIBLE

    def values(self, placed: Placed) -> dict[str, tuple[float, float]]:
        """Numbers of an effect and their standard deviations, by name; a fixed one has 0."""
        found = {}
        sd = self.sd
        for number in placed.parameters:
            for i, unknown in enumerate(self.unknowns):
                if unknown.name == f"{placed.name}.{number.name}":
                    value = float(number.moved(number.null, float(self.theta[i])))
                    found[number.name] = value, float(sd[i]) * (value if number.factor else 1.0)
            if number.scale == 0.0:
                found[number.name] = number.starts[0], 0.0
        return found


def _vector(fixed: Array, unknowns: Sequence[Unknown], theta: Array) -> Array:
    p = fixed.copy()
    for unknown, value in zip(unknowns, theta, strict=True):
        now = p[unknown.slots]  # two unknowns of one slot add up: drag the file has wrong, and drag it has not
        now = np.where(np.isfinite(now), now, unknown.base)
        p[unknown.slots] = now * np.exp(value) if unknown.factor else now + value
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


def slopes(model: Model, paths: Sequence[Path]) -> Array:
    """Derivative of the residuals with respect to a model's unknowns along the paths, (sum M, U)."""
    side = _sides(model.unknowns, model.theta)
    moved = [model.vector(model.theta + side * (np.arange(side.size) == i)) for i in range(side.size)]
    changed = model.fit.answers(paths, moved)
    changed /= side
    for column in changed.T:  # in place, one after the other: all of them are large
        if not np.abs(column).max() < RUNS_AWAY:
            column[:] = 0.0
    return changed


def _sides(unknowns: Sequence[Unknown], theta: Array) -> Array:
    """Steps of finite differences; against a bound, from within."""
    step, high = np.array([u.step for u in unknowns]), np.array([u.high for u in unknowns])
    return np.asarray(np.where(theta + step > high, -step, step))


def refit(
    model: Model, found: Sequence[Filtered], theta: Array, held: Array | None = None, steps: int = STEPS,
    least: float = -np.inf,
) -> Model:  # fmt: skip
    """Levenberg-Marquardt with the gains held, from theta; evidence at the end.

    held: derivative with respect to the first unknowns, (sum M, H), which is not made anew: own parameters hardly move.
    By default all are made at once, along paths, and anew where the fit has gone farther than it can tell apart.
    least: log evidence that it has to reach; where it promises to stay below, it goes no further.
    """

    def told() -> str:
        numbers = [np.array([getattr(u, part) for u in model.unknowns]) for part in ("scale", "low", "high", "step")]
        bases = [part for u in model.unknowns for part in (u.name, u.slots, u.base)]
        seen = [part for f in found for part in (f.p, f.innovation, f.variance, f.wall)]
        first = np.empty(0) if held is None else held.sum(axis=0)
        return digest(["refit", model.names, steps, least, model.fixed, theta, first, *numbers, *bases, *seen])

    def plain(fitted: Model) -> list[Any]:
        information = fitted.information
        return [fitted.theta.tolist(), fitted.cost, fitted.log_evidence,
                None if information is None else information.tolist()]  # fmt: skip

    def again(filed: list[Any]) -> Model:
        theta, cost, evidence, information = filed
        information = None if information is None else np.array(information).reshape(len(theta), len(theta))
        return replace(model, theta=np.array(theta), cost=cost, log_evidence=evidence, information=information)

    return step(told, lambda: _fitted(model, found, theta, held, steps, least), plain, again)


def _fitted(
    model: Model, found: Sequence[Filtered], theta: Array, held: Array | None, steps: int, least: float
) -> Model:
    scale, low, high = (np.array([getattr(u, part) for u in model.unknowns]) for part in ("scale", "low", "high"))
    if held is None and steps:
        theta = _led(model, found, theta, steps)
    theta, e, J = _descended(model, found, theta, held, steps, level(found) - least)
    weight = scale**-2.0
    cost = 0.5 * float(e @ e + np.sum(weight * theta * theta))
    inner = J.T @ J
    H, inside = inner + np.diag(weight), (theta > low) & (theta < high)
    occam = 0.5 * float(np.linalg.slogdet(np.eye(theta.size) + inner * np.outer(scale, scale))[1])
    covariance = np.asarray(np.linalg.inv(H), dtype=np.float64)
    cut = within(theta, J.T @ e + weight * theta, covariance, low, high, 0.0, scale)
    evidence = level(found) - cost - occam + cut + _sparing(model, theta, covariance, inside)
    evidence -= against(model.fit)
    return replace(model, theta=theta, cost=cost, information=H, log_evidence=evidence)


def _descended(
    model: Model, found: Sequence[Filtered], theta: Array, held: Array | None, steps: int,
    enough: float = np.inf, promise: float = PROMISE,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """`descend` by the gains of a filter; held: as of `refit`."""
    unknowns = model.unknowns
    scale, low, high = (np.array([getattr(u, part) for u in unknowns]) for part in ("scale", "low", "high"))

    def residual(at: Array) -> Array:
        return model.fit.residuals([model.vector(at)], found)[:, 0]

    def differentiated(at: Array, e: Array) -> Array:
        if held is None:
            now = replace(model, theta=at)
            return slopes(now, model.fit.paths(now.vector(), found))
        side, first = _sides(unknowns, at), held.shape[1]
        if first == at.size:
            return held
        moved = [model.vector(at + side * (np.arange(at.size) == i)) for i in range(first, at.size)]
        return np.hstack([held, (model.fit.residuals(moved, found) - e[:, None]) / side[first:]])

    return descend(
        residual, differentiated, theta, scale, (low, high), steps, held is not None, enough=enough, promise=promise
    )


def _led(model: Model, found: Sequence[Filtered], theta: Array, steps: int) -> Array:
    """Where a fit begins: at theta or, where that is far off, where fits lead whose filters follow the recordings.

    A simulation that nothing holds to what was measured goes astray by all that its parameters are off, in ways that
    no slope foretells; one that is led needs no more than their forces. It is led less and less.
    """
    noise = model.fit.noise

    def off(at: Array) -> float:
        e = model.fit.residuals([model.vector(at)], found)
        return float(np.sum(e * e)) / len(e)

    before, led = off(theta), theta
    if not theta.size or before < LED:
        return theta
    for share in LEADS:
        stirred = np.where(noise.sigma > 0.0, share * FIRST_SIGMA, 0.0)
        fit = replace(model.fit, noise=replace(noise.even, sigma=stirred, flows=False))
        try:
            there = fit.filter(model.vector(led))
        except InputError:
            break
        promise = ROUGHLY * sum(f.innovation.size for f in there)
        led = _descended(replace(model, fit=fit), there, led, None, steps // len(LEADS), promise=promise)[0]
    return led if off(led) < before else theta


def _sparing(model: Model, theta: Array, covariance: Array, inside: NDArray[np.bool_]) -> float:
    """Gain of log evidence, as some components of a vector are as likely nothing as not; covariance: (U, U)."""
    place, gain = {u.name: i for i, u in enumerate(model.unknowns)}, 0.0
    for placed in model.effects:
        free = [number for number in placed.parameters if number.scale > 0.0]
        some = [place[f"{placed.name}.{number.name}"] for number in free if number.optional]
        some = [i for i in some if inside[i]]
        if len(free) > 1 and some:
            scale = np.array([model.unknowns[i].scale for i in some])
            gain += sparing(theta[some], covariance[np.ix_(some, some)], scale, len(some) == len(free))
    return gain


def sparing(value: Array, covariance: Array, scale: Array, needed: bool) -> float:
    """Log mean, over sets of components that are nothing, of the evidence over that of all being free.

    value, (K,), and covariance, (K, K), with all free; scale: prior deviations, (K,); needed: whether one must be
    something. The ratio is of the densities at nothing (Dickey, Ann. Math. Stat. 42, 1971), each set as likely.
    """
    gains = [0.0]
    for size in range(1, value.size if needed else value.size + 1):
        for gone in itertools.combinations(range(value.size), size):
            at = list(gone)
            inner, off = covariance[np.ix_(at, at)], value[at]
            spread = float(np.linalg.slogdet(inner)[1])
            gains.append(
                -0.5 * float(off @ np.linalg.solve(inner, off)) - 0.5 * spread + float(np.sum(np.log(scale[at])))
            )
    return float(np.logaddexp.reduce(gains) - np.log(len(gains)))


def even(model: Model, column: int | None = None) -> list[tuple[Model, list[Filtered]]]:
    """The refit as if a column (default: any) had no slow errors, which may stand for what a model lacks.

    With the innovations that go with it; nothing where there are none.
    """
    noise, slow = model.fit.noise, model.fit.noise.slow
    calm = np.zeros(slow.size, bool) if column is None else np.arange(slow.size) != column
    if not slow[~calm].any():
        return []
    return [at_noise(model, replace(noise, slow=np.where(calm, slow, 0.0)))]


def at_noise(model: Model, noise: Noise) -> tuple[Model, list[Filtered]]:
    """The refit at another noise, with the innovations that go with it."""
    fit = replace(model.fit, noise=noise)
    there = fit.filter(model.vector())
    return refit(replace(model, fit=fit), there, model.theta), there
