"""How often the 95 % intervals of `identify` hold the truth, by the kind of error that the sonar makes.

    make bench                                          # the gate, some minutes
    python benchmarks/bench_intervals.py [FAMILY ...]   # errors and times as well

The recordings come from a small simulator of its own, which shares nothing with the package: Model II by Runge-Kutta
steps of 20 ms, two runs of 100 s at 10 Hz with a propeller speed of three sines, vehicle and sines drawn by the seed.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np
import pytest
from numba import njit

from vtank.estimate.maximum_likelihood import identify
from vtank.estimate.observed import RANGE, Observed

SEEDS = 400
SD_M = 0.006  # [m] of every error but the coarse reading's
TICK_S, FINE, TICKS = 0.1, 5, 1000  # [s] held input, steps in it, and ticks of a run
LATE_S = 0.01  # [s] deviation of the true instants of the pings from their stamps
LOST = 3.0  # deviations beyond which an estimate counts as lost


@njit(cache=True)
def rate(u, z, n, alpha, beta, tau):  # type: ignore[no-untyped-def]
    """Rates of place, speed and lagged thrust."""
    return u, alpha * u * abs(u) + z, (beta * n * abs(n) - z) / tau


@njit(cache=True)
def flown(n, alpha, beta, tau):  # type: ignore[no-untyped-def]
    """Place [m] at every fine step, shape (TICKS * FINE + 1,), from rest."""
    h, x, u, z = TICK_S / FINE, 0.0, 0.0, 0.0
    out = np.zeros(n.size * FINE + 1)
    for k in range(n.size * FINE):
        m = n[k // FINE]
        a1, b1, c1 = rate(u, z, m, alpha, beta, tau)
        a2, b2, c2 = rate(u + 0.5 * h * b1, z + 0.5 * h * c1, m, alpha, beta, tau)
        a3, b3, c3 = rate(u + 0.5 * h * b2, z + 0.5 * h * c2, m, alpha, beta, tau)
        a4, b4, c4 = rate(u + h * b3, z + h * c3, m, alpha, beta, tau)
        x += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        u += h / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
        z += h / 6.0 * (c1 + 2.0 * c2 + 2.0 * c3 + c4)
        out[k + 1] = x
    return out


def coloured(random: np.random.Generator, sd: float, memory_s: float) -> np.ndarray:
    """Ornstein-Uhlenbeck error at every tick, shape (TICKS,)."""
    keep, out = np.exp(-TICK_S / memory_s), sd * random.standard_normal(TICKS)
    for k in range(1, TICKS):
        out[k] = keep * out[k - 1] + np.sqrt(1.0 - keep * keep) * out[k]
    return out


ERRORS = {
    "white": lambda r: SD_M * r.standard_normal(TICKS),
    "coloured": lambda r: coloured(r, SD_M, 0.5),
    "coloured and white": lambda r: coloured(r, SD_M, 0.5) + 0.5 * SD_M * r.standard_normal(TICKS),
    "t3": lambda r: SD_M * r.standard_t(3.0, TICKS) / np.sqrt(3.0),
    "laplace": lambda r: r.laplace(0.0, SD_M / np.sqrt(2.0), TICKS),
    "2 cm steps": lambda r: SD_M * r.standard_normal(TICKS),
    "30 % missing": lambda r: SD_M * r.standard_normal(TICKS),
    "jittered stamps": lambda r: SD_M * r.standard_normal(TICKS),
}


def drawn(family: str, seed: int) -> tuple[list[tuple[np.ndarray, ...]], np.ndarray]:
    """Stamps, propeller speeds, stamps of ranges and ranges of two runs, and the true alpha, beta and tau."""
    random = np.random.default_rng([seed, 17])
    truth = np.array([-2.0, 5e-4, 0.7]) * np.exp(random.uniform(-0.4, 0.4, 3))
    runs, t = [], TICK_S * np.arange(TICKS)
    for _ in range(2):
        waves = zip(random.uniform(0.15, 0.9, 3), random.uniform(0.0, 2.0 * np.pi, 3), strict=True)
        n = random.uniform(5.0, 8.0) * sum(np.sin(w * t + phase) for w, phase in waves)
        place = flown(n, *truth)
        when = t + LATE_S * random.standard_normal(TICKS) if family == "jittered stamps" else t
        y = 4.0 - np.interp(when, TICK_S / FINE * np.arange(place.size), place) + ERRORS[family](random)
        seen = random.random(TICKS) > 0.3 if family == "30 % missing" else np.ones(TICKS, bool)
        y = np.round(y / 0.02) * 0.02 if family == "2 cm steps" else y
        runs.append((t, n, t[seen], y[seen]))
    return runs, truth


def score(family: str, seed: int) -> np.ndarray:
    """Error over claimed deviation of alpha, beta, tau; their relative errors; seconds, and whether there was noise."""
    runs, truth = drawn(family, seed)
    seen = [Observed(f"r{k}", "n_rev_s", *run, np.full(run[3].size, RANGE)) for k, run in enumerate(runs)]
    began = time.perf_counter()
    found = identify(seen, "II")
    seconds = time.perf_counter() - began
    value, sd = np.array(list(found.values.values())), np.array(list(found.sd.values()))
    return np.concatenate([(value - truth) / sd, value / truth - 1.0, [seconds, found.problem.noise.sigma > 0.0]])


def scored(family: str) -> np.ndarray:
    """Scores of all seeds, shape (SEEDS, 8)."""
    return np.array([score(family, seed) for seed in range(SEEDS)])


@pytest.mark.parametrize("family", ERRORS)
def test_intervals_hold_the_truth(family: str, note: Callable[[str, str, str, str], None]) -> None:
    """The mean over the three parameters: of each alone, 400 seeds tell the coverage to 2 %."""
    held = np.mean(np.abs(scored(family)[:, :3]) < 1.959964)
    note(f"coverage, {family}", f"{held:.3f}", "0.95", "0.93 to 0.97")
    assert 0.93 <= held <= 0.97


if __name__ == "__main__":
    print("family               coverage of alpha, beta, tau  median error %        lost  disturbed  s each")
    for family in sys.argv[1:] or ERRORS:
        rows = scored(family)
        held = np.mean(np.abs(rows[:, :3]) < 1.959964, axis=0)
        error = 100.0 * np.median(np.abs(rows[:, 3:6]), axis=0)
        lost = np.mean(np.any(np.abs(rows[:, :3]) > LOST, axis=1))
        print(f"{family:20} {np.round(held, 3)!s:29} {np.round(error, 2)!s:21} {lost:.3f}  "
              f"{np.mean(rows[:, 7]):.3f}      {np.median(rows[:, 6]):.3f}", flush=True)  # fmt: skip
