"""Bias of every estimator against the frequency of a single sinusoid and the noise of the sonar."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...estimate import MODELS
from ...estimate.paper import Model
from ...experiment import Excitation, Scenario, plan_run, simulate_surge
from ...plant import Truth, slot
from ..processes import processes
from .candidates import AMPLITUDES_M, RAMP_S, fits, planned
from .estimators import METHODS
from .flown import Array
from .trials import one_seed

FREQUENCIES_RAD_S = (0.2, 0.3, 0.4, 0.5, 0.7, 1.0)  # from the paper's slowest; beyond 1 rad/s the hull hardly moves
NOISE_M = (0.002, 0.006, 0.02)  # [m] of the sonar: a third of the scenarios', theirs, and three times it
FEWEST, MOST = 6, 24  # seeds of a cell
MEDIAN = 1.2533  # deviation of a median over that of a mean


@dataclass(frozen=True, eq=False)
class BiasMap:
    """Median relative error of single runs, by method, shape (noises, frequencies, P), and its deviation.

    Attributes:
        rad_s, amplitude_m: of the sinusoids, shape (W,).
        noise_m: of the sonar, shape (S,).
        names: of the P parameters.
        error, doubt: by method, shape (S, W, P).
        seeds: of each.
    """

    rad_s: Array
    amplitude_m: Array
    noise_m: Array
    names: tuple[str, ...]
    error: dict[str, Array]
    doubt: dict[str, Array]
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


def seeds_of_cell(seeds: int) -> int:
    """Seeds of one frequency and noise, for so many seeds of the whole plan."""
    return min(max(seeds // 8, FEWEST), MOST)


def cells(like: Scenario, truth: Truth) -> list[Scenario]:
    """All frequencies at the first noise, then at the next."""
    some = sinusoids(like, truth)
    return [replace(s, sonar=replace(s.sonar, noise_m=noise)) for noise, s in itertools.product(NOISE_M, some)]


def bias_map(
    some: Sequence[Scenario],
    truth: Truth,
    model: Model,
    seeds: int,
    seed: int = 1,
    workers: int = 1,
    advance: Callable[[str], None] = lambda note: None,
) -> BiasMap:
    """Single runs over frequency and noise, as by `cells`; `advance` is called after each."""
    p = plan_run(some[0], 0, seed, truth).p
    true = np.array([p[slot(name)] for name in MODELS[model]])
    table: dict[str, list[tuple[Array, Array]]] = {method: [] for method in METHODS}
    with processes(workers) as over:
        for scenario in some:
            found = list(over(partial(one_seed, [scenario], truth, model, seed), range(seeds)))
            for method in METHODS:
                error = np.array([answer[method].value for answer in found]) - true
                table[method].append(_median(error / np.abs(true)))
            advance(f"{scenario.excitation.frequencies_rad_s[0]:g} rad/s, {1e3 * scenario.sonar.noise_m:g} mm")
    across = len(some) // len(NOISE_M)
    shape = (len(NOISE_M), across, true.size)
    return BiasMap(
        np.array([s.excitation.frequencies_rad_s[0] for s in some[:across]]),
        np.array([s.excitation.amplitudes[0] for s in some[:across]]),
        np.array(NOISE_M),
        MODELS[model],
        {method: np.reshape([middle for middle, _ in rows], shape) for method, rows in table.items()},
        {method: np.reshape([doubt for _, doubt in rows], shape) for method, rows in table.items()},
        seeds,
    )


def _median(error: Array) -> tuple[Array, Array]:
    """Median of N errors and its deviation, shapes (P,)."""
    low, middle, high = np.nanpercentile(error, (15.87, 50.0, 84.13), axis=0)
    return middle, MEDIAN * 0.5 * (high - low) / np.sqrt(error.shape[0])
