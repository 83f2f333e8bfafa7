"""How large a disturbance is to be expected: what still water does, what a vehicle stirs, what one at rest shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..estimate.problem import FLAGGED
from .evidence import STILL_SIGMA, Fitted
from .freeform.motion import motions
from .noise_floor import noise_at

STIRRED = 0.01  # of its thrust that the water moves a vehicle by which itself has stirred it; a guess
IDLE = 0.05  # share of its largest up to which an input is none, and a speed is rest; a choice
SETTLED_S = 5.0  # [s] that a vehicle has been at rest before it counts; a choice
LEAST_S = 20.0  # [s] of rest in all that say something: some memories of a disturbance; a choice


def still_sigma(fit: Fitted) -> float:
    """Disturbance that is no surprise [m/s2]: still water's, or what the vehicle stirs, or shows at rest, if more.

    What it stirs goes with the forces that it works with: a wake is theirs.
    """
    problem, both = fit.problem, motions(fit)
    moved = [read for _, read in both]
    thrust = np.concatenate([fed.terms["thrust"] for fed, _ in both])
    least = max(STILL_SIGMA, STIRRED * float(np.sqrt(np.mean(thrust**2))))
    fastest = max(float(np.max(np.abs(m.u))) for m in moved)
    hardest = max(float(np.max(np.abs(run.input))) for run in problem.runs)
    weight, rest_s = [], 0.0
    for k, m in enumerate(moved):
        idle = (np.abs(m.u) <= IDLE * fastest) & (np.abs(m.n) <= IDLE * hardest)
        since = m.t - np.maximum.accumulate(np.where(idle, m.t[0], m.t))
        resting = idle & (since >= SETTLED_S)
        rest_s += float(np.sum(np.diff(m.t)[resting[1:]]))
        weight.append(np.where(resting & problem.used(k), 1.0, FLAGGED))
    if rest_s < LEAST_S:
        return least
    return max(noise_at(replace(problem, weight=tuple(weight)), fit.optimum.theta).sigma, least)
