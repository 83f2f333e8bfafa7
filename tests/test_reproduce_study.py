"""The study: what the estimator is shown, many seeds, calibration, and the arithmetic of the findings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vtank.estimate.paper.least_squares import least_squares
from vtank.estimate.paper.regression import recover, regression
from vtank.estimate.paper.signals import range_signals
from vtank.plant.lumped import to_feet
from vtank.studies.paper.calibration import Calibration, calibrate
from vtank.studies.paper.evidence import positive_within, pure_noise, reproduced, within
from vtank.studies.paper.practice import practise
from vtank.studies.paper.published import SETS, brutzman_a_per_ft
from vtank.studies.paper.records import records, signals
from vtank.studies.paper.study import EXPERIMENTS, FAST, QUANTITIES, Level, levels, quantiles, study, study_csv

LSE = FAST["least_squares"]


@pytest.fixture(scope="module")
def flown():
    return records("physical", 2, 7, ["duration_s=60"])


def test_recorded_signals_are_those_of_the_papers_method(flown):
    for settings in (LSE, replace(LSE, filter_propeller=False), replace(LSE, regression_step_s=0.2)):
        r = flown[0][0]
        ours, method = (
            signals(r, settings),
            range_signals(*(r.run.columns[name] for name in ("range_m", "n_rev_s")), 0.1, settings),
        )
        np.testing.assert_array_equal(ours.u_m_s, method.u_m_s)
        np.testing.assert_array_equal(ours.n_rev_s, method.n_rev_s)


def test_measured_speed_is_truth_and_distortion_and_noise(flown):
    """The sonar filter is linear, so the parts add up to the recorded speed."""
    for r in flown[0]:
        exact, distorted, noisy, recorded = (
            signals(r, LSE, case).u_m_s for case in ("exact", "filter u", "noise", "recorded")
        )
        np.testing.assert_allclose(distorted + noisy - exact, recorded, atol=1e-12)
        assert np.std(noisy - exact) > 0.005


def test_cases_without_noise_leave_out_its_every_trace(flown):
    quiet = records("physical", 2, 7, [*EXPERIMENTS["no noise"], "duration_s=60"])
    r = quiet[1][2]
    np.testing.assert_array_equal(signals(r, LSE).u_m_s, signals(r, LSE, "filter u").u_m_s)
    np.testing.assert_array_equal(signals(r, LSE).n_rev_s, signals(r, LSE, "filter u,n").n_rev_s)
    with pytest.raises(ValueError, match="expected one of"):
        signals(r, LSE, "other")


def test_noise_alone_makes_drag_and_lag_as_derived():
    """Least squares on white noise in u: a = -sqrt(2/pi)/(3 s T) and tau = 2T/3, within four standard errors."""
    rng, deviation, step = np.random.default_rng(3), 0.05, 0.5
    found = []
    for _ in range(40):
        u = 0.3048 * deviation * rng.standard_normal(4000)
        n = 10.0 * np.sin(0.3 * np.arange(u.size))
        a, _, _, tau = to_feet(recover(least_squares(regression(u, n, step, "II")).final, step, "II"))
        found.append((a, tau))
    error = np.std(found, axis=0) / np.sqrt(len(found))
    np.testing.assert_array_less(np.abs(np.mean(found, axis=0) - pure_noise(deviation, step)), 4.0 * error)
    assert pure_noise(deviation, step)[0] == pytest.approx(-10.6, abs=0.05)


@pytest.mark.slow
def test_study_is_reproducible_from_its_seed_and_shares_noise_among_truths():
    chosen = [level for level in levels() if level.factor in ("method", "T")]
    one, again, other = (study(seed, 2, truths=("physical",), chosen=chosen) for seed in (11, 11, 12))
    assert study_csv(one) == study_csv(again) != study_csv(other)
    for key, estimates in one.estimates.items():
        assert estimates.shape == (2, SETS, len(QUANTITIES))
        np.testing.assert_array_equal(estimates, again.estimates[key])


@pytest.mark.slow
def test_at_a_short_step_the_lag_collapses_and_the_printed_q_forgets_the_truth():
    chosen = [level for level in levels() if level.factor in ("method", "T")]
    s = study(1996, 6, truths=("physical", "paper-ii"), chosen=chosen)
    for truth in s.truths:
        assert s.band(truth, s.level("T", "0.1 s", "least_squares"), "tau")[1] == pytest.approx(0.09, abs=0.02)
    low, high = (s.band(t, s.level("method", "least_squares", "least_squares"), "a")[1] for t in s.truths)
    printed_low, printed_high = (s.band(t, s.level("method", "kalman", "kalman"), "a")[1] for t in s.truths)
    assert high < 2.0 * low < 0.0  # least squares tells the vehicles apart
    assert printed_high / printed_low == pytest.approx(1.0, abs=0.5)  # the printed Q does not
    assert printed_low < 15.0 * s.truths["physical"][0]
    with pytest.raises(KeyError):
        s.of("physical", "T", "7 s", "kalman")


def test_every_level_has_an_experiment_and_the_base_is_computed_once():
    found = levels()
    assert {level.experiment for level in found} <= set(EXPERIMENTS)
    base = [level for level in found if level.key == Level("", "", "", FAST["kalman"]).key]
    assert {level.factor for level in base} >= {"method", "Q", "T", "filter q", "noise", "record", "amplitude"}
    assert len({(level.factor, level.label, level.method) for level in found}) == len(found)


def test_experiments_change_what_they_say():
    half, whole = (records("paper-ii", 1, 5, ["duration_s=40"], factor) for factor in (0.5, 1.0))
    for small, large in zip(half[0], whole[0], strict=True):
        assert np.ptp(small.true["range_m"]) == pytest.approx(0.5 * np.ptp(large.true["range_m"]), rel=0.25)


def test_quantiles_count_a_diverged_value_as_beyond_all_others():
    np.testing.assert_array_equal(quantiles(np.arange(11.0)), [1.0, 5.0, 9.0])
    np.testing.assert_array_equal(quantiles(np.array([1.0, np.nan, 3.0, 2.0, np.nan])), [1.0, 3.0, np.nan])


def test_a_calibration_is_read_backwards():
    """An estimator that doubles the drag, give or take a half: a published value stands for half of itself."""
    multiples = np.geomspace(0.5, 64.0, 30)
    a = 2.0 * multiples * brutzman_a_per_ft()
    bands = np.repeat(np.stack([1.5 * a, a, 0.5 * a], axis=-1)[:, None, :], SETS, axis=1)
    c = Calibration(multiples, {("physical", "kalman"): bands})
    low, middle, high = c.implied("physical", "kalman", 0, 20.0 * brutzman_a_per_ft())
    assert (low, middle, high) == pytest.approx((20.0 / 3.0, 10.0, 20.0), rel=0.03)
    assert np.isnan(c.implied("physical", "kalman", 0, 1000.0 * brutzman_a_per_ft())).all()


def test_calibration_rises_with_the_true_drag_by_least_squares():
    c = calibrate(3, 3, multiples=(1.0, 30.0), bases=("paper-ii",))
    one, thirty = c.bands["paper-ii", "least_squares"][..., 1]
    assert (thirty < 3.0 * one - 0.1).all()


def test_shares_of_reproduced_values():
    printed = np.array([1.0, -2.0])
    assert within(np.array([[1.9, -1.0], [0.4, 2.0]]), printed) == 0.5
    estimates = np.ones((2, 2, len(QUANTITIES)))
    estimates[..., 0] = [[1.9, -1.1], [1.0, 5.0]]
    assert reproduced(estimates, {"a": printed}) == (0.75, 0.5)
    assert positive_within(np.array([1.0, 1.9]), 2.0) and not positive_within(np.array([-1.0, 1.0]), 2.0)


def test_cross_validation_has_each_model_on_every_data_set():
    p = practise(5, 1, truths=("paper-ii",))
    own, crossed = p.own("kalman_settling", "II"), p.crossed("kalman_settling", "II")
    assert own.shape == (SETS,) and crossed.shape == (1, SETS, SETS - 1)
    assert np.median(own) < 0.2 and not np.isnan(crossed).any()
    assert p.smallest["paper-ii"][0] > p.smallest["paper-ii"][1]
