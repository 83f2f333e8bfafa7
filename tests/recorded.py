"""Recordings for tests of the diagnosis, made by the surge equation with any extra force, and what is found in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from synthetic import advance

from vtank.diagnose.evidence import evaluate
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.localise.where import WhereData, locate
from vtank.diagnose.selection import Selection, _near, prepare, with_nameless
from vtank.diagnose.verdict import Verdict, decide, probabilities
from vtank.effects.catalogue import BY_NAME
from vtank.estimate.observed import RANGE, Observed
from vtank.estimate.problem import Noise
from vtank.plant.parameters import null_vector, slot, vector

TICK_S = 0.1
NOISE_M = 0.006
NOISE = Noise((NOISE_M**2,) * 3, 1e-4, 1.0)
DRIVES = ((0.5, 12.0), (0.4, 11.0), (0.7, 14.0), (0.2, 8.0))  # [rad/s], [rev/s] of the propeller
NOMINAL = vector({"alpha": -2.556, "beta": 4.877e-4, "thrust_lag.tau": 0.7074})  # paper's Model II, rounded
STANDOFF_M = float(null_vector()[slot("standoff")])

Force = Callable[[float, float, float], float]  # time [s], surge speed [m/s], propeller speed [rev/s] -> [m/s2]


def calm(t: float, u: float, n: float) -> float:
    """No extra force."""
    return 0.0


def record(name: str, propeller: np.ndarray, p: np.ndarray, noise_m: float, seed: int, force: Force = calm) -> Observed:
    """A run at 10 Hz under held propeller speeds, shape (I,), with an extra force held over each tick."""
    rng = np.random.default_rng(seed)
    time = TICK_S * np.arange(propeller.size)
    x = u = z = wake = 0.0
    place = np.empty(time.size)
    for k, t in enumerate(time):
        place[k] = x
        x, u, z, wake = advance(t, TICK_S, x, u, z, wake, propeller[k], force(t, u, propeller[k]), p)
    measured = STANDOFF_M - place + noise_m * rng.normal(size=time.size)
    return Observed(name, "n_rev_s", time, propeller, time, measured, np.full(time.size, RANGE))


def turbulent(sigma_m_s2: float, memory_s: float, seed: int) -> Force:
    """An Ornstein-Uhlenbeck acceleration that begins anew in every run."""
    rng, state = np.random.default_rng((seed, 1)), [0.0]  # not the numbers of a run's noise

    def force(t: float, u: float, n: float) -> float:
        keep = np.exp(-TICK_S / memory_s) if t > 0.0 else 0.0
        state[0] = keep * state[0] + sigma_m_s2 * np.sqrt(1.0 - keep**2) * rng.normal()
        return float(state[0])

    return force


def misread(run: Observed, error_m: Callable[[np.ndarray], np.ndarray]) -> Observed:
    """The run with an error of its sonar, given over time [s]."""
    return replace(run, value=run.value + error_m(run.time_s))


def sine(frequency_rad_s: float, amplitude_rev_s: float, duration_s: float = 120.0) -> np.ndarray:
    """Propeller speeds of a run driven at one frequency, shape (I,) [rev/s]."""
    return amplitude_rev_s * np.sin(frequency_rad_s * TICK_S * np.arange(round(duration_s / TICK_S)))


@dataclass(frozen=True)
class Found:
    """A comparison, its verdict and the place of the gap."""

    selection: Selection
    verdict: Verdict
    place: WhereData


def recordings(effect: dict[str, float] | None = None, seed: int = 0, force: Force = calm) -> list[Observed]:
    """Four runs, driven at DRIVES, of a vehicle with the given effect."""
    return differing([effect or {}] * len(DRIVES), seed, force)


def differing(effects: Sequence[dict[str, float]], seed: int = 0, force: Force = calm) -> list[Observed]:
    """The four runs, each of a vehicle with an effect or own parameters of its own."""
    pairs = zip(DRIVES, effects, strict=True)
    return [record(f"run_{k}", sine(*drive), vector(own, NOMINAL), NOISE_M, seed + k, force)
            for k, (drive, own) in enumerate(pairs)]  # fmt: skip


def select(runs: list[Observed], names: tuple[str, ...], noise: Noise = NOISE) -> Selection:
    """A comparison of few hypotheses at the noise level that the recordings were made with."""
    setting = prepare(runs, NOMINAL).with_noise(noise)
    nominal, refit = evaluate(setting, Hypothesis(refit=False)), evaluate(setting, Hypothesis())
    singles = [Hypothesis((BY_NAME[name],)) for name in names]
    named = tuple(evaluate(setting, single, _near(setting, refit, single)) for single in singles)
    return with_nameless(Selection(setting, nominal, refit, named))


def find(runs: list[Observed], *names: str, noise: Noise = NOISE) -> Found:
    """Verdict and place of the gap, the named effects considered."""
    selection = select(runs, names, noise)
    verdict = decide(selection, probabilities(selection))
    return Found(selection, verdict, locate(selection, verdict))
