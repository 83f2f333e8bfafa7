"""A library of experiments that could come next, and what the winner would record in each of them.

Each experiment is the table of a scenario file. Sinusoids, squares and multisines are followed in closed loop by the
pilot of the virtual tank; pushes and drifts run in open loop. Where the input is no propeller speed, there is no pilot,
and the open-loop ones alone are looked at, in the unit of that input.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..effects.catalogue import PARAMETERS
from ..errors import InputError
from ..estimate.innovations import Noise, innovations, no_gain
from ..estimate.observed import SPEED, Observed, observe
from ..experiment.clearance import check_command
from ..experiment.plan import Plan
from ..experiment.scenario import Scenario, read_scenario
from ..experiment.surge_model import simulate_surge
from ..plant.parameters import LUMPED, slot, vector
from ..plant.surge import STANDOFF
from ..plant.truth import Truth
from ..record.table import Table
from .hypothesis import largest_input

MINUTES = 2.0  # [min] length of every new run, the paper's order
FREQUENCIES_RAD_S = (0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4)
LARGEST_M = 0.5  # [m] amplitude of a sinusoid that leaves room in a tank of 6 m; a choice
SMALL = 0.4  # small amplitude over the large one; a choice
SPEED_SD = 0.01  # [m/s] noise of a speed sensor that could be added: a Doppler log's, a guess
NEAR_M, FAR_M = 1.4, 3.048  # [m] start distances from the wall: near it, and the paper's
COUNTED = [slot(name) for name, q in PARAMETERS.items() if q.counted and not q.shape]  # how often there are outliers


@dataclass(frozen=True)
class Experiment:
    """An experiment.

    Attributes:
        words: in plain words.
        scenario: keys of a scenario file; empty where none can say it.
        minutes: how long it takes [min].
        run: what the winner would record in it, without noise.
        beginning: whether it is but the beginning of what the words say.
    """

    words: str
    scenario: dict[str, Any]
    minutes: float
    run: Observed
    beginning: bool = False

    @property
    def told(self) -> str:
        """In plain words, shortened or not; a scenario's length goes without saying."""
        return f"{self.words}, only the beginning" if self.beginning and not self.scenario else self.words


def shortened(experiment: Experiment, minutes: float) -> Experiment:
    """The beginning of an experiment."""
    run = experiment.run
    seen = run.time_s <= run.time_s[0] + 60.0 * minutes + 1e-9
    fed = run.input_time_s <= run.time_s[seen][-1]
    part = replace(run, time_s=run.time_s[seen], value=run.value[seen], kind=run.kind[seen],
                   input_time_s=run.input_time_s[fed], input=run.input[fed], lone=run.lone[fed])  # fmt: skip
    table = {**experiment.scenario, "duration_s": 60.0 * minutes} if experiment.scenario else {}
    return Experiment(experiment.words, table, minutes, part, beginning=True)


def library(p: np.ndarray, runs: Sequence[Observed]) -> list[Experiment]:
    """All experiments that the tank has room for, as a hull with parameter vector p (P,) would record them."""
    top = largest_input(runs)
    p = p.copy()
    p[COUNTED] = 0.0
    if runs[0].input_name == "n_rev_s":
        found = [_in_tank(words, table, p, top, runs[0]) for words, table in (*_closed(p, top), *_open(top, " rev/s"))]
        new = [experiment for experiment in found if experiment is not None]
    else:
        unit = {"command": "", "thrust_N": " N"}[runs[0].input_name]
        new = [_driven(words, table, p, runs[0]) for words, table in _open(top, unit)]
    return new + [_with_speed(run, p) for run in runs if not np.any(run.kind == SPEED)][:1]


def _closed(p: np.ndarray, top: float) -> list[tuple[str, dict[str, Any]]]:
    """Position commands that need no more than the propeller speed seen so far."""
    out = []
    for w in FREQUENCIES_RAD_S:
        large = _amplitude(p, w, 0.9 * top)
        for share, size in ((1.0, "large"), (SMALL, "small")):
            words = f"position command {share * large:.2g} m at {w:g} rad/s ({size} amplitude)"
            out.append((words, _sine(share * large, w)))
    near = min(0.3, _amplitude(p, 0.35, 0.9 * top))
    words = f"near the wall: position command {near:.2g} m at 0.35 rad/s from {NEAR_M:g} m"
    out.append((words, {**_sine(near, 0.35), "standoff_m": NEAR_M}))
    many = [round(0.5 * _amplitude(p, w, 0.5 * top), 3) for w in (0.2, 0.5, 1.0)]
    table = {"kind": "multisine", "amplitudes_m": many, "frequencies_rad_s": [0.2, 0.5, 1.0], "ramp_s": 5.0}
    out.append(("multisine of 0.2, 0.5 and 1 rad/s", {"excitation": table}))
    square = {"kind": "square", "amplitude_m": 0.25, "frequency_rad_s": 0.21}
    return [*out, ("square position command of 0.25 m, jumping every 15 s", {"excitation": square})]


def _sine(amplitude_m: float, rad_s: float) -> dict[str, Any]:
    return {"excitation": {"kind": "position_sine", "amplitude_m": round(amplitude_m, 3), "frequency_rad_s": rad_s,
                           "ramp_s": 5.0}}  # fmt: skip


def _amplitude(p: np.ndarray, w: float, n: float) -> float:
    """Amplitude [m] at w [rad/s] whose inertia and drag together need the thrust at propeller speed n [rev/s]."""
    alpha, thrust = abs(p[slot("alpha")]), p[slot("beta")] * n * n
    speed = np.roots([alpha * alpha, w * w, -thrust * thrust]) if alpha > 0.0 else np.array([(thrust / w) ** 2])
    squared = float(np.max(speed.real))  # of (alpha v^2)^2 + (w v)^2 = thrust^2, in v^2
    return float(min(np.sqrt(squared) / w, LARGEST_M))


def _open(top: float, unit: str) -> list[tuple[str, dict[str, Any]]]:
    """Pushes, coast-downs and drifts [unit of the input]."""
    n = round(0.7 * top, 3)
    push = {"kind": "step_coast", "amplitude_rev_s": n, "push_s": 3.0, "coast_s": 12.0}
    short = {"kind": "step_coast", "amplitude_rev_s": round(0.3 * top, 3), "push_s": 6.0, "coast_s": 9.0}
    waves = {"kind": "speed_sine", "amplitude_rev_s": n, "frequency_rad_s": 0.7}
    still = {"kind": "speed_sine", "amplitude_rev_s": 0.0, "frequency_rad_s": 1.0}
    return [
        (f"coast-down: {n:g}{unit} for 3 s, then 12 s without thrust, ahead and astern", {"excitation": push}),
        (f"weak pushes: {0.3 * top:.3g}{unit} for 6 s, then 9 s without thrust", {"excitation": short}),
        (f"input a sine of {n:g}{unit} at 0.7 rad/s, open loop", {"excitation": waves}),
        ("still: no thrust at all, the hull drifts", {"excitation": still}),
    ]


def _in_tank(words: str, table: dict[str, Any], p: np.ndarray, top: float, like: Observed) -> Experiment | None:
    """The experiment flown by the pilot without noise; None where the tank has no room for it."""
    table = {"duration_s": 60.0 * MINUTES, "standoff_m": FAR_M, **table}
    try:
        scenario: Scenario = read_scenario(Table(Path("next-experiment.toml"), "", table))
        check_command(scenario)
        p = p.copy()
        p[STANDOFF] = scenario.standoff_m
        alpha, beta, gamma, tau = (float(p[slot(name)]) for name in LUMPED)
        truth = Truth(alpha, beta, gamma, tau, "winner", top, "")
        result = simulate_surge([Plan(scenario, truth, p, 0, 0, words)], step_s=0.1)[0]
        result.check_clearance()
    except InputError:
        return None
    run = with_channels(observe(result.run), like.first)
    return Experiment(words, table, MINUTES, recorded(run, p))


def _driven(words: str, table: dict[str, Any], p: np.ndarray, like: Observed) -> Experiment:
    """The open-loop experiment in the unit of the recordings' input."""
    time = np.arange(0.0, 60.0 * MINUTES + 0.05, 0.1)
    scenario = read_scenario(Table(Path("next-experiment.toml"), "", {"duration_s": 60.0 * MINUTES, **table}))
    value = scenario.excitation.command(time, scenario.duration_s)[0]
    run = Observed(words, like.input_name, time, value, time, np.zeros(time.size), np.zeros(time.size, dtype=np.int64))
    return Experiment(words, {}, MINUTES, recorded(with_channels(run, like.first), p))


def _with_speed(run: Observed, p: np.ndarray) -> Experiment:
    """The run again with a speed sensor on board."""
    words = f"run {run.name} again with a speed sensor of {SPEED_SD:g} m/s on board"
    more = recorded(with_channels(run, (*run.first, SPEED)), p, run.standoff)
    return Experiment(words, {}, float(run.time_s[-1] - run.time_s[0]) / 60.0, more)


def with_channels(run: Observed, kinds: Iterable[int]) -> Observed:
    """The run with all these channels measured at each of its stamps, nothing read yet."""
    stamps, chosen = np.unique(run.time_s), np.array(sorted(kinds))
    time, kind = np.repeat(stamps, chosen.size), np.tile(chosen, stamps.size)
    return replace(run, time_s=time, kind=kind, value=np.zeros(time.size))


def recorded(run: Observed, p: np.ndarray, standoff: float | None = None) -> Observed:
    """The run with what a hull with parameter vector p, at rest at x = 0 at first, would give without noise.

    standoff: distance from the sonar to the wall at the start [m], by default that in p.
    """
    p = p if standoff is None else vector({"standoff": standoff}, p)
    out = innovations(run, p, np.zeros(4), Noise(), no_gain(run), np.zeros(run.time_s.size))
    return replace(run, value=-out)
