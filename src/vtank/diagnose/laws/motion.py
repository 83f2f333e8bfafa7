"""What a law may depend on, along every run: the motion as it was, without the sonar's noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...plant.formula import Factor, Memory
from ...plant.law import KINDS, OPERATIONS, VARIABLES, remember, tabulate
from ..evidence import Fitted
from ..freeform import simulated_tracks


@dataclass(frozen=True)
class Motion:
    """One run at chosen instants.

    Attributes:
        t, x, u, z, n, gap, a: time [s], place [m], speed [m/s], thrust [m/s2], propeller speed, distance to the wall
            [m] and acceleration [m/s2], shapes (I,).
    """

    t: np.ndarray
    x: np.ndarray
    u: np.ndarray
    z: np.ndarray
    n: np.ndarray
    gap: np.ndarray
    a: np.ndarray

    def remembered(self, memory: Memory) -> np.ndarray:
        """What a memory holds, and what is new in the quantity it keeps, shape (2, I)."""
        q = memory.quantity
        m = (KINDS.index(memory.kind), VARIABLES.index(q.variable), OPERATIONS.index(q.operation), q.a)
        return np.asarray(remember(self.t, self.x, self.u, self.z, self.n, tuple(map(float, (*m, memory.a, memory.b)))))

    def of(self, f: Factor, kept: np.ndarray | None = None) -> np.ndarray:
        """Values of a factor, shape (I,); kept: of the memory, where it has one."""
        w, fresh = (self.t, self.t) if kept is None else kept
        code = float(VARIABLES.index(f.variable)), float(OPERATIONS.index(f.operation)), f.a, f.b
        return np.asarray(tabulate(code, self.t, self.x, self.u, self.z, w, self.n, self.gap, self.a, fresh))


def motions(fit: Fitted, fitted: Sequence[np.ndarray], sensor: bool) -> list[Motion]:
    """Every run at the stamps of its input, or of its measurements for a sensor's error.

    fitted: per run, a known acceleration that mends the fit's motion [m/s2], shape (I,); none where it is empty.
    """
    problem, out = fit.problem, []
    if not sensor and fitted and all(f.size for f in fitted):
        problem = replace(problem, forcing=tuple(fitted))
    for k, track in enumerate(simulated_tracks(problem, fit.optimum.theta)):
        run, p = problem.runs[k], problem.model(fit.optimum.theta, k)[0]
        t = run.time_s if sensor else run.input_time_s
        x, u, z = (np.interp(t, run.time_s, track[:, i]) for i in range(3))
        held = np.searchsorted(run.input_time_s, t, side="right") - 1
        n = run.input[np.maximum(held, 0)]
        gap = run.here(p)[run.plant.parameters.slot("standoff")] - x
        out.append(Motion(t, x, u, z, n, gap, np.gradient(u, t)))
    return out
