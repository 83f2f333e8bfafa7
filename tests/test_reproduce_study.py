"""The study: what the estimator is shown, many seeds, calibration, and the arithmetic of the findings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vtank.estimate.paper.least_squares import least_squares
from vtank.estimate.paper.regression import recover, regression
from vtank.estimate.paper.signals import range_signals
from vtank.plant.lumped import to_feet
from vtank.studies.paper.evidence import FAILS, HOLDS, PARTLY, pure_noise, steady, told, within
from vtank.studies.paper.joint import BETWEEN, HIGH, LOW, MULTIPLES, READINGS, REPEATS, Joint, judge, step_prior
from vtank.studies.paper.joint import STEPS_S as TRIED_S
from vtank.studies.paper.judgement import joint_table, left
from vtank.studies.paper.judgement import quantiles as quantiles_of_step
from vtank.studies.paper.practice import practise
from vtank.studies.paper.published import SETS, published
from vtank.studies.paper.records import records, signals
from vtank.studies.paper.study import EXPERIMENTS, FAST, QUANTITIES, STEPS_S, Level, levels, quantiles, study, study_csv

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
    chosen = [level for level in levels() if level.factor == "method"]
    one, again, other = (study(seed, 2, truths=("physical",), chosen=chosen) for seed in (11, 11, 12))
    assert study_csv(one) == study_csv(again) != study_csv(other)
    for key, estimates in one.estimates.items():
        assert estimates.shape == (len(STEPS_S), 2, SETS, len(QUANTITIES))
        np.testing.assert_array_equal(estimates, again.estimates[key])


@pytest.mark.slow
def test_at_a_short_step_the_lag_collapses_and_the_printed_q_forgets_the_truth():
    chosen = [level for level in levels() if level.factor == "method"]
    s = study(1996, 6, truths=("physical", "paper-ii"), chosen=chosen)
    half = STEPS_S.index(0.5)
    for truth in s.truths:
        tau = s.medians(truth, "method", "least_squares", "least_squares", "tau")
        assert tau[0] == pytest.approx(0.09, abs=0.02) and tau[half] > 0.2  # the lag follows T, not the truth
    low, high = (s.medians(t, "method", "least_squares", "least_squares", "a")[half] for t in s.truths)
    printed_low, printed_high = (s.medians(t, "method", "kalman", "kalman", "a")[half] for t in s.truths)
    assert high < 2.0 * low < 0.0  # least squares tells the vehicles apart
    assert printed_high / printed_low == pytest.approx(1.0, abs=0.5)  # the printed Q does not
    assert printed_low < 15.0 * s.truths["physical"][0]
    with pytest.raises(KeyError):
        s.of("physical", "noise", "7 mm", "kalman")


def test_every_level_has_an_experiment_and_the_base_is_computed_once():
    found = levels()
    assert {level.experiment for level in found} <= set(EXPERIMENTS)
    base = [level for level in found if level.key == Level("", "", "", FAST["kalman"]).key]
    assert {level.factor for level in base} >= {"method", "Q", "filter q", "noise", "record", "amplitude"}
    assert len({(level.factor, level.label, level.method) for level in found}) == len(found)


def test_experiments_change_what_they_say():
    half, whole = (records("paper-ii", 1, 5, ["duration_s=40"], factor) for factor in (0.5, 1.0))
    for small, large in zip(half[0], whole[0], strict=True):
        assert np.ptp(small.true["range_m"]) == pytest.approx(0.5 * np.ptp(large.true["range_m"]), rel=0.25)


def test_quantiles_count_a_diverged_value_as_beyond_all_others():
    np.testing.assert_array_equal(quantiles(np.arange(11.0)), [1.0, 5.0, 9.0])
    np.testing.assert_array_equal(quantiles(np.array([1.0, np.nan, 3.0, 2.0, np.nan])), [1.0, 3.0, np.nan])


def test_a_claim_that_holds_at_some_steps_only_says_at_which():
    some = np.array([step in (0.2, 0.9) for step in STEPS_S])
    values = {"better": "", "calmer": "", "medians": "", "calm": ""}
    found = [told("stages", held, **values) for held in (some, some | True, some & False)]
    assert [finding.verdict for finding in found] == [PARTLY, HOLDS, FAILS]
    assert found[0].block.lead.endswith("partly supported: at T = 0.2 and 0.9 s.")
    assert found[1].block.lead.endswith("at every T.") and found[2].block.lead.endswith("at any T.")


# --- the four published sets together ---------------------------------------------------------------------------


def imagined(drag, step_s, scatter=0.1):
    """An estimator that prints the paper's values at one true drag and T, and others elsewhere."""
    table = published()[2].values
    printed = np.stack([table["a"], table["b"], np.ones(SETS), table["tau"], table["deviation"]], axis=-1)
    off = np.ones((len(MULTIPLES), len(TRIED_S), 1, 1, 1, len(QUANTITIES)))
    off[..., 0] *= (np.array(MULTIPLES) / drag)[:, None, None, None, None]  # the drag shows in a, T in tau
    off[..., 3] *= (np.array(TRIED_S) / step_s)[:, None, None, None]
    noise = np.random.default_rng(5).lognormal(0.0, scatter, (len(MULTIPLES), len(TRIED_S), 6, REPEATS, SETS, 5))
    return Joint({reading: off * printed * noise for reading in READINGS})


@pytest.mark.parametrize(("drag", "name"), [(1.0, LOW), (8.0, BETWEEN), (64.0, HIGH)])
def test_drag_and_step_that_made_the_print_are_found(drag, name):
    joint = imagined(drag, 0.8)
    assert MULTIPLES[int(np.argmax(joint.over("least_squares", "drag")))] == drag
    assert quantiles_of_step(joint)[1] == pytest.approx(0.8, abs=0.11) and left(joint) == [name]
    low, middle, high = joint.odds("least_squares", LOW, of=name)
    assert low <= middle <= high and (middle > 10.0 or name == LOW)
    assert joint.preference == pytest.approx(1.0) and joint.map("kalman").sum() == pytest.approx(1.0)
    table = joint_table(joint)
    assert [row[0] for row in table.rows[:2]] == ["unknown", "0.1 s"] and len(table.rows) == len(TRIED_S) + 2


def test_what_never_comes_out_with_the_prints_signs_has_no_likelihood():
    joint = imagined(8.0, 0.8)
    joint.estimates["kalman"][..., QUANTITIES.index("tau")] *= -1.0
    joint.estimates["least_squares"][:, 3, :, :, 0, QUANTITIES.index("s_e")] = np.nan  # diverged
    assert not joint.likelihood("kalman").any() and joint.preference == np.inf
    assert joint.likelihood("kalman", ("a", "b")).sum(axis=0).all()
    assert not joint.likelihoods["least_squares"][:, :, 3].any() and joint.likelihoods["least_squares"][:, :, 4].any()


def test_the_step_is_log_uniform_before():
    assert step_prior().sum() == pytest.approx(1.0)
    assert step_prior()[:3].sum() == pytest.approx(np.log(np.sqrt(0.3 * 0.4) / 0.1) / np.log(15.0))


def test_worlds_are_reproducible_and_the_lag_follows_the_step_in_all_of_them():
    one, again = judge(3, 2), judge(3, 2)
    a = one.estimates["least_squares"]
    np.testing.assert_array_equal(a, again.estimates["least_squares"])
    assert a.shape == (len(MULTIPLES), len(TRIED_S), 2, REPEATS, SETS, len(QUANTITIES))
    assert one.estimates["kalman"].shape[2] == 1
    tau = np.nanmedian(a[..., QUANTITIES.index("tau")], axis=(0, 2, 3, 4))
    assert (np.diff(tau[:10]) > 0.0).all() and tau[0] < 0.15


def test_shares_near_the_print():
    printed = np.array([1.0, -2.0])
    values = np.array([[[1.9, -1.0], [0.4, 2.0]], [[1.0, -2.0], [1.0, -2.0]]])
    np.testing.assert_array_equal(within(values, printed), [0.5, 1.0])
    np.testing.assert_array_equal(steady(np.array([[1.0, 1.9], [-1.0, 1.0]]), 2.0), [True, False])


def test_cross_validation_has_each_model_on_every_data_set():
    p = practise(5, 1, truths=("paper-ii",))
    own, crossed = p.own("kalman_settling", "II"), p.crossed("kalman_settling", "II")
    assert own.shape == (len(STEPS_S), SETS) and crossed.shape == (len(STEPS_S), 1, SETS, SETS - 1)
    assert np.median(own) < 0.2 and not np.isnan(crossed).any()
    assert (p.smallest["paper-ii"][0] >= p.smallest["paper-ii"][1]).all()
