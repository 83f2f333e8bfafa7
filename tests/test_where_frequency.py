"""Spectrum and coherence against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vtank.diagnose.localise.frequency import (
    LEVEL,
    TAPERS,
    Spectrum,
    _multiple,
    coherence,
    frequencies,
    largest_by_chance,
    periodogram,
    waves,
)


@pytest.fixture
def uneven() -> np.ndarray:
    return np.sort(np.random.default_rng(1).uniform(0.0, 60.0, 500))


def test_waves_are_powers_of_the_first(uneven: np.ndarray) -> None:
    grid = 0.1 * np.arange(1, 300)
    assert np.allclose(waves(uneven, grid), np.exp(-1j * np.outer(grid, uneven - uneven[0])), atol=1e-11)


def test_frequencies_are_fourier_s() -> None:
    time = 0.1 * np.arange(600)
    grid = frequencies(time)
    assert grid[0] == pytest.approx(2.0 * np.pi / 60.0)
    assert np.allclose(np.diff(grid), grid[0])
    assert grid[-1] <= np.pi / 0.1 + 1e-9


def test_white_noise_has_power_one_exponentially_distributed(uneven: np.ndarray) -> None:
    rng, grid = np.random.default_rng(2), 2.0 * np.pi / 60.0 * np.arange(4, 100, 4)
    E = waves(uneven, grid[0] / 4 * np.arange(1, 100))[3::4]
    power = np.array([periodogram(uneven, rng.normal(size=uneven.size), E) for _ in range(300)])
    assert np.mean(power) == pytest.approx(1.0, abs=0.05)
    assert np.mean(power > 2.0) == pytest.approx(np.exp(-2.0), abs=0.02)


def test_a_sine_has_the_power_of_its_amplitude() -> None:
    """Hann window: |A/2 sum w|^2 / sum w^2 = A^2 M / 6, with M/2 the sum of the window and 3M/8 of its square."""
    time = 0.1 * np.arange(1200)
    grid = frequencies(time)
    power = periodogram(time, 0.3 * np.sin(grid[20] * time + 0.4), waves(time, grid))
    assert int(np.argmax(power)) == 20
    assert power[20] == pytest.approx(0.3**2 * 1200 / 6.0, rel=0.01)


def test_the_largest_of_many_ordinates() -> None:
    """P(max > x) = 1 - (1 - exp(-x))^m, solved for x; and by drawing."""
    x = largest_by_chance(400)
    assert 1.0 - (1.0 - np.exp(-x)) ** 400 == pytest.approx(LEVEL, rel=1e-9)
    draws = np.random.default_rng(3).exponential(size=(20000, 50)).max(axis=1)
    assert np.mean(draws > largest_by_chance(50)) == pytest.approx(LEVEL, abs=0.003)


def test_a_signal_coheres_with_what_it_drives() -> None:
    rng, time = np.random.default_rng(4), 0.1 * np.arange(1200)
    a = rng.normal(size=time.size)
    E = waves(time, frequencies(time))
    assert np.allclose(coherence(time, a, -3.0 * a, E), 1.0)


def test_coherence_of_strangers_is_distributed_as_the_number_of_tapers_says() -> None:
    """P(coherence > c) = (1 - c)^(K - 1) for independent white signals."""
    rng, time = np.random.default_rng(5), 0.1 * np.arange(600)
    E = waves(time, frequencies(time))[20:200:10]
    level = 1.0 - LEVEL ** (1.0 / (TAPERS - 1))
    shared = np.array([coherence(time, *rng.normal(size=(2, time.size)), E) for _ in range(400)])
    assert np.mean(shared > level) == pytest.approx(LEVEL, abs=0.004)
    assert np.mean(shared) == pytest.approx(1.0 / TAPERS, abs=0.01)


def test_a_constant_input_has_no_multiples() -> None:
    grid = np.array([0.1, 0.2, 0.3])
    spectrum = Spectrum("run", grid, np.ones(3), np.full(3, 5.0), np.zeros(3), 0.9, 0.0, ())
    assert _multiple(spectrum, 1) is None
    assert _multiple(replace(spectrum, drive_rad_s=0.1), 1) == 2
