"""Experiments that fit the tank: frequencies, amplitudes and kinds of excitation, flown and checked.

What is not varied (sonar, tachometer, filter, controller, stand-off, duration) is that of a given scenario. An
experiment fits where hull and walls keep a margin and the propellers stay below their limit.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...experiment import MARGIN_M, Excitation, Plan, Result, Scenario, clearances, plan_run, simulate_surge
from ...plant import Truth
from .flown import Flown, flown
from .study import Study

FREQUENCIES_RAD_S = (0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0, 1.4, 2.0)
AMPLITUDES_M = (0.1, 0.15, 0.23, 0.3, 0.46, 0.61, 0.76)
SQUARES_RAD_S = (0.21, 0.42, 0.7)  # of a square: a jump every 15, 7.5 and 4.5 s
SHARES_OF_LIMIT = (0.3, 0.5, 0.7, 0.95)  # of the propellers' limit, in open loop
PUSHES_S = ((2.0, 6.0), (3.0, 12.0), (6.0, 9.0))  # push, coast [s]
SETS_RAD_S = ((0.2, 0.5, 1.0), (0.2, 0.4, 0.7, 1.0, 1.4), (0.5, 1.0, 2.0))
TWO_TONES_RAD_S = ((0.1, 0.4), (0.1, 0.7), (0.1, 1.0), (0.2, 0.5), (0.2, 0.7), (0.2, 1.0), (0.2, 1.4))
SLOW_M, FAST_M = (0.23, 0.46, 0.61), (0.05, 0.1, 0.15, 0.23, 0.3)  # amplitudes of the two
SWEEPS_RAD_S = ((0.1, 1.0), (0.2, 1.4), (0.5, 2.0))
RAMP_S = 5.0  # [s] as in the paper's scenarios
AT_LIMIT = 0.01  # share of the time that propellers may spend at their limit; a choice


def excitations(limit_rev_s: float) -> Iterator[Excitation]:
    """All that are tried."""
    for w, a in itertools.product(FREQUENCIES_RAD_S, AMPLITUDES_M):
        yield Excitation("position_sine", "position", (a,), (w,), ramp_s=RAMP_S)
    for ws, a in itertools.product(SETS_RAD_S, AMPLITUDES_M[:5]):
        yield Excitation("multisine", "position", tuple(round(a * ws[0] / w, 3) for w in ws), ws, ramp_s=RAMP_S)
    for ws, slow, fast in itertools.product(TWO_TONES_RAD_S, SLOW_M, FAST_M):
        yield Excitation("multisine", "position", (slow, fast), ws, ramp_s=RAMP_S)
    for ws, a in itertools.product(SWEEPS_RAD_S, AMPLITUDES_M[:5]):
        yield Excitation("chirp", "position", (a,), ws, ramp_s=RAMP_S)
    for w, a in itertools.product(SQUARES_RAD_S, AMPLITUDES_M):
        yield Excitation("square", "position", (a,), (w,))
    for w, share in itertools.product(FREQUENCIES_RAD_S, SHARES_OF_LIMIT):
        yield Excitation("speed_sine", "speed", (round(share * limit_rev_s, 2),), (w,), phase_rad=1.571)
    for (push, coast), share in itertools.product(PUSHES_S, SHARES_OF_LIMIT):
        yield Excitation("step_coast", "speed", (round(share * limit_rev_s, 2),), push_s=push, coast_s=coast)


def in_words(e: Excitation) -> str:
    """An excitation in words, short."""
    unit = "m" if e.loop == "position" else "rev/s"
    size = f"{max(e.amplitudes, default=0.0):.2g} {unit}"
    at = [f"{w:g}" for w in e.frequencies_rad_s]
    match e.kind:
        case "position_sine":
            return f"sine of {size} at {at[0]} rad/s"
        case "speed_sine":
            return f"propellers a sine of {size} at {at[0]} rad/s, open loop"
        case "multisine":
            sizes = [f"{a:.2g}" for a in e.amplitudes]
            return f"sines of {_listed(sizes)} m at {_listed(at)} rad/s together"
        case "chirp":
            return f"sweep of {size} from {at[0]} to {at[1]} rad/s"
        case "square":
            return f"square of {size}, a jump every {np.pi / e.frequencies_rad_s[0]:.2g} s"
        case "step_coast":
            return f"pushes of {size} for {e.push_s:g} s, then {e.coast_s:g} s of coasting"
        case _:
            return e.kind.replace("_", " ")


def _listed(items: Sequence[str]) -> str:
    return f"{', '.join(items[:-1])} and {items[-1]}"


def library(study: Study, duration_s: float | None = None) -> list[Flown]:
    """All that fit the tank, like the plan's first experiment but for the excitation, and the duration if given."""
    first, truth, number = study.flown[0].scenario, study.truth, len(study.flown)
    like = replace(first, duration_s=duration_s or first.duration_s)
    limit = truth.n_limit_rev_s if like.n_limit_rev_s is None else like.n_limit_rev_s
    plans = [plan for e in excitations(limit) if (plan := planned(like, e, truth, study.seed, number))]
    results = zip(plans, simulate_surge(plans), strict=True)
    return [flown(plan, result) for plan, result in results if fits(plan, result)]


def planned(like: Scenario, e: Excitation, truth: Truth, seed: int, number: int) -> Plan | None:
    """The scenario with another excitation; None where the command alone comes too near a wall."""
    try:
        return plan_run(replace(like, name=file_name(e), path=Path(f"{file_name(e)}.toml"), excitation=e,
                                description=in_words(e)), number, seed, truth)  # fmt: skip
    except InputError:
        return None


def fits(plan: Plan, result: Result) -> bool:
    """Whether hull and walls keep their margin, and the propellers are hardly ever at their limit."""
    limited = np.abs(result.true["n_rev_s"]) >= plan.n_limit_rev_s - 1e-6
    return clearance_m(result) >= MARGIN_M and bool(np.mean(limited) <= AT_LIMIT)


def clearance_m(result: Result) -> float:
    """Least water between hull and walls in a simulated run [m]."""
    x = result.true["position_m"]
    return min(clearances(result.plan.scenario, float(x.max()), float(x.min())))


def file_name(e: Excitation) -> str:
    """Name of a scenario file for an excitation."""
    parts = [e.kind.replace("_", "-"), *(f"{a:g}" for a in e.amplitudes), *(f"{w:g}" for w in e.frequencies_rad_s)]
    return "-".join([*parts, *([f"{e.push_s:g}-{e.coast_s:g}"] if e.push_s else [])])
