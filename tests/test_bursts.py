"""Uneven water is no cause: a disturbance that is several times as strong for a while, and a force that is not one."""

from __future__ import annotations

import importlib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from recorded import DRIVES, NOISE, NOISE_M, NOMINAL, Force, find, record, recordings, sine, turbulent

from vtank.diagnose.bursts import uneven, unlike
from vtank.diagnose.diagnosis import diagnose
from vtank.diagnose.evidence import evaluate
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.selection import prepare
from vtank.estimate.observed import Observed

SIGMA, MEMORY_S, USUAL = 5e-4, 1.0, 1e-3  # [m/s2, s, m/s2]
WATER = replace(NOISE, sigma=SIGMA, correlation_time=MEMORY_S)


def bursting(times: float, seed: int, start: float = 40.0, stop: float = 52.0) -> Force:
    """Turbulence that is so many times as strong for a while."""
    even = turbulent(SIGMA, MEMORY_S, seed)
    return lambda t, u, n: even(t, u, n) * (times if start <= t < stop else 1.0)


def kicked(size_m_s2: float, seed: int, start: float = 40.0, stop: float = 52.0) -> Force:
    """Turbulence, and a force for a while."""
    even = turbulent(SIGMA, MEMORY_S, seed)
    return lambda t, u, n: even(t, u, n) + (size_m_s2 if start <= t < stop else 0.0)


def with_third(force: Force, seed: int) -> list[Observed]:
    """Four runs in even water, of which the third sees a force besides."""
    runs = recordings(seed=seed, force=turbulent(SIGMA, MEMORY_S, seed))
    return [*runs[:2], record("run_2", sine(*DRIVES[2]), NOMINAL, NOISE_M, seed + 2, force), runs[3]]


def gusty(seed: int) -> list[Observed]:
    """Four runs with a burst each, another time in every one."""
    starts = (20.0, 75.0, 40.0, 60.0)
    pairs = enumerate(zip(DRIVES, starts, strict=True))
    return [record(f"run_{k}", sine(*drive), NOMINAL, NOISE_M, seed + k, bursting(7.0, 10 * seed + k, at, at + 15.0))
            for k, (drive, at) in pairs]  # fmt: skip


@pytest.mark.parametrize("seed", [41, *(pytest.param(s, marks=pytest.mark.slow) for s in (42, 43, 44))])
def test_bursts_of_turbulence_are_no_cause(seed: int) -> None:
    found = find(gusty(seed), "linear_drag", noise=WATER)
    refit = next(free for free in found.selection.free if free.fit is found.selection.refit)
    assert refit.gain > 10.0  # what took them for a cause
    assert found.verdict.kind in ("none", "parameters")


@pytest.mark.parametrize("seed", [31, *(pytest.param(s, marks=pytest.mark.slow) for s in (32, 33, 34))])
def test_a_force_for_a_while_is_a_cause(seed: int) -> None:
    found = find(with_third(kicked(4e-3, seed), seed), "linear_drag", noise=WATER)
    assert found.verdict.kind == "unknown"


def test_even_water_is_even() -> None:
    selection = find(recordings(force=turbulent(SIGMA, MEMORY_S, 7)), "linear_drag", noise=WATER).selection
    assert uneven(selection.refit, USUAL) == 0.0


def test_runs_too_short_for_a_stretch_are_even() -> None:
    """Once it ended in an error."""
    runs = [record(f"run_{k}", sine(*drive, 8.0), NOMINAL, NOISE_M, k) for k, drive in enumerate(DRIVES)]
    assert uneven(evaluate(prepare(runs, NOMINAL).with_noise(WATER), Hypothesis()), USUAL) == 0.0


def rough(times: tuple[float, ...], seed: int) -> list[Observed]:
    """Four runs, each in water of its own."""
    forces = (turbulent(n * 1e-3, 2.0, 10 * seed + k) for k, n in enumerate(times))
    pairs = enumerate(zip(DRIVES, forces, strict=True))
    return [record(f"run_{k}", sine(*drive), NOMINAL, NOISE_M, seed + k, force) for k, (drive, force) in pairs]


@pytest.mark.parametrize("seed", [51, *(pytest.param(s, marks=pytest.mark.slow) for s in (52, 53, 54))])
def test_water_that_differs_from_run_to_run_is_no_cause(seed: int) -> None:
    times = (4.0, 0.3, 1.0, 2.0)
    found = diagnose(rough(times, seed), NOMINAL)
    assert found.verdict.kind == "none"
    told = np.array([*found.summary()["disturbance"]["by_run"].values()])
    assert np.all(np.abs(np.log2(told / (1e-3 * np.array(times)))) < 1.0)  # by a factor of two


@pytest.mark.parametrize("repeats", [True, False])
def test_what_mostly_repeats_is_no_water(monkeypatch: pytest.MonkeyPatch, repeats: bool) -> None:
    noise = replace(NOISE, sigma=1e-3, correlation_time=2.0)
    setting = prepare(rough((4.0, 0.3, 1.0, 2.0), 56), NOMINAL).with_noise(noise)
    found = SimpleNamespace(mostly_repeats=repeats, components=())
    monkeypatch.setattr(importlib.import_module("vtank.diagnose.bursts"), "pursue", lambda fit, pitching: found)
    louder = unlike(setting, evaluate(setting, Hypothesis()))
    assert (louder is setting) is repeats
    if not repeats:
        told = [run.loud * louder.noise.sigma for run in louder.runs]
        assert np.argsort(told).tolist() == [1, 2, 3, 0]


def test_water_that_is_alike_stays_so() -> None:
    setting = prepare(rough((1.0, 1.0, 1.0, 1.0), 55), NOMINAL).with_noise(
        replace(NOISE, sigma=1e-3, correlation_time=2.0)
    )
    assert unlike(setting, evaluate(setting, Hypothesis())) is setting
