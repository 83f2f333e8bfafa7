"""Recordings made with plain steps of the surge equation, for the tests of what reads them back."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vtank.estimate.observed import CHANNELS, POSITION, RANGE, SPEED, Observed
from vtank.plant.parameters import slot
from vtank.plant.surge import SURGE

STEP_S = 0.01  # of the motion; stamps of inputs and measurements are multiples of it
SONAR_M = {RANGE: 0.006, POSITION: 0.006, SPEED: 0.01}  # [m, m, m/s] noise


def advance(t, h, x, u, z, wake, n, push, p):
    """States (x, u, z, wake) after one step of the surge equation."""
    return SURGE.move(t, h, (x, u, z, wake), (float(n),), (float(push),), p)


def sine(amplitude: float, frequency_rad_s: float) -> Callable[[np.ndarray], np.ndarray]:
    """Propeller speed over time [rev/s]."""
    return lambda t: amplitude * np.cos(frequency_rad_s * t)


def turbulence(sigma: float, memory_s: float, count: int, rng: np.random.Generator) -> np.ndarray:
    """Ornstein-Uhlenbeck acceleration at steps of STEP_S [m/s2]: its mean over each step, nearly, shape (count,)."""
    keep, d = np.exp(-STEP_S / memory_s), np.empty(count)
    kick = sigma * np.sqrt(1.0 - keep**2) * rng.standard_normal(count)
    d[0] = sigma * rng.standard_normal()
    for k in range(1, count):
        d[k] = keep * d[k - 1] + kick[k]
    return d


def motion(
    p: np.ndarray,
    n: Callable[[np.ndarray], np.ndarray],
    duration_s: float = 60.0,
    every_s: float = 0.1,
    state: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
    disturbance: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Input stamps and values, held for `every_s`, shape (I,); time, shape (T,), and (x, u) at it, shape (T, 2)."""
    count, hold = round(duration_s / STEP_S), round(every_s / STEP_S)
    time = STEP_S * np.arange(count)
    stamps = time[::hold]
    values = n(stamps)
    states = np.empty((count, 2))
    for k in range(count):
        states[k] = state[:2]
        push = 0.0 if disturbance is None else disturbance[k]
        state = advance(time[k], STEP_S, *state, values[k // hold], push, p)
    return stamps, values, time, states


def observed(
    p: np.ndarray,
    n: Callable[[np.ndarray], np.ndarray],
    channels: dict[int, float] | None = None,
    seed: int | None = None,
    input_name: str = "n_rev_s",
    name: str = "run",
    **how: object,
) -> Observed:
    """A recording of some channels (kind -> period [s], default range at 10 Hz); noisy where a seed is given."""
    stamps, values, time, states = motion(p, n, **how)  # type: ignore[arg-type]
    rng = np.random.default_rng(seed)
    parts = []
    for kind, period in (channels or {RANGE: 0.1}).items():
        chosen = slice(0, None, round(period / STEP_S))
        true = {RANGE: p[slot("standoff")] - states[:, 0], POSITION: states[:, 0], SPEED: states[:, 1]}[kind][chosen]
        noise = 0.0 if seed is None else SONAR_M[kind] * rng.standard_normal(true.size)
        parts.append((time[chosen], true + noise, np.full(true.size, kind)))
    t, y, kind = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(t, kind="stable")
    assert set(kind) <= set(CHANNELS.values())
    return Observed(name, input_name, stamps, values, t[order], y[order], kind[order])
