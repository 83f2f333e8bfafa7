"""The gap of every run: error of a pure simulation on the recorded input, before and after.

"Before" is the nominal simulator and its refit, "after" the diagnosed one. The floor is what a perfect simulator
would still miss: the error of the diagnosed one, as far as sensor noise and the shared disturbance (turbulence, wake)
can account for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...channels import channels
from ...plant.surge import SURGE
from ..evidence import Fitted
from ..freeform import simulated
from ..holdout import held, rms
from ..selection import Selection
from ..verdict import Verdict

UNIT = {kind: row.unit for kind, row in enumerate(channels(SURGE))}
UNHEARD = 1e4  # [m2 or m2/s2] variance of a measurement that teaches the filter nothing, yet leaves twelve digits of P


@dataclass(frozen=True)
class RunGap:
    """Simulation error of one run on its main measurement.

    Attributes:
        run: the run's name.
        kind: channel it is judged by.
        time_s: stamps of the measurements, shape (M,).
        value: what was measured, shape (M,) [m or m/s].
        error: measured less simulated, by simulator ("nominal", "refit", "diagnosed"), shape (M,) [m or m/s].
        counts: by simulator, which measurements it has to explain, shape (M,) of bool.
        floor: what a perfect simulator would still miss, root mean square [m or m/s].
        share: of this run in the evidence for the simulator after over that before, all runs together one [-].
    """

    run: str
    kind: int
    time_s: np.ndarray
    value: np.ndarray
    error: dict[str, np.ndarray]
    counts: dict[str, np.ndarray]
    floor: float
    share: float

    @property
    def unit(self) -> str:
        """Unit of the error."""
        return UNIT[self.kind]

    def rms(self, simulator: str) -> float:
        """Root mean square error of a simulator [m or m/s]."""
        return rms([self.error[simulator][self.counts[simulator]]])

    def document(self) -> dict[str, Any]:
        """As plain data."""
        gaps = {simulator: self.rms(simulator) for simulator in self.error}
        span = float(self.time_s[-1] - self.time_s[0])
        told = {"run": self.run, "duration_s": span, "unit": self.unit}
        return told | gaps | {"floor": self.floor, "share": self.share}


def run_gaps(selection: Selection, verdict: Verdict, shares: Sequence[float]) -> tuple[RunGap, ...]:
    """Gap of every run, before and after; shares: of the runs in the evidence."""
    fits = {"nominal": selection.nominal, "refit": selection.refit, "diagnosed": verdict.fit}
    errors = {name: simulated(fit.problem, fit.optimum.theta) for name, fit in fits.items()}
    floors, gaps = noise_floors(verdict.fit), []
    for k, run in enumerate(selection.setting.runs):
        kind = int(np.min(run.kind))  # judged by range before position before speed
        chosen = run.kind == kind
        error = {name: parts[k].innovation[chosen] for name, parts in errors.items()}
        counts = {name: _judged(~selection.setting.flags[k][chosen], verdict.fit, name) for name in fits}
        seen, floor = (run.time_s[chosen], run.value[chosen]), rms([floors[k][chosen]])
        gap = RunGap(run.name, kind, *seen, error, counts, floor, shares[k])
        gaps.append(replace(gap, floor=min(gap.floor, gap.rms("diagnosed"))))
    return tuple(gaps)


def _judged(quiet: np.ndarray, fit: Fitted, simulator: str) -> np.ndarray:
    """Lone outliers count for nobody, unless the diagnosis explains them: then they are part of the gap before."""
    explained = "range_m" in fit.hypothesis.outliers
    return np.ones_like(quiet) if explained and simulator != "diagnosed" else quiet


def whitened(fit: Fitted) -> np.ndarray:
    """Innovations over their deviations at the optimum, all runs, shape (sum M,)."""
    return fit.problem.residuals(fit.optimum.theta, fit.filtered)


def noise_floors(fit: Fitted) -> list[np.ndarray]:
    """Deviation of measured less simulated that sensor noise and disturbance alone would cause, per run, shape (M,)."""
    level = fit.problem.noise
    deaf = replace(fit.problem, noise=replace(level, variance=(UNHEARD,) * len(level.variance)), weight=None)
    floors = []
    for run, f in zip(fit.problem.runs, deaf.filter(fit.optimum.theta), strict=True):
        variance = np.maximum(held(f.variance) - UNHEARD, 0.0) + np.array(level.variance)[run.kind]
        floors.append(np.sqrt(variance))
    return floors
