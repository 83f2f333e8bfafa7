"""The paper's regressions, estimators and residuals against data made by its own discrete model (6)-(7)."""

from __future__ import annotations

import numpy as np
import pytest

from vtank.errors import InputError
from vtank.estimate.paper.kalman import Evolution, kalman, kalman_compiled, scales
from vtank.estimate.paper.least_squares import least_squares
from vtank.estimate.paper.linear import LinearModel, fit_linear
from vtank.estimate.paper.regression import (
    MODELS,
    Regression,
    recover,
    regression,
    unstable,
)
from vtank.estimate.paper.two_stage import second_stage
from vtank.estimate.residuals import free_run, free_run_beside, residual_coherence, residual_statistics, whiteness
from vtank.plant.lumped import Lumped, from_feet, to_feet

FOOT = 0.3048
STEP_S = 0.5
# the published data set 1 of Tables 1, 2 and 3
TRUTH = {
    "I": from_feet(-0.3626, 0.0024, 0.0, 0.0),
    "II": from_feet(-0.7791, 0.0016, 0.0, 0.7074),
    "III": from_feet(-1.2359, 0.0131, -0.1720, 3.1413),
}


def propeller(steps: int, step_s: float = STEP_S) -> np.ndarray:
    t = step_s * np.arange(steps)
    return 10.0 * np.sin(0.5 * t) + 6.0 * np.sin(1.3 * t + 1.0) + 4.0 * np.sin(2.9 * t + 2.0)


def discrete_model(truth: Lumped, n: np.ndarray, step_s: float = STEP_S, u: float = 0.1, z: float = 0.02) -> np.ndarray:
    """Surge speed [m/s] by (6)-(7), gamma in its place beside u|n|; Model I where tau = 0."""
    speed = []
    for value in n:
        speed.append(u)
        thrust = truth.beta_m_per_rev2 * value * abs(value)
        z = thrust if truth.tau_s == 0.0 else z
        u, z = (
            u + step_s * (truth.alpha_per_m * u * abs(u) + truth.gamma_per_rev * u * abs(value) + z),
            z if truth.tau_s == 0.0 else z + step_s * (thrust - z) / truth.tau_s,
        )
    return np.array(speed)


def noise_free(model: str, steps: int = 600):
    n = propeller(steps)
    return regression(discrete_model(TRUTH[model], n), n, STEP_S, model)


def noisy(model: str, deviation: float = 0.01, steps: int = 240):
    rng = np.random.default_rng(1)
    n = propeller(steps)
    return regression(discrete_model(TRUTH[model], n) + deviation * rng.standard_normal(steps), n, STEP_S, model)


def coefficients(parameters: Lumped, step_s: float, model: str) -> np.ndarray:
    """C of given parameters, shape (p,)."""
    a, b, gamma, tau = to_feet(parameters)
    drag, gain, loss = step_s * a, step_s * b, step_s * gamma
    if model == "I":
        return np.array([drag, gain])
    lag = step_s / tau
    return np.array([drag, lag, drag * lag, gain * lag, loss, loss * lag])[: 4 if model == "II" else 6]


def assert_same(found: Lumped, truth: Lumped, rtol: float):
    for name in ("alpha_per_m", "beta_m_per_rev2", "gamma_per_rev", "tau_s"):
        assert getattr(found, name) == pytest.approx(getattr(truth, name), rel=rtol, abs=1e-15), name


# --- regressors ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("step_s", [0.1, 0.5])
def test_discrete_model_satisfies_the_regression(model, step_s):
    rng = np.random.default_rng(0)
    for _ in range(20):
        a, b, gamma, tau = -rng.uniform(0.02, 2), rng.uniform(0.5e-3, 0.01), -rng.uniform(0, 0.1), rng.uniform(0.6, 3)
        truth = from_feet(a, b, gamma if model == "III" else 0.0, 0.0 if model == "I" else tau)
        n = 5.0 * rng.standard_normal(300)
        rows = regression(discrete_model(truth, n, step_s), n, step_s, model)
        assert np.abs(rows.z - rows.h @ coefficients(truth, step_s, model)).max() < 1e-12


@pytest.mark.parametrize("model", MODELS)
def test_coefficients_and_parameters_are_inverse(model):
    c = coefficients(TRUTH[model], STEP_S, model)
    assert_same(recover(c, STEP_S, model), TRUTH[model], 1e-14)


def test_regressors_are_in_feet():
    n = propeller(50)
    u_ft_s = discrete_model(TRUTH["II"], n) / FOOT
    rows = regression(FOOT * u_ft_s, n, STEP_S, "II")
    np.testing.assert_allclose(rows.z, u_ft_s[2:] - 2 * u_ft_s[1:-1] + u_ft_s[:-2], atol=1e-14)
    np.testing.assert_allclose(rows.h[:, 3], (n * np.abs(n))[:-2], rtol=1e-14)


def test_free_coefficients_break_their_redundancy_under_noise():
    c = least_squares(noisy("II")).final
    assert abs(c[2] - c[0] * c[1]) > 0.05 * abs(c[0] * c[1])


def test_rows_that_touch_a_missing_sample_are_left_out():
    n = propeller(200)
    u = discrete_model(TRUTH["III"], n)
    u[50] = np.nan
    rows = regression(u, n, STEP_S, "III")
    assert np.flatnonzero(~rows.complete).tolist() == [48, 49, 50]
    assert_same(recover(least_squares(rows).final, STEP_S, "III"), TRUTH["III"], 1e-8)


def test_too_short_a_record_is_refused():
    with pytest.raises(InputError, match="model III needs at least 12 steps"):
        regression(np.ones(10), np.ones(10), STEP_S, "III")


# --- estimators ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", MODELS)
def test_least_squares_recovers_the_truth(model):
    assert_same(recover(least_squares(noise_free(model)).final, STEP_S, model), TRUTH[model], 1e-9)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("scaling", ["literal", "normalised"])
def test_kalman_estimator_recovers_the_truth(model, scaling):
    rows = noise_free(model, 4000)
    unit, output = scales(rows, scaling)
    evolution = kalman(rows.z, rows.h, 1e-3 * unit**2, 0.01 * output**2, np.zeros(unit.size), np.diag(1e6 * unit**2))
    assert_same(recover(evolution.final, STEP_S, model), TRUTH[model], 1e-6)


def recursive_least_squares(rows: Regression, initial_variance: float) -> Evolution:
    """The estimator with Q = 0: its weight on the zero start is 1 / initial_variance."""
    size = rows.h.shape[1]
    return kalman_compiled(rows.z, rows.h, np.zeros(size), 1.0, np.zeros(size), initial_variance * np.eye(size))


@pytest.mark.parametrize("model", MODELS)
def test_recursive_least_squares_recovers_the_truth(model):
    found = recursive_least_squares(noise_free(model), initial_variance=1e12).final
    assert_same(recover(found, STEP_S, model), TRUTH[model], 1e-6)


def test_two_stages_recover_the_truth():
    rows = noise_free("II", 4000)
    first = kalman_compiled(rows.z, rows.h, np.full(4, 1.0), 0.01, np.zeros(4), np.eye(4))
    assert np.argmin(first.covariance.diagonal()) == 3
    second = second_stage(rows, first, np.full(4, 0.0032), 0.01, kalman_compiled)
    assert_same(recover(second.final, STEP_S, "II"), TRUTH["II"], 1e-6)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("q_ii", [0.0, 0.0032, 3.0])
def test_compiled_estimator_equals_filterpy(model, q_ii):
    rows = noisy(model)
    rows.z[30:33] = np.nan
    size = rows.h.shape[1]
    arguments = rows.z, rows.h, np.full(size, q_ii), 0.01, np.zeros(size), np.eye(size)
    reference, twin = kalman(*arguments), kalman_compiled(*arguments)
    np.testing.assert_allclose(twin.c, reference.c, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(twin.variance, reference.variance, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(twin.covariance, reference.covariance, rtol=1e-9, atol=1e-9)
    assert (reference.c[30:33] == reference.c[29]).all()  # no measurement, no change


def test_recursive_least_squares_is_regularised_least_squares():
    """Q = 0: the estimate minimises |z - h C|^2 + |C|^2 / p0, and P is the inverse of that Hessian."""
    rows = noisy("III")
    hessian = rows.h.T @ rows.h + np.eye(6) / 50.0
    evolution = recursive_least_squares(rows, initial_variance=50.0)
    np.testing.assert_allclose(evolution.final, np.linalg.solve(hessian, rows.h.T @ rows.z), rtol=1e-7)
    np.testing.assert_allclose(evolution.covariance, np.linalg.inv(hessian), rtol=1e-6, atol=1e-12)


def test_scalings_agree_when_nothing_is_assumed_to_drift():
    """With Q = 0 and a vague start the unit of the coefficients cannot matter."""
    rows = noisy("II")
    found = []
    for scaling in ("literal", "normalised"):
        unit, output = scales(rows, scaling)
        vague = np.diag(1e8 * unit**2)
        found.append(kalman_compiled(rows.z, rows.h, 0.0 * unit, 0.01 * output**2, np.zeros(4), vague).final)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-4)


def test_second_stage_holds_b_over_tau():
    rows = noisy("II")
    first = kalman_compiled(rows.z, rows.h, np.ones(4), 0.01, np.zeros(4), np.eye(4))
    second = second_stage(rows, first, np.full(4, 0.0032), 0.01, kalman)
    one, two = (recover(evolution.final, STEP_S, "II") for evolution in (first, second))
    assert np.argmin(first.covariance.diagonal()) == 3
    assert (second.c[:, 3] == first.final[3]).all()
    assert two.beta_m_per_rev2 / two.tau_s == pytest.approx(one.beta_m_per_rev2 / one.tau_s, rel=1e-12)
    assert two.tau_s != pytest.approx(one.tau_s, rel=1e-3)


def test_least_squares_covariance_is_that_of_white_equation_errors():
    rows = noise_free("II", 300)
    c = coefficients(TRUTH["II"], STEP_S, "II")
    rng = np.random.default_rng(5)
    squares = []
    for _ in range(300):
        fit = least_squares(type(rows)("II", STEP_S, rows.h @ c + 0.01 * rng.standard_normal(rows.z.size), rows.h))
        error = fit.final - c
        squares.append(error @ np.linalg.solve(fit.covariance, error))
    assert np.mean(squares) == pytest.approx(4.0, abs=4 * np.sqrt(8.0 / 300))  # chi-square with 4 degrees of freedom


# --- linear model ----------------------------------------------------------------------------------------------------


def test_linear_model_recovers_and_runs_free():
    truth = LinearModel(1.5, -0.6, 0.004, -0.001, STEP_S)
    n = propeller(200)
    u = [0.1, 0.12]
    for k in range(1, 199):
        u.append(1.5 * u[k] - 0.6 * u[k - 1] + 0.004 * n[k] - 0.001 * n[k - 1])
    u = np.array(u)
    np.testing.assert_allclose(truth.free_run(n, u), u, rtol=1e-10, atol=1e-14)
    fitted = fit_linear(u, n, STEP_S)
    for name in ("a1", "a2", "b1_m_per_rev", "b2_m_per_rev"):
        assert getattr(fitted, name) == pytest.approx(getattr(truth, name), rel=1e-9)
    assert np.prod(fitted.poles).real == pytest.approx(0.6)


# --- residuals -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", MODELS)
def test_free_run_is_the_discrete_model(model):
    n = propeller(400)
    u = discrete_model(TRUTH[model], n)
    np.testing.assert_allclose(free_run(n, STEP_S, TRUTH[model], 0.1, 0.02), u, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(free_run_beside(u, n, STEP_S, TRUTH[model]), u, rtol=1e-12, atol=1e-14)


def test_a_positive_drag_is_flagged_and_its_divergence_told():
    wrong = from_feet(1.295, 0.0033, 0.0, 0.0)  # Table 1, data set 2: the asterisk
    n = propeller(400)
    simulated = free_run(n, STEP_S, wrong, 0.1)
    measured = discrete_model(TRUTH["I"], n)
    assert unstable(wrong) == ("a",) and unstable(TRUTH["I"]) == ()
    assert np.isfinite(simulated[0]) and np.isnan(simulated[-1])
    assert np.isnan(residual_statistics(measured, simulated).deviation)
    assert unstable(Lumped(np.nan, 1.0, 0.0, -0.1)) == ("a", "tau")


def test_a_lag_shorter_than_half_the_step_diverges_in_the_discrete_model():
    n = propeller(600)
    for tau_s, flags in ((0.26, ()), (0.24, ("tau",))):
        parameters = Lumped(-2.0, 5e-4, 0.0, tau_s)
        assert unstable(parameters) == () and unstable(parameters, STEP_S) == flags
        assert np.isnan(free_run(n, STEP_S, parameters, 0.1)[-1]) == bool(flags)


def test_statistics_of_a_sinusoid():
    phase = 2 * np.pi * np.arange(1000) / 1000
    s = residual_statistics(0.3 * np.sin(phase), np.zeros(1000))
    assert s.mean == pytest.approx(0.0, abs=1e-15)
    assert s.deviation == pytest.approx(0.3 / np.sqrt(2))
    assert s.mean_absolute == pytest.approx(0.6 / np.pi, rel=1e-5)
    shifted = residual_statistics(0.3 * np.sin(phase), np.full(1000, -0.4))
    assert (shifted.mean, shifted.deviation) == (pytest.approx(0.4), pytest.approx(s.deviation))
    assert shifted.rms == pytest.approx(np.hypot(0.4, s.deviation))


def test_coherence_tells_a_filtered_input_from_noise():
    rng = np.random.default_rng(2)
    u, noise = rng.standard_normal((2, 8000))
    frequency, filtered = residual_coherence(u, np.convolve(u, [0.5, 0.3, 0.1])[:8000], 0.1, segments=40)
    _, unrelated = residual_coherence(u, noise, 0.1, segments=40)
    assert frequency[-1] == pytest.approx(np.pi / 0.1, rel=0.01)
    assert filtered[1:].min() > 0.98
    assert unrelated[1:-1].mean() < 0.05


def test_whiteness_rejects_five_percent_of_white_records_and_every_sinusoid():
    rng = np.random.default_rng(4)
    rejected = sum(whiteness(rng.standard_normal(400)) < 0.05 for _ in range(400))
    assert 6 <= rejected <= 38  # 20 expected, standard error 4.4
    sinusoid = np.sin(0.5 * STEP_S * np.arange(240))
    assert whiteness(sinusoid) < 1e-12
