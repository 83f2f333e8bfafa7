"""The sonar filter against its Riccati equation, its published numbers, sinusoids and its compiled twin."""

from __future__ import annotations

import numpy as np
import pytest

from vtank.estimate.paper.sonar_filter import sonar_filter, sonar_filter_compiled
from vtank.experiment.sonar_filter import filter_step, steady_state, transition, white_jerk

PERIOD_S = 0.1
R_FT2 = 0.01  # the paper's measurement variance


def frequency_response(rad_s: np.ndarray, period_s: float, q: float, r: float) -> np.ndarray:
    """What the steady filter makes of a sinusoid, shape (W, 3), complex.

    Each channel (position, velocity, acceleration) is divided by the true position, velocity, acceleration of the
    sinusoid at rad_s, shape (W,) [rad/s]: 1 is a perfect estimate, the modulus a gain, the argument a phase [rad].
    """
    gain = steady_state(period_s, q, r)[0]
    closed_loop = (np.eye(3) - np.outer(gain, [1.0, 0.0, 0.0])) @ transition(period_s)
    s = 1j * np.asarray(rad_s, dtype=float)[:, None]
    delay = np.exp(-s * period_s)[:, :, None]
    channels = np.linalg.solve(np.eye(3) - closed_loop * delay, gain[:, None] * np.ones_like(delay))[:, :, 0]
    return channels / s ** np.arange(3)


# gains, and velocity gain and phase [deg] at 0.2, 0.5, 0.7 rad/s: an independent calculation, printed digits
@pytest.mark.parametrize(
    ("q", "gain", "digits", "velocity"),
    [
        (0.1, (0.35, 0.75, 0.81), (2, 2, 2), ((1.015, -0.1), (1.093, -1.7), (1.174, -4.4))),
        (1.0, (0.47, 1.47, 2.3), (2, 2, 1), ((1.007, 0.0), (1.042, -0.5), (1.081, -1.4))),
        (10.0, (0.61, 2.8, 6.3), (2, 1, 1), ((1.003, 0.0), (1.019, -0.2), (1.036, -0.4))),
    ],
)
def test_published_gains_and_velocity_response(q, gain, digits, velocity):
    steady, _ = steady_state(PERIOD_S, q, R_FT2)
    for value, printed, places in zip(steady, gain, digits, strict=True):
        assert value == pytest.approx(printed, abs=0.55 * 10.0**-places)
    response = frequency_response(np.array([0.2, 0.5, 0.7]), PERIOD_S, q, R_FT2)[:, 1]
    for value, (modulus, degrees) in zip(response, velocity, strict=True):
        assert abs(value) == pytest.approx(modulus, abs=5.5e-4)
        assert np.degrees(np.angle(value)) == pytest.approx(degrees, abs=0.055)


@pytest.mark.parametrize(("q", "degrees"), [(0.1, -36), (1.0, -24), (10.0, -16)])
def test_published_acceleration_phase(q, degrees):
    acceleration = frequency_response(np.array([0.7]), PERIOD_S, q, R_FT2)[0, 2]
    assert np.degrees(np.angle(acceleration)) == pytest.approx(degrees, abs=0.5)


def test_steady_state_is_a_fixed_point_of_the_riccati_recursion():
    gain, posterior = steady_state(PERIOD_S, 1.0, R_FT2)
    prior = transition(PERIOD_S) @ posterior @ transition(PERIOD_S).T + white_jerk(PERIOD_S)
    np.testing.assert_allclose(prior[:, 0] / (prior[0, 0] + R_FT2), gain, rtol=1e-10)
    np.testing.assert_allclose(prior - np.outer(gain, prior[0]), posterior, rtol=1e-9, atol=1e-14)


def test_white_jerk_covariance_composes():
    """Two periods in a row must build up what one period of twice the length does."""
    f, j = transition(PERIOD_S), white_jerk(PERIOD_S)
    np.testing.assert_allclose(f @ j @ f.T + j, white_jerk(2 * PERIOD_S), rtol=1e-12)


def test_only_the_ratio_of_q_and_r_matters():
    foot = 0.3048
    metric = steady_state(PERIOD_S, 1.0 * foot**2, R_FT2 * foot**2)[0]
    np.testing.assert_allclose(metric, steady_state(PERIOD_S, 1.0, R_FT2)[0], rtol=1e-12)


def test_a_steady_sinusoid_comes_out_with_the_stated_gain_and_phase():
    omega, amplitude = 0.7, 2.0
    t = PERIOD_S * np.arange(1200)
    estimate = sonar_filter(amplitude * np.cos(omega * t), PERIOD_S, 0.1, R_FT2)[600:]
    response = frequency_response(np.array([omega]), PERIOD_S, 0.1, R_FT2)[0]
    truth = amplitude * (1j * omega) ** np.arange(3) * np.exp(1j * omega * t[600:, None])
    np.testing.assert_allclose(estimate, (response * truth).real, atol=1e-9)


def test_a_parabola_is_followed_without_lag():
    """Constant acceleration lies in the model: no steady error in any channel."""
    t = PERIOD_S * np.arange(600)
    estimate = sonar_filter(3.0 - 0.2 * t + 0.05 * t**2, PERIOD_S, 1.0, R_FT2)[-1]
    np.testing.assert_allclose(estimate, [3.0 - 0.2 * t[-1] + 0.05 * t[-1] ** 2, -0.2 + 0.1 * t[-1], 0.1], rtol=1e-8)


def record_with_missed_pings() -> np.ndarray:
    rng = np.random.default_rng(3)
    range_ft = 10.0 + 1.5 * np.cos(0.5 * PERIOD_S * np.arange(1200)) + 0.1 * rng.standard_normal(1200)
    range_ft[rng.random(1200) < 0.1] = np.nan
    range_ft[:3] = np.nan
    return range_ft


def test_compiled_filter_equals_filterpy():
    measured = record_with_missed_pings()
    reference = sonar_filter(measured, PERIOD_S, 1.0, R_FT2)
    twin = sonar_filter_compiled(measured, PERIOD_S, 1.0, R_FT2)
    assert np.isnan(reference[:3]).all() and np.isnan(twin[:3]).all()
    assert np.isfinite(reference[3:]).all()
    np.testing.assert_allclose(twin[3:], reference[3:], rtol=1e-9, atol=1e-9)


def test_a_missed_ping_only_predicts():
    state, covariance = np.array([1.0, 2.0, 3.0]), np.eye(3)
    filter_step(state, covariance, np.nan, PERIOD_S, 1.0, R_FT2)
    f = transition(PERIOD_S)
    np.testing.assert_allclose(state, f @ [1.0, 2.0, 3.0], rtol=1e-15)
    np.testing.assert_allclose(covariance, f @ f.T + white_jerk(PERIOD_S), rtol=1e-14, atol=1e-16)


def test_a_record_without_samples_stays_empty():
    for function in (sonar_filter, sonar_filter_compiled):
        assert np.isnan(function(np.full(5, np.nan), PERIOD_S, 1.0, R_FT2)).all()
