"""Prediction of runs that nobody has seen: from the recorded propeller speed, after ten seconds of watching.

Both the ten seconds and what a model is held against are noise-free ranges of the true hull, so that a difference of
models is not drowned by the noise of one run; only the tachometer's noise remains, the same for every model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...experiment import Plan, Result, Sonar
from ...experiment.flight import MULTIPATH
from ...plant import load_truth, slot
from ...record import Run
from .case import Case
from .experiment import BASE
from .refit import Recording, refit
from .replay import Replay, spikes_of
from .whitening import Whitener

Array = NDArray[np.float64]
WATCHED_S = 10.0  # [s] of the run from which the initial state, and phases, are found
TYPICAL_M = 0.006  # [m] sonar noise that weights those seconds; any value gives the same fit
PHASES = (0.0, 2.1, 4.2)  # [rad] where the search for a phase begins


@dataclass(frozen=True)
class HeldOut:
    """A run held back, and the stand-off where it began [m].

    Among its columns is what only the truth knows: ranges without noise, clean_m, and what spikes add to a reading,
    spike_rev_s.
    """

    run: Run
    standoff_m: float

    @classmethod
    def of(cls, case: Case, result: Result) -> HeldOut:
        """A run as flown."""
        sealed = {"clean_m": clean_range(case, result), "spike_rev_s": spikes_of(result.plan)}
        run = replace(result.run, columns=result.run.columns | sealed)
        return cls(run, result.plan.scenario.standoff_m)

    @cached_property
    def replay(self) -> Replay:
        """The same run without noise, at any parameters."""
        t, truth = self.run.time_s, load_truth(BASE.truth)
        tick_s = round(float(t[-1]) / (t.size - 1), 3)
        duration_s = tick_s * (t.size - 1)
        sonar = Sonar(rate_hz=1.0 / tick_s)
        scenario = replace(BASE, standoff_m=self.standoff_m, duration_s=duration_s, period_s=tick_s, sonar=sonar)
        plan = Plan(scenario, truth, truth.vector(), 0, 0, "held_out")
        return Replay(plan, self.run.columns["spike_rev_s"])

    def gap(self, p: Array, own: Sequence[str]) -> float:
        """Root mean square of what the model p leaves after WATCHED_S [m]; own: slots that this run has for itself."""
        n_read, clean_m = self.run.columns["n_rev_s"], self.run.columns["clean_m"]
        late, still = self.run.time_s > WATCHED_S, np.zeros(n_read.size)
        equal = Whitener(
            still, still, (0.0, 0.0, 0.0), (1.0, 1.0, 0.0), TYPICAL_M**2 + still, self.replay.plan.scenario.period_s
        )
        watched = Recording(self.replay, n_read, np.where(late, np.nan, clean_m), equal)
        p = p.copy()
        p[slot("standoff")] = self.standoff_m
        fits = []
        for phase in PHASES if own else PHASES[:1]:
            p[[slot(name) for name in own]] = phase
            fits.append(refit([watched], p, free=tuple(own)))
        fit = min(fits, key=lambda fit: fit.size)
        foretold = self.replay.model(fit.p[0], n_read, fit.start[0])
        return float(np.sqrt(np.mean((foretold - clean_m)[late] ** 2)))


def gaps(held: Sequence[HeldOut], p: Array, own: Sequence[str]) -> list[float]:
    """Gap of the model p on each held-out run [m]."""
    return [run.gap(p, own) for run in held]


def clean_range(case: Case, result: Result) -> Array:
    """Ranges of the true hull at the propeller speed that was flown, without noise and multipath, shape (T,) [m]."""
    p = result.plan.p.copy()
    p[MULTIPATH] = 0.0
    return Replay(replace(result.plan, p=p)).pushed(case.causes, result.true["n_rev_s"])[1]
