"""Sensitivities of a run's predictions to the model's parameters and to the effects of the catalogue.

Every column is the change of the whitened innovations (one unit: one deviation of the noise) that a quantity brings
at its reference size: a parameter of the model its own value, an effect the typical size in its file. From the
compiled model by small differences; what the tachometer adds to the recorded propeller speed counts as a disturbance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...effects import CATALOGUE, PARAMETERS, Effect, Parameter
from ...estimate import Problem
from ...plant import slot, thrust_target, vector
from .flown import Array, Flown

SHARE = 1e-3  # of the reference size: step of the differences; the model is smooth to 1e-12
STATE_STEP = 1e-4  # [m, m/s, m/s2] the same for an initial state
SATURATED = 0.8  # share of the fastest propeller speed taken for the typical limit of a saturation; a choice
WAVE, _, PHASE = next(effect.wave for effect in CATALOGUE if effect.wave)  # a seiche
PHASES = ({PHASE: 0.0}, {PHASE: 0.5 * np.pi})


@dataclass(frozen=True)
class Quantity:
    """A column: its slot, its reference size [its unit], and the effect and parameter behind it, if any."""

    name: str
    size: float
    effect: Effect | None = None
    parameter: Parameter | None = None


def quantities(p: Array, top_rev_s: float, free: tuple[str, ...]) -> tuple[Quantity, ...]:
    """Parameters of the model and sizes of all effects but the outliers.

    p: the truth; top_rev_s: fastest propeller speed of the plan [rev/s]; free: parameters of the model.
    """
    found = [Quantity(name, abs(float(p[slot(name)]))) for name in ("alpha", "beta")]
    for effect in (effect for effect in CATALOGUE if not effect.outliers):  # outliers are seen alone, and never smooth
        for name, q in ((s, q) for s in effect.slots() if not ((q := PARAMETERS[s]).shape or q.per_run)):
            size = SATURATED * top_rev_s if q.limit else q.scale
            if name in free and p[slot(name)] != 0.0:
                size = abs(float(p[slot(name)]))
            found.append(Quantity(name, size, effect, q))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Columns of one run of M measurements; the last row is what is known beforehand of the lag's first state.

    Attributes:
        columns: one per quantity, then a seiche in two phases, shape (M + 1, C + 2).
        own: one per unknown initial state, shape (M + 1, S).
    """

    columns: Array
    own: Array

    def shortened(self, measurements: int) -> Sensitivity:
        """Of the first measurements alone."""
        keep = np.r_[:measurements, self.columns.shape[0] - 1]
        return Sensitivity(self.columns[keep], self.own[keep])


def sensitivity(flown: Flown, wanted: tuple[Quantity, ...]) -> Sensitivity:
    """Sensitivities of a flown experiment at the truth, the filter's gains held."""
    problem = Problem((flown.run,), flown.p, (), noise=flown.noise)
    rest = np.zeros(problem.size)
    filtered = problem.filter(rest)[0]

    def innovations(p: Array, theta: Array = rest) -> Array:
        return problem.varied(theta, filtered, 0, p=p)

    wave = next(q for q in wanted if q.name == WAVE)
    columns = [_change(innovations, q, flown.p) for q in wanted]
    columns += [_change(innovations, wave, vector(phase, flown.p)) for phase in PHASES]
    steps = STATE_STEP * np.eye(problem.size)[len(problem.per_run) :]
    states = [(innovations(flown.p, s) - innovations(flown.p, -s)) / (2.0 * STATE_STEP) for s in steps]
    known = np.zeros(len(states))
    if problem.lagging:  # the thrust that the run's input could give
        most = max(abs(float(thrust_target(0.0, n, flown.p))) for n in (flown.top_rev_s, -flown.top_rev_s))
        known[-1] = 1.0 / max(most, 1e-6)
    whole = np.vstack([np.transpose(columns), np.zeros(len(columns))])
    return Sensitivity(whole, np.vstack([np.transpose(states), known]))


def _change(innovations: Callable[[Array], Array], q: Quantity, p: Array) -> Array:
    """Change of the innovations by a quantity at its reference size, shape (M,); a saturation by the whole of it."""
    here = float(p[slot(q.name)])
    if not np.isfinite(here):
        return innovations(vector({q.name: q.size}, p)) - innovations(p)
    low, high = q.parameter.bounds if q.parameter else (-np.inf, np.inf)
    a, b = max(low, here - SHARE * q.size), min(high, here + SHARE * q.size)
    return (innovations(vector({q.name: b}, p)) - innovations(vector({q.name: a}, p))) * (q.size / (b - a))
