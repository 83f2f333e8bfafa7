"""Prediction of runs that nobody has seen: from the recorded propeller speed, after ten seconds of watching.

Both the ten seconds and what a model is held against are noise-free ranges of the true hull, so that a difference of
models is not drowned by the noise of one run; only the tachometer's noise remains, the same for every model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...experiment import Excitation, Plan, Result, Scenario
from ...experiment.flight import MULTIPATH
from ...plant import load_truth, slot
from ...record import read_run
from .case import NOMINAL, Case
from .refit import Recording, refit
from .replay import Replay, spikes_of
from .whitening import Whitener

Array = NDArray[np.float64]
WATCHED_S = 10.0  # [s] of the run from which the initial state, and phases, are found
TYPICAL_M = 0.006  # [m] sonar noise that weights those seconds; any value gives the same fit
PHASES = (0.0, 2.1, 4.2)  # [rad] where the search for a phase begins
SEALED = ("clean_m", "spike_rev_s")  # columns: ranges without noise [m], what spikes add to a reading [rev/s]


@dataclass(frozen=True)
class HeldOut:
    """A run held back: a replay of it, recorded propeller speed [rev/s], noise-free ranges [m], time [s], (T,) each."""

    replay: Replay
    n_read: Array
    clean_m: Array
    time_s: Array

    @classmethod
    def of(cls, result: Result, clean_m: Array) -> HeldOut:
        """A run as flown."""
        run, standoff_m = result.run, result.plan.scenario.standoff_m
        replay = _replay(standoff_m, run.time_s, spikes_of(result.plan))
        return cls(replay, run.columns["n_rev_s"], clean_m, run.time_s)

    @classmethod
    def read(cls, path: Path, standoff_m: float) -> HeldOut:
        """A run from its file; InputError where it cannot be used."""
        run = read_run(path)
        n, clean, spikes = (run.columns[name] for name in ("n_rev_s", *SEALED))
        return cls(_replay(standoff_m, run.time_s, spikes), n, clean, run.time_s)

    @property
    def sealed(self) -> dict[str, Array]:
        """What only the truth knows of the run, as columns of its file, shape (T,) each."""
        return dict(zip(SEALED, (self.clean_m, self.replay.spikes), strict=True))

    def gap(self, p: Array, own: Sequence[str]) -> float:
        """Root mean square of what the model p leaves after WATCHED_S [m]; own: slots that this run has for itself."""
        late, still = self.time_s > WATCHED_S, np.zeros(self.n_read.size)
        equal = Whitener(still, still, (0.0, 0.0, 0.0), (1.0, 1.0, 0.0), TYPICAL_M**2, 0.1)
        watched = Recording(self.replay, self.n_read, np.where(late, np.nan, self.clean_m), equal)
        p = p.copy()
        p[slot("standoff")] = self.replay.plan.scenario.standoff_m
        fits = []
        for phase in PHASES if own else PHASES[:1]:
            p[[slot(name) for name in own]] = phase
            fits.append(refit([watched], p, free=own))
        fit = min(fits, key=lambda fit: fit.size)
        foretold = self.replay.model(fit.p[0], self.n_read, fit.start[0])
        return float(np.sqrt(np.mean((foretold - self.clean_m)[late] ** 2)))


def gaps(held: Sequence[HeldOut], p: Array, own: Sequence[str]) -> list[float]:
    """Gap of the model p on each held-out run [m]."""
    return [run.gap(p, own) for run in held]


def clean_range(case: Case, result: Result) -> Array:
    """Ranges of the true hull at the propeller speed that was flown, without noise and multipath, shape (T,) [m]."""
    p = result.plan.p.copy()
    p[MULTIPATH] = 0.0
    return Replay(replace(result.plan, p=p)).pushed(case.causes, result.true["n_rev_s"])[1]


def _replay(standoff_m: float, time_s: Array, spikes: Array) -> Replay:
    truth = load_truth(NOMINAL)
    scenario = Scenario(
        name="held_out", path=Path("held_out"), description="", truth="", duration_s=float(time_s[-1]),
        period_s=float(round(time_s[1] - time_s[0], 6)), standoff_m=standoff_m, depth_m=1.0, n_limit_rev_s=None,
        hold="thrusters", seed=0, excitation=Excitation("speed_sine", "speed", (0.0,), (1.0,)),
    )  # fmt: skip
    p = truth.vector()
    p[slot("standoff")] = standoff_m
    return Replay(Plan(scenario, truth, p, 0, 0, "held_out"), spikes)
