"""Linear waves: dispersion, limits of deep and shallow water, the field equations, walls, spectra and random seas."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import gamma as gamma_function

from vtank.units import G_M_S2
from vtank.waves import Waves, breaking_height, orbit, wave_number
from vtank.waves.orbit import depth_profile, point
from vtank.waves.sea import surface
from vtank.waves.spectrum import BAND, bins, finite_depth, jonswap_shape

DEEP, SHALLOW = float("inf"), 5.0
W = np.geomspace(1e-3, 30.0, 400)
T = np.linspace(0.0, 40.0, 801)


def rng(seed: int = 1) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize("depth", [0.1, 2.0, 20.0, 3000.0])
def test_wave_numbers_solve_the_dispersion_relation(depth: float) -> None:
    k = wave_number(W, depth)
    np.testing.assert_allclose(G_M_S2 * k * np.tanh(k * depth), W * W, rtol=1e-12)


def test_wave_numbers_of_deep_and_shallow_water() -> None:
    np.testing.assert_allclose(wave_number(W, DEEP), W * W / G_M_S2, rtol=1e-15)
    np.testing.assert_allclose(wave_number(W[W > 2.0], 100.0), W[W > 2.0] ** 2 / G_M_S2, rtol=1e-12)
    slow = 1e-3
    assert wave_number(slow, 2.0) == pytest.approx(slow / math.sqrt(G_M_S2 * 2.0), rel=1e-6)


def test_the_profile_over_depth_in_its_limits() -> None:
    k = np.array([0.05, 0.5, 5.0])
    for z in (0.0, -1.0, -4.0):
        np.testing.assert_allclose(depth_profile(k, z, DEEP), [np.exp(k * z)] * 2, rtol=1e-14)
        np.testing.assert_allclose(depth_profile(k, z, 4.0)[0] * np.sinh(4.0 * k), np.cosh(k * (z + 4.0)), rtol=1e-12)
        np.testing.assert_allclose(depth_profile(k, z, 4.0)[1] * np.sinh(4.0 * k), np.sinh(k * (z + 4.0)), atol=1e-12)
    long = np.array([1e-4])
    along, up = depth_profile(long, -1.0, 4.0)
    assert along[0] == pytest.approx(1.0 / (long[0] * 4.0), rel=1e-6)  # alike from surface to bed
    assert up[0] == pytest.approx(3.0 / 4.0, rel=1e-6)  # falls linearly to nothing at the bed


def test_shallow_water_moves_as_the_long_wave_equations_say() -> None:
    """u = eta sqrt(g/h), in phase with the surface."""
    waves = Waves("regular", height_m=0.2, period_s=600.0, water_depth_m=SHALLOW)
    for depth in (0.5, 2.5, 4.9):
        at_crest = orbit(waves, depth, 4.0, rng()).velocity(np.array([0.0]))[0]
        assert at_crest == pytest.approx([0.1 * math.sqrt(G_M_S2 / SHALLOW), 0.0], rel=1e-4, abs=1e-12)


def test_deep_water_moves_in_circles_that_shrink_exponentially() -> None:
    waves = Waves("regular", height_m=0.4, period_s=3.0)
    w = 2.0 * math.pi / 3.0
    speed = np.linalg.norm(orbit(waves, 2.0, 4.0, rng()).velocity(T), axis=1)
    np.testing.assert_allclose(speed, 0.2 * w * math.exp(-w * w / G_M_S2 * 2.0), rtol=1e-12)


def field(x: float, z: float, reflection: float = 0.3) -> np.ndarray:
    """Velocity (T, 2) at a place, of three waves before a wall at x = 6."""
    amplitude = np.array([0.1, 0.05j, -0.03 + 0.02j])
    return point(np.array([0.6, 1.1, 2.3]), amplitude, z, SHALLOW, x, (6.0, reflection)).velocity(T)


@pytest.mark.parametrize("place", [(0.0, -1.0), (3.0, -4.0)])
def test_the_water_keeps_its_volume_and_does_not_turn(place: tuple[float, float]) -> None:
    """Divergence and vorticity vanish by central differences of second order."""
    x, z = place
    for divided, other in ((0, 1), (1, 0)):
        errors = []
        for d in (0.02, 0.01):
            by_x = (field(x + d, z) - field(x - d, z)) / (2.0 * d)
            by_z = (field(x, z + d) - field(x, z - d)) / (2.0 * d)
            sign = 1.0 if divided == 0 else -1.0
            errors.append(np.abs(by_x[:, divided] + sign * by_z[:, other]).max())
        assert errors[1] < 1e-5 and errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


def test_nothing_flows_through_bed_or_a_wall_that_sends_all_back() -> None:
    assert np.abs(field(2.0, -SHALLOW)[:, 1]).max() < 1e-15
    assert np.abs(field(6.0, -1.0, reflection=1.0)[:, 0]).max() < 1e-15
    assert np.abs(field(6.0, -1.0, reflection=0.0)[:, 0]).max() > 0.05


@pytest.mark.parametrize("waves", [Waves(), Waves("regular", 0.0, 5.0, 9.0), Waves("irregular", 0.0, 5.0, 9.0)])
def test_no_waves_move_nothing_at_all(waves: Waves) -> None:
    still = orbit(waves, 1.0, 4.0, rng())
    for motion in (still.velocity(T), still.ticks(0.1, 50)):
        assert motion.shape[1] == 2 and not motion.any()


def test_fast_sampling_is_the_same_sum() -> None:
    sea = orbit(Waves("irregular", 0.5, 6.0, 8.0, reflection=0.4), 3.0, 4.0, rng())
    times = np.arange(6001) * 0.1
    np.testing.assert_allclose(sea.ticks(0.1, times.size), sea.velocity(times), rtol=0, atol=1e-11)


def test_jonswap_without_a_peak_is_pierson_and_moskowitz() -> None:
    """m_n of w^-5 exp(-b w^-4) is b^(n/4 - 1) Gamma(1 - n/4)/4."""
    b = 1.25 * 0.7**4
    for n in (0, 1, 2):
        moment = quad(lambda w, n=n: w**n * jonswap_shape(np.array(w), 0.7, 1.0), 0.05, 500.0, limit=400)[0]
        assert moment == pytest.approx(b ** (n / 4.0 - 1.0) * gamma_function(1.0 - n / 4.0) / 4.0, rel=1e-4)


def test_the_peak_is_gamma_times_higher_and_where_it_should_be() -> None:
    at_peak = np.array([0.7])
    assert jonswap_shape(at_peak, 0.7, 3.3) / jonswap_shape(at_peak, 0.7, 1.0) == pytest.approx(3.3)
    w = np.linspace(0.4, 2.0, 16001)
    assert w[jonswap_shape(w, 0.7, 3.3).argmax()] == pytest.approx(0.7, abs=2e-4)


def test_tma_factor_in_deep_and_shallow_water() -> None:
    np.testing.assert_array_equal(finite_depth(W, DEEP), 1.0)
    np.testing.assert_allclose(finite_depth(np.array([5.0, 20.0]), 50.0), 1.0, rtol=1e-12)
    slow = np.array([0.01])
    x = wave_number(slow, 2.0) * 2.0
    np.testing.assert_allclose(finite_depth(slow, 2.0), x * x / 2.0, rtol=1e-3)
    assert (np.diff(finite_depth(W, 10.0)) >= 0.0).all()


@pytest.mark.parametrize("depth", [5.0, DEEP])
def test_variances_make_the_significant_height_and_the_moments(depth: float) -> None:
    height, period = 1.3, 7.0
    edges, variance = bins(height, period, 3.3, depth, 200)
    assert 4.0 * math.sqrt(variance.sum()) == pytest.approx(height, rel=1e-14)
    peak, middle = 2.0 * math.pi / period, 0.5 * (edges[1:] + edges[:-1])

    def moment(n: int) -> float:
        def density(w: float) -> float:
            at = np.array([w])
            return float((w**n * jonswap_shape(at, peak, 3.3) * finite_depth(at, depth))[0])

        return quad(density, BAND[0] * peak, BAND[1] * peak, points=[peak], limit=400)[0]

    for n in (1, 2, -1):
        expected = moment(n) / moment(0)
        assert (middle**n * variance).sum() / variance.sum() == pytest.approx(expected, rel=2e-3)


def test_a_random_sea_has_its_height_and_is_gaussian() -> None:
    rad_s, amplitude = surface(Waves("irregular", 0.8, 6.0, 10.0), rng(3))
    assert 4.0 * math.sqrt(0.5 * (np.abs(amplitude) ** 2).sum()) == pytest.approx(0.8, rel=1e-12)
    times = np.arange(0.0, 20000.0, 0.5)
    eta = np.concatenate([(np.exp(-1j * np.outer(t, rad_s)) @ amplitude).real for t in np.split(times, 40)])
    assert 4.0 * eta.std() == pytest.approx(0.8, rel=0.02)
    kurtosis = np.mean(eta**4) / np.mean(eta**2) ** 2
    assert kurtosis == pytest.approx(3.0, abs=0.15)
    fraction = np.mean(np.abs(eta) > 0.4)
    assert fraction == pytest.approx(math.erfc(2.0 / math.sqrt(2.0)), rel=0.1)


def test_the_motion_below_a_random_sea_has_the_variance_of_its_spectrum() -> None:
    waves, depth = Waves("irregular", 0.8, 6.0, 10.0), 4.0
    velocity = orbit(waves, depth, 4.0, rng(5)).velocity(np.arange(0.0, 6000.0, 0.5))
    edges, variance = bins(0.8, 6.0, 3.3, 10.0, 200)
    w = 0.5 * (edges[1:] + edges[:-1])
    profile = np.array(depth_profile(wave_number(w, 10.0), -depth, 10.0))
    np.testing.assert_allclose(velocity.var(axis=0), (variance * (w * profile) ** 2).sum(axis=1), rtol=0.03)


def test_a_seed_makes_the_sea_and_another_makes_another() -> None:
    waves = Waves("irregular", 0.8, 6.0, 10.0)
    one, same, other = (orbit(waves, 2.0, 4.0, rng(seed)).velocity(T) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert np.abs(one - other).max() > 0.05


def test_breaking_in_deep_and_shallow_water() -> None:
    assert breaking_height(5.0, DEEP) == pytest.approx(0.142 * G_M_S2 * 25.0 / (2.0 * math.pi))
    assert breaking_height(200.0, 2.0) == pytest.approx(0.142 * 2.0 * math.pi * 2.0, rel=1e-2)
