"""Sensitivities of a run's predictions to the model's parameters and to the effects of the catalogue.

Every column is the change of the whitened innovations (one unit: one deviation of the noise) that a quantity brings
at its reference size: a parameter of the model its own value, an effect the typical size in its file. From the
compiled model by small differences; what the tachometer adds to the recorded propeller speed counts as a disturbance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...effects import CATALOGUE, PARAMETERS, Effect, Parameter
from ...estimate import Problem, innovations
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
        columns: one per quantity, shape (M + 1, C).
        own: one per unknown initial state, shape (M + 1, S).
        seiche: a seiche in two phases, shape (M + 1, 2).
    """

    columns: Array
    own: Array
    seiche: Array

    def shortened(self, measurements: int) -> Sensitivity:
        """Of the first measurements alone."""
        keep = np.r_[:measurements, self.columns.shape[0] - 1]
        return Sensitivity(self.columns[keep], self.own[keep], self.seiche[keep])


class Probe:
    """A flown experiment that tells how its innovations answer to changes of parameters and initial states."""

    def __init__(self, flown: Flown) -> None:
        self.flown, self.p, self.start = flown, flown.p, np.zeros(4)
        self.problem = Problem((flown.run,), flown.p, (), noise=flown.noise)
        self.filtered = self.problem.filter(np.zeros(self.problem.size))[0]
        self.base = self.innovations(self.p, self.start)

    def innovations(self, p: Array, start: Array) -> Array:
        """Whitened innovations with the gains held, shape (M,)."""
        e = innovations(self.flown.run, p, start, self.flown.noise, self.filtered.gain)
        return np.asarray(e / np.sqrt(self.filtered.variance))

    def quantity(self, q: Quantity, p: Array) -> Array:
        """Change by a quantity at its reference size, shape (M,); a saturation by the whole of it."""
        here = float(p[slot(q.name)])
        if not np.isfinite(here):
            return self.innovations(vector({q.name: q.size}, p), self.start) - self.base
        low, high = q.parameter.bounds if q.parameter else (-np.inf, np.inf)
        a, b = max(low, here - SHARE * q.size), min(high, here + SHARE * q.size)
        moved = [self.innovations(vector({q.name: value}, p), self.start) for value in (a, b)]
        return (moved[1] - moved[0]) * (q.size / (b - a))

    def state(self, i: int) -> Array:
        """Derivative with respect to an initial state, shape (M,)."""
        step = np.zeros(4)
        step[i] = STATE_STEP
        ahead, back = (self.innovations(self.p, self.start + sign * step) for sign in (1.0, -1.0))
        return (ahead - back) / (2.0 * STATE_STEP)

    def known(self) -> Array:
        """Row of what is known of the initial states: of the lag's, the thrust that the run's input could give."""
        row, top = np.zeros(len(self.problem.start_states(0))), self.flown.top_rev_s
        if self.problem.lagging:
            most = max(abs(float(thrust_target(0.0, sign * top, self.p))) for sign in (1.0, -1.0))
            row[-1] = 1.0 / max(most, 1e-6)
        return row


def sensitivity(flown: Flown, wanted: tuple[Quantity, ...]) -> Sensitivity:
    """Sensitivities of a flown experiment at the truth."""
    probe = Probe(flown)
    columns = [probe.quantity(q, flown.p) for q in wanted]
    wave = next(q for q in wanted if q.name == WAVE)
    waves = [probe.quantity(wave, vector(phase, flown.p)) for phase in PHASES]
    own = [probe.state(i) for i in probe.problem.start_states(0)]
    return Sensitivity(
        np.vstack([np.transpose(columns), np.zeros(len(columns))]),
        np.vstack([np.transpose(own), probe.known()]),
        np.vstack([np.transpose(waves), np.zeros(len(waves))]),
    )
