"""The paper's identification from records of continuous motion, through the sonar filter, to its tables' entries."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vtank.errors import InputError
from vtank.estimate.paper.estimate import (
    PaperEstimate,
    PaperSettings,
    cross_validation,
    identify_run,
    identify_signals,
)
from vtank.estimate.paper.regression import Model
from vtank.estimate.paper.signals import range_signals, speed_signals
from vtank.plant.lumped import Lumped, from_feet
from vtank.record.run import Run

PERIOD_S = 0.1
STANDOFF_M = 3.048
TRUTH = from_feet(-0.7791, 0.0016, 0.0, 0.7074)  # Table 2, data set 1
PAPER = PaperSettings()
BATCH = PaperSettings(estimator="least_squares", compiled=True)


def identify_paper(
    range_m: np.ndarray, n: np.ndarray, period_s: float, model: Model, settings: PaperSettings
) -> PaperEstimate:
    return identify_signals(range_signals(range_m, n, period_s, settings), model, settings)


def motion(n: np.ndarray, period_s: float, truth: Lumped = TRUTH, substeps: int = 20) -> tuple[np.ndarray, np.ndarray]:
    """Position [m] and speed [m/s] of (14)-(15) in continuous time (RK4), n held over each period; from rest."""

    def rate(state: np.ndarray, thrust: float) -> np.ndarray:
        _, u, z = state
        return np.array([u, truth.alpha_per_m * u * abs(u) + z, (thrust - z) / truth.tau_s])

    state, h, trace = np.zeros(3), period_s / substeps, []
    for value in n:
        trace.append(state)
        thrust = truth.beta_m_per_rev2 * value * abs(value)
        for _ in range(substeps):
            k1 = rate(state, thrust)
            k2 = rate(state + h / 2 * k1, thrust)
            k3 = rate(state + h / 2 * k2, thrust)
            k4 = rate(state + h * k3, thrust)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return np.array(trace)[:, 0], np.array(trace)[:, 1]


def sinusoid(omega_rad_s: float, duration_s: float = 60.0, period_s: float = PERIOD_S) -> np.ndarray:
    t = period_s * np.arange(round(duration_s / period_s))
    return 15.0 * np.cos(omega_rad_s * t) + 4.0 * np.cos(3.1 * omega_rad_s * t)


@pytest.fixture(scope="module")
def record() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Range [m], propeller speed [rev/s] and true speed [m/s] of data set 1: 6 mm of noise, 1 cm of resolution."""
    n = sinusoid(0.5)
    x, u = motion(n, PERIOD_S, substeps=4)
    noisy = STANDOFF_M - x + 0.006 * np.random.default_rng(0).standard_normal(n.size)
    return np.round(noisy, 2), n, u


def test_discretisation_is_of_first_order():
    """On exact speeds, least squares errs only by (6)-(7)'s Euler step: half the step, half the error."""
    coarse, errors = sinusoid(0.5, 30.0, 0.1), []
    for finer in (4, 8, 16):
        period = 0.1 / finer
        n = np.repeat(coarse, finer)
        signals = speed_signals(motion(n, period, substeps=2)[1], n, period, replace(BATCH, regression_step_s=period))
        found = identify_signals(signals, "II", BATCH).parameters
        errors.append([found.beta_m_per_rev2 / TRUTH.beta_m_per_rev2 - 1, found.tau_s / TRUTH.tau_s - 1])
    orders = np.log2(np.abs(np.array(errors[:-1]) / np.array(errors[1:])))
    assert found.alpha_per_m == pytest.approx(TRUTH.alpha_per_m, rel=1e-3)
    np.testing.assert_allclose(orders, 1.0, atol=0.2)


def test_speed_is_minus_the_rate_of_the_range(record):
    range_m, n, u = record
    signals = range_signals(range_m, n, PERIOD_S, PAPER)
    index = np.rint(signals.time_s / PERIOD_S).astype(int)
    assert signals.step_s == pytest.approx(0.5) and signals.time_s[0] == pytest.approx(2.0)
    assert np.corrcoef(signals.u_m_s, u[index])[0, 1] > 0.98
    assert np.std(signals.u_m_s - u[index]) < 0.2 * np.std(u)


@pytest.mark.parametrize("estimator", ["kalman", "two_stage", "least_squares"])
@pytest.mark.parametrize("model", ["I", "II", "III"])
def test_compiled_method_equals_filterpy(record, estimator, model):
    range_m, n, _ = record
    settings = replace(PAPER, estimator=estimator)
    reference = identify_paper(range_m, n, PERIOD_S, model, settings)
    twin = identify_paper(range_m, n, PERIOD_S, model, replace(settings, compiled=True))
    np.testing.assert_allclose(twin.evolution.c, reference.evolution.c, rtol=1e-6, atol=1e-10)
    assert twin.feet == pytest.approx(reference.feet, rel=1e-5)


def test_an_estimate_carries_what_the_tables_and_figures_show(record):
    range_m, n, _ = record
    estimate = identify_paper(range_m, n, PERIOD_S, "II", BATCH)
    a, b, gamma, tau = estimate.feet
    assert a < 0 < b and gamma == 0 and tau > 0 and estimate.unstable == ()
    error = estimate.residuals_m_s
    assert estimate.statistics.rms == pytest.approx(np.sqrt(np.mean(error**2)))
    assert estimate.statistics_ft_s.deviation == pytest.approx(error.std() / 0.3048)
    assert estimate.coherence[1].max() <= 1.0
    evolving = identify_paper(range_m, n, PERIOD_S, "II", replace(PAPER, compiled=True))
    assert evolving.parameter_evolution.shape == (evolving.rows.z.size, 4)
    assert evolving.parameter_evolution[-1, 0] == evolving.parameters.alpha_per_m


def test_literal_q_never_settles_and_a_small_normalised_one_does(record):
    """Swing of b over the last third of the record against its median: the print's q_ii = 1 rewrites it every step."""
    range_m, n, _ = record
    swing = {}
    for scaling, q_ii in (("literal", 1.0), ("normalised", 1.0), ("normalised", 1e-6)):
        settings = replace(PAPER, scaling=scaling, q_model_ii=q_ii, compiled=True)
        b = identify_paper(range_m, n, PERIOD_S, "II", settings).parameter_evolution[-38:, 1]
        swing[scaling, q_ii] = np.ptp(b) / abs(np.median(b))
    assert swing["literal", 1.0] > 3.0
    assert swing["normalised", 1.0] > 0.5
    assert swing["normalised", 1e-6] < 0.1


def test_model_i_turns_unstable_where_the_thrust_lags():
    """Its drag comes out positive once the speed trails the propeller by more than a quarter period (Table 1)."""
    n = 12.0 * np.cos(0.7 * PERIOD_S * np.arange(900))
    for tau_s, flags in ((0.01, ()), (0.7, ("a",))):
        x, _ = motion(n, PERIOD_S, from_feet(-0.0276, 0.0013, 0.0, tau_s), substeps=20)
        assert identify_paper(STANDOFF_M - x, n, PERIOD_S, "I", BATCH).unstable == flags


def test_a_diverged_estimate_has_neither_statistics_nor_coherence(record):
    range_m, n, _ = record
    signals = range_signals(range_m, n, PERIOD_S, BATCH)
    turned = replace(signals, u_m_s=3.0 * np.sinh(0.02 * signals.time_s), n_rev_s=0.0 * signals.n_rev_s + 1.0)
    estimate = identify_signals(turned, "I", BATCH)
    assert estimate.unstable == ("a",)
    assert np.isnan(estimate.statistics.mean) == estimate.diverged
    longer = replace(turned, n_rev_s=np.ones(20000), u_m_s=np.resize(turned.u_m_s, 20000))
    assert np.isnan(cross_validation([estimate.parameters], [longer])[0][0].rms)


def test_cross_validation_puts_parameters_in_rows_and_records_in_columns():
    records = []
    for omega in (0.5, 0.7):
        n = sinusoid(omega)
        records.append(speed_signals(motion(n, PERIOD_S, substeps=4)[1], n, PERIOD_S, BATCH))
    own = [identify_signals(signals, "II", BATCH) for signals in records]
    matrix = cross_validation([estimate.parameters for estimate in own], records)
    for i, estimate in enumerate(own):
        assert matrix[i][i] == estimate.statistics
        assert matrix[i][1 - i].deviation != estimate.statistics.deviation
    half = replace(own[0].parameters, beta_m_per_rev2=0.5 * own[0].parameters.beta_m_per_rev2)
    assert cross_validation([half], records)[0][0].deviation > 2 * matrix[0][0].deviation


# --- runs ------------------------------------------------------------------------------------------------------------


def test_a_run_gives_what_its_arrays_give(record):
    range_m, n, _ = record
    time = PERIOD_S * np.arange(n.size)
    run = Run("one", time, {"n_rev_s": n, "range_m": range_m})
    expected = identify_paper(range_m, n, PERIOD_S, "II", BATCH).feet
    assert identify_run(run, "II", BATCH).feet == pytest.approx(expected, rel=1e-9)
    ahead = Run("one", time, {"n_rev_s": n, "position_m": STANDOFF_M - range_m})
    assert identify_run(ahead, "II", BATCH).feet == pytest.approx(identify_run(run, "II", BATCH).feet, rel=1e-9)


def test_a_run_with_jittered_times_and_missing_samples_is_identified():
    """Speed at irregular 0.1 s (as a GPS logger writes it), input at half that rate."""
    rng = np.random.default_rng(7)
    n = np.repeat(sinusoid(0.5, 120.0, 0.2), 2)
    u = motion(n, PERIOD_S, substeps=4)[1]
    time = PERIOD_S * np.arange(n.size) + rng.uniform(-0.005, 0.005, n.size)
    n_sampled = np.where(np.arange(n.size) % 2 == 0, n, np.nan)
    u[rng.random(n.size) < 0.02] = np.nan
    found = identify_run(
        Run("gps", time, {"n_rev_s": n_sampled, "surge_m_s": u}), "II", replace(BATCH, regression_step_s=0.2)
    )
    assert found.parameters.beta_m_per_rev2 == pytest.approx(TRUTH.beta_m_per_rev2, rel=0.15)
    assert found.parameters.tau_s == pytest.approx(TRUTH.tau_s, rel=0.3)


def test_a_thrust_takes_the_place_of_the_squared_propeller_speed():
    """du/dt = a u|u| + F / M: b must come out as one over the moving mass."""
    mass_kg, period = 95.0, 0.02
    force = 40.0 * np.sin(np.arange(3000) * period) + 25.0 * np.sin(2.7 * np.arange(3000) * period)
    drag = Lumped(-0.5, 1.0 / mass_kg, 0.0, 1e-3)
    u = motion(np.sign(force) * np.sqrt(np.abs(force)), period, drag, substeps=40)[1]
    run = Run("drive", period * np.arange(3000), {"thrust_N": force, "surge_m_s": u})
    found = identify_run(run, "I", replace(BATCH, regression_step_s=period)).parameters
    assert 1.0 / found.beta_m_per_rev2 == pytest.approx(mass_kg, rel=0.02)
    with pytest.raises(InputError, match="model III needs a propeller speed"):
        identify_run(run, "III", BATCH)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"n_rev_s": [1.0, 1.0, 1.0]}, "none of range_m"),
        ({"n_rev_s": [1.0, 1.0, 1.0], "range_m": [3.0, np.nan, 3.0]}, "has 2 samples"),
        ({"n_rev_s": [1.0, 1.0, 1.0], "surge_m_s": [0.0, 0.1, 0.2]}, "too few steps"),
        ({"n_rev_s": [np.nan] * 3, "surge_m_s": [0.0, 0.1, 0.2]}, "no time at which both"),
    ],
)
def test_runs_that_cannot_be_identified_say_why(columns, message):
    run = Run("bad", np.array([0.0, 0.1, 0.2]), {name: np.array(values) for name, values in columns.items()})
    with pytest.raises(InputError, match=message):
        identify_run(run, "II", PAPER)


def test_a_run_with_an_enormous_gap_is_refused():
    time = np.array([0.0, 0.1, 0.2, 0.3, 1e7])
    with pytest.raises(InputError, match="split the run"):
        identify_run(Run("gap", time, {"n_rev_s": np.ones(5), "range_m": np.ones(5)}), "II", PAPER)
