"""Bias of every estimator against the frequency of a single sinusoid and the noise of the sonar."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...estimate import MODELS
from ...estimate.paper import Model
from ...experiment import Excitation, Scenario, simulate_surge
from ...plant import Truth
from ..stage import Stage, silent
from .candidates import AMPLITUDES_M, RAMP_S, fits, planned
from .estimators import METHODS
from .flown import Array
from .trials import trials

FREQUENCIES_RAD_S = (0.2, 0.3, 0.4, 0.5, 0.7, 1.0)  # from the paper's slowest; beyond 1 rad/s the hull hardly moves
NOISE_M = (0.002, 0.006, 0.02)  # [m] of the sonar: a third of the scenarios', theirs, and three times it
FEWEST, MOST, SHARE = 6, 24, 8  # seeds of a cell: one of the plan's seeds in so many


@dataclass(frozen=True, eq=False)
class BiasMap:
    """Median relative error of single runs, and its deviation.

    Attributes:
        rad_s, amplitude_m: of the sinusoids, shape (W,).
        noise_m: of the sonar, shape (S,).
        names: of the P parameters.
        error: by method, the median and its deviation, shape (S, W, 2, P).
        seeds: of each.
    """

    rad_s: Array
    amplitude_m: Array
    noise_m: Array
    names: tuple[str, ...]
    error: dict[str, Array]
    seeds: int


def sinusoids(like: Scenario, truth: Truth) -> list[Scenario]:
    """At each frequency the largest sinusoid that fits the tank, all else as in the scenario."""
    found: dict[float, Scenario] = {}
    for w, amplitude in itertools.product(FREQUENCIES_RAD_S, sorted(AMPLITUDES_M)):
        e = Excitation("position_sine", "position", (amplitude,), (w,), ramp_s=RAMP_S)
        plan = planned(like, e, truth, 0, 0)
        if plan and fits(plan, simulate_surge([plan])[0]):
            found[w] = plan.scenario
    return list(found.values())


def bias_map(
    like: Scenario,
    truth: Truth,
    model: Model,
    seeds: int,
    seed: int = 1,
    over: Callable[..., Iterable[Any]] = map,
    stage: Stage = silent,
) -> BiasMap:
    """Single runs over frequency and noise on an eighth of so many seeds, six to 24; `over` as for `trials`."""
    sines, seeds = sinusoids(like, truth), min(max(seeds // SHARE, FEWEST), MOST)
    cells = [replace(s, sonar=replace(s.sonar, noise_m=noise)) for noise, s in itertools.product(NOISE_M, sines)]
    tried = []
    with stage("bias over frequency and noise", len(cells)) as advance:
        for cell in cells:
            tried.append(trials([cell], truth, model, np.nan, seeds, seed, over))
            advance(f"{cell.excitation.frequencies_rad_s[0]:g} rad/s, {1e3 * cell.sonar.noise_m:g} mm")
    shape = (len(NOISE_M), len(sines), 2, -1)
    error = {method: np.reshape([t.bias(method) for t in tried], shape) for method in METHODS}
    frequencies, amplitudes = np.array(
        [(s.excitation.frequencies_rad_s[0], s.excitation.amplitudes[0]) for s in sines]
    ).T
    return BiasMap(frequencies, amplitudes, np.array(NOISE_M), MODELS[model], error, seeds)
