"""A hypothesis about a whole vehicle, fitted: own parameters and effects at places, their evidence at given gains.

Evidence is Laplace's at the optimum of innovations and priors (`estimate.optimum`'s cost), with the gains of one filter
for all that are compared, so that no hypothesis can hide misfit in noise of its own.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...plant.actuators import Fin
from ...record.columns import channel_of
from ...rigid.filtered import Filtered, Noise
from ...rigid.fit import Fit, level
from ...rigid.layout import ADDED, AXES, COUPLED, COUPLED_AT, Layout
from ...rigid.noise import against
from ...rigid.places import OWN_OF_AXIS, OWN_OF_FINS, OWN_OF_THRUSTERS, Parameter, Placed
from ...rigid.push import Push
from ...rigid.tangent import Path
from ..bounds import within
from .unfinished import digest, step

Array = NDArray[np.float64]
T = TypeVar("T", Push, Fin)
STEPS = 8  # of a fit, at most
SQUARE_RAD = 0.2  # [rad] by which a vehicle may start away from square to a wall; a guess
ROTOR = 1.0  # [-] share of the lag that is the rotor's, from none to all; a guess
PROMPT_S, TICK_S = 0.005, 0.02  # [s] by which commands act off their stamps, usually and at most; guesses
SUCTION = 0.5  # [-] of a leading edge: from that of a plate, 0, to that of a wing of great span, 1; a guess
HOLDS = 0.5  # [-] of its lift that a fin keeps beyond its stall, from none to all; a guess
LEANS = 0.5  # [-] of the part of a fin's force along the hull, from none to all; a guess
ASLANT = 1.0  # [-] of the power of the cosine with which a fin's force that has no such part goes; a guess
RATIO = 0.5  # [-] of the share of the flow's angle for which that takes a ratio of speeds, from none to all; a guess
STIFF = 0.9  # of the coupling at which added mass would weigh nothing along some direction; a guess
EACH = "own_gain"  # of a thruster beside others of its kind
VISIBLE = 0.02  # of what is usual at its place, below which nobody would call anything a gap; a choice
PLAIN = 50.0  # log likelihood from which it is a gap all the same: ten deviations of the noise; a choice
RUNS_AWAY = 1e100  # [deviations] from which a linearised motion has run away, and tells nothing
PROMISE = 0.02  # log-likelihood that a further step must promise


@dataclass(frozen=True)
class Unknown:
    """One unknown of a fit: slots that it moves, what it is added to there, prior and bounds about 0 change.

    stated: whether the vehicle file states it, whose numbers are trusted all alike.
    """

    name: str
    slots: NDArray[np.int64]
    base: Array
    scale: float
    low: float
    high: float
    step: float
    stated: bool = True


def own_unknowns(layout: Layout, asked: NDArray[np.bool_]) -> list[Unknown]:
    """Drag, added mass and its moments, gain and lag of thrusters and lift of fins of a kind, where the file has them.

    Thrusters of a kind are wrong in alike, and each by a little of its own. And what no file states: how promptly
    commands act, whether rotors lag or their force, how a wall stands, how much of their lift fins pay for with drag,
    and keep beyond their stall, whether it has a part along the hull, and how it goes with an oblique flow where not.
    """
    p, found = layout.null, []
    groups = {f"{q}@{axis}": [f"{q}@{axis}"] for i, axis in enumerate(AXES) if asked[i] for q in OWN_OF_AXIS}
    alike = {
        "gain": _groups("thrusters", layout.pushes, _kind_and_way),
        "lag": _groups("thrusters", layout.pushes, _kind),
        "lift": _groups("fins", layout.vehicle.fins, _section),
    }
    groups |= {f"{q}@{place}": [f"{q}@{name}" for name in names] for q in alike for place, names in alike[q].items()}
    for name, slots in groups.items():
        at = layout.at(slots)
        at = at[p[at] > 0.0]
        if at.size:
            share = (OWN_OF_AXIS | OWN_OF_THRUSTERS | OWN_OF_FINS)[name.partition("@")[0]]
            size = float(np.mean(p[at]))
            found.append(Unknown(name, at, p[at], share * size, -0.95 * size, 20.0 * size, 1e-3 * size))
    for k, (i, j) in enumerate(COUPLED_AT):  # moments of added mass, which the file has wrong as it has its masses
        size = abs(p[COUPLED + k])
        if size > 0.0 and (asked[i] or asked[j]):
            room = STIFF * float(np.sqrt(p[ADDED + i] * p[ADDED + j]))
            name, at = layout.names[COUPLED + k], np.array([COUPLED + k])
            low, high = min(-room - p[COUPLED + k], 0.0), max(room - p[COUPLED + k], 0.0)
            found.append(Unknown(name, at, p[at], OWN_OF_AXIS["added_mass"] * size, low, high, 1e-3 * size))
    thrusters = {thruster.name for thruster in layout.vehicle.thrusters}
    for name in (n for names in alike["gain"].values() if len(names) > 1 for n in names if n in thrusters):
        at, gain = layout.at([f"gain@{name}"]), float(p[layout.slot(f"gain@{name}")])  # beside which it is told
        share = OWN_OF_THRUSTERS[EACH] * gain
        found.append(Unknown(f"{EACH}@{name}", at, np.zeros(1), share, -0.95 * gain, 20.0 * gain, 1e-3 * gain))
    rotors = [push.name for push in layout.pushes if push.thruster and push.thruster.input != "N"
              and p[layout.slot(f"lag@{push.name}")] > 0.0]  # fmt: skip
    if rotors:
        at = layout.at([f"rotor@{name}" for name in rotors])
        known = float(p[at].max())
        found.append(Unknown("rotor@thrusters", at, p[at], ROTOR, -known, 1.0 - known, 1e-3, stated=False))
    told = [push.name for push in layout.pushes if push.thruster]
    if told:
        at = layout.at([f"delay@{name}" for name in told])
        found.append(Unknown("delay@thrusters", at, p[at], PROMPT_S, -TICK_S, TICK_S, 1e-2 * PROMPT_S, stated=False))
    for q, share, low, high in (
        ("suction", SUCTION, -SUCTION, 1.0), ("holds", HOLDS, 0.0, 1.0), ("leans", LEANS, -1.0, 0.0),
        ("aslant", ASLANT, -1.0, 1.0), ("ratio", RATIO, -1.0, 0.0),
    ):  # fmt: skip
        fins = layout.at([f"{q}@{fin.name}" for fin in layout.vehicle.fins])
        if fins.size:
            found.append(Unknown(f"{q}@fins", fins, p[fins], share, low, high, 1e-3, stated=False))
    ranges = [column for column in layout.columns if channel_of(column) == "range_m"]
    for sonar in dict.fromkeys(map(layout.vehicle.instrument, ranges)):
        name = f"wall_bearing@{sonar}"  # a vehicle need not start square to the wall
        found.append(
            Unknown(name, layout.at([name]), np.zeros(1), SQUARE_RAD, -0.8, 0.8, 1e-3 * SQUARE_RAD, stated=False)
        )
    return found


def _kind(push: Push) -> object:
    """What thrusters share that differ but in their place, and are wrong in alike."""
    return push.thruster and replace(push.thruster, name="", site="", direction=(1.0, 0.0, 0.0))


def _kind_and_way(push: Push) -> object:
    """As `_kind`; what the hull takes of a thrust is another across its deck than along it."""
    return _kind(push), abs(push.direction[2]) > np.hypot(*push.direction[:2])


def _section(fin: Fin) -> object:
    """What fins share that differ but in where they stand, and are wrong in alike.

    A fixed one that stands for the lift of a hull is of no section: to the side a hull lifts otherwise than up.
    """
    return replace(fin, name="" if fin.limit_rad else fin.name, site="", axis=(0.0, 0.0, 1.0))


def _groups(together: str, parts: Sequence[T], alike: Callable[[T], object]) -> dict[str, list[str]]:
    """Names of thrusters or fins that are alike, by what they are called together; `together` where all are."""
    groups: dict[object, list[str]] = {}
    for part in parts:
        groups.setdefault(alike(part), []).append(part.name)
    if len(groups) == 1:
        return {together: [*groups.values()][0]}
    return {"/".join(names): names for names in groups.values()}


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

    def tiny(self, placed: Placed) -> bool:
        """Whether all free numbers of an effect are below VISIBLE of what is usual: of timing, mounting, form of a law.

        No simulator and no recording agree with one another more closely than that.
        """
        values = self.values(placed)
        free = [number for number in placed.parameters if number.scale > 0.0]
        return bool(free) and all(abs(values[n.name][0] - _null(n)) < VISIBLE * n.scale for n in free)

    def values(self, placed: Placed) -> dict[str, tuple[float, float]]:
        """Numbers of an effect and their standard deviations, by name; a fixed one has 0."""
        found = {}
        sd = self.sd
        for number in placed.parameters:
            for i, unknown in enumerate(self.unknowns):
                if unknown.name == f"{placed.name}.{number.name}":
                    found[number.name] = float(self.theta[i]) + _null(number), float(sd[i])
            if number.scale == 0.0:
                found[number.name] = number.starts[0], 0.0
        return found


def _null(number: Parameter) -> float:
    """What is in its slot beforehand, which belongs to the number."""
    return number.null if np.isfinite(number.null) else 0.0


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
    model: Model, found: Sequence[Filtered], theta: Array, held: Array | None = None, steps: int = STEPS
) -> Model:
    """Levenberg-Marquardt with the gains held, from theta; evidence at the end.

    held: derivative with respect to the first unknowns, (sum M, H), which is not made anew: own parameters hardly move.
    By default all are made at once, along paths, and anew where the fit has gone farther than it can tell apart.
    """

    def told() -> str:
        numbers = [np.array([getattr(u, part) for u in model.unknowns]) for part in ("scale", "low", "high", "step")]
        bases = [part for u in model.unknowns for part in (u.name, u.slots, u.base)]
        seen = [part for f in found for part in (f.p, f.innovation, f.variance, f.wall)]
        first = np.empty(0) if held is None else held.sum(axis=0)
        return digest(["refit", model.names, steps, model.fixed, theta, first, *numbers, *bases, *seen])

    def plain(fitted: Model) -> list[Any]:
        information = fitted.information
        return [fitted.theta.tolist(), fitted.cost, fitted.log_evidence,
                None if information is None else information.tolist()]  # fmt: skip

    def again(filed: list[Any]) -> Model:
        theta, cost, evidence, information = filed
        information = None if information is None else np.array(information).reshape(len(theta), len(theta))
        return replace(model, theta=np.array(theta), cost=cost, log_evidence=evidence, information=information)

    return step(told, lambda: _fitted(model, found, theta, held, steps), plain, again)


def _fitted(model: Model, found: Sequence[Filtered], theta: Array, held: Array | None, steps: int) -> Model:
    unknowns, scale = model.unknowns, np.array([u.scale for u in model.unknowns])
    low, high = (np.array([getattr(u, part) for u in unknowns]) for part in ("low", "high"))
    weight, damping = scale**-2.0, 1e-4
    theta = np.clip(theta, low, high)

    def residual(at: Array) -> Array:
        return model.fit.residuals([_vector(model.fixed, unknowns, at)], found)[:, 0]

    def differentiated(at: Array, e: Array) -> Array:
        if held is None:
            now = replace(model, theta=at)
            return slopes(now, model.fit.paths(now.vector(), found))
        side, first = _sides(unknowns, at), held.shape[1]
        if first == at.size:
            return held
        moved = [_vector(model.fixed, unknowns, at + side * (np.arange(at.size) == i)) for i in range(first, at.size)]
        return np.hstack([held, (model.fit.residuals(moved, found) - e[:, None]) / side[first:]])

    def cost_of(e: Array, at: Array) -> float:
        return 0.5 * float(e @ e + np.sum(weight * at * at))

    e, about = residual(theta), theta
    cost = cost_of(e, theta)
    J = differentiated(theta, e) if theta.size else np.empty((e.size, 0))
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
            there = residual(at)
            if cost_of(there, at) < cost:
                trial = at
                break
            damping = max(damping, 1e-3) * 10.0
        if trial is theta:
            break
        theta, e, damping = trial, there, max(damping / 10.0, 1e-8)
        cost = cost_of(e, theta)
        if held is not None or (theta - about) @ H @ (theta - about) > theta.size:
            J, about = differentiated(theta, e), theta
    inner = J.T @ J
    H, inside = inner + np.diag(weight), (theta > low) & (theta < high)
    occam = 0.5 * float(np.linalg.slogdet(np.eye(theta.size) + inner * np.outer(scale, scale))[1])
    covariance = np.asarray(np.linalg.inv(H), dtype=np.float64)
    cut = within(theta, J.T @ e + weight * theta, covariance, low, high, 0.0, scale)
    evidence = level(found) - cost - occam + cut + _sparing(model, theta, covariance, inside)
    evidence -= against(model.fit)
    return replace(model, theta=theta, cost=cost, information=H, log_evidence=evidence)


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
