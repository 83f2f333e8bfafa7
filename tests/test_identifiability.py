"""Information, separations and profiles against independent integration, closed forms and brute-force refits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vtank.diagnose.experiments import recorded
from vtank.effects.catalogue import BY_NAME
from vtank.errors import InputError
from vtank.estimate.cramer_rao import cramer_rao
from vtank.estimate.maximum_likelihood import beforehand
from vtank.estimate.optimum import descend
from vtank.estimate.problem import Problem
from vtank.experiment.scenario import load_scenario
from vtank.plant.parameters import slot, vector
from vtank.plant.truth import load_truth
from vtank.studies.design.flown import fly, tachometer_disturbance
from vtank.studies.design.profile import profiles, weak
from vtank.studies.design.study import PAPER, study
from vtank.studies.design.verdicts import SEEN, pairs, separation

QUIET = ("tachometer.noise_rev_s=0",)
TRUTH = load_truth("paper-ii")
FREE = ("alpha", "beta", "thrust_lag.tau")


@pytest.fixture(scope="module")
def paper():
    """The paper's four experiments, tachometer without noise."""
    return study([load_scenario(name, QUIET) for name in PAPER], TRUTH, "II")


@pytest.fixture(scope="module")
def slow():
    """Data set 4 alone: 0.2 rad/s."""
    return study([load_scenario("paper-ds4", QUIET)], TRUTH, "II")


def by_scipy(flown, parameters, start):
    """Ranges of a run [m], by scipy's integrator on the surge equation from stamp to stamp of the input."""
    alpha, beta, tau = parameters
    state, x = np.array(start), []
    for k, t in enumerate(flown.run.time_s):
        x.append(state[0])
        target = beta * flown.run.input[k] * abs(flown.run.input[k])

        def rates(t, s, target=target):
            return [s[1], alpha * s[1] * abs(s[1]) + s[2], (target - s[2]) / tau]

        state = solve_ivp(rates, (t, t + 0.1), state, method="RK45", rtol=1e-9, atol=1e-12).y[:, -1]
    return flown.p[slot("standoff")] - np.array(x)


def test_the_bound_is_that_of_an_independent_integration():
    flown = fly([load_scenario("paper-ds1", (*QUIET, "duration_s=25"))], TRUTH, seed=1)[0]
    looked = study([flown.scenario], TRUTH, "II")
    true = flown.p[[slot(name) for name in FREE]]
    unknowns = np.concatenate([true, np.zeros(3)])
    steps = np.concatenate([1e-3 * np.abs(true), [1e-3, 1e-3, 1e-3]])
    columns = []
    for i, step in enumerate(steps):
        ahead, back = (by_scipy(flown, *np.split(unknowns + sign * step * np.eye(6)[i], [3])) for sign in (1, -1))
        columns.append((ahead - back) / (2.0 * step))
    J = np.transpose(columns) / np.sqrt(0.006**2 + 0.01**2 / 12.0)
    information = J.T @ J
    information[5, 5] += (true[1] * flown.top_rev_s**2) ** -2  # the thrust held at first, as the fit has it
    assert looked.bound == pytest.approx(np.sqrt(np.diag(np.linalg.inv(information)))[:3], rel=2e-3)


def test_the_bound_is_that_of_the_likelihoods_own_jacobian_in_any_unit(paper):
    runs, noise = [f.run for f in paper.flown], paper.flown[0].noise
    covariance = cramer_rao(runs, paper.flown[0].p, FREE, noise.variance[0])
    sd = np.sqrt(np.diag(covariance))
    assert paper.bound == pytest.approx(sd, rel=1e-3)
    assert paper.correlation == pytest.approx(covariance / np.outer(sd, sd), abs=1e-3)


def test_information_of_runs_adds(paper, slow):
    alone = paper.single[3].covariance(FREE)
    both = (paper.single[3] + paper.single[3]).covariance(FREE)
    assert both == pytest.approx(0.5 * alone, rel=1e-9)
    assert np.all(paper.relative < slow.relative)


def test_a_scale_error_of_the_sonar_is_absorbed_as_its_closed_form_says(paper):
    """range -> (1 + s) range is alpha -> alpha / (1 + s), beta -> beta (1 + s), whatever the run."""
    verdict = next(v for v in paper.verdicts if v.effect.name == "sonar_scale")
    moves = dict(verdict.moves)
    assert verdict.standing == "absorbed"
    assert verdict.signature > 100.0 and verdict.left < 1e-2
    assert moves["alpha"] == pytest.approx(0.01, rel=1e-3)  # alpha < 0: drag is smaller by 1 %
    assert moves["beta"] == pytest.approx(0.01, rel=1e-3)
    assert moves["thrust_lag.tau"] == pytest.approx(0.0, abs=1e-5)


def test_an_offset_of_the_sonar_is_absorbed_by_the_start(paper):
    verdict = next(v for v in paper.verdicts if v.effect.name == "sonar_offset")
    samples = sum(f.run.time_s.size for f in paper.flown)
    assert verdict.standing == "absorbed"
    assert verdict.signature == pytest.approx(0.05 / np.sqrt(paper.flown[0].noise.variance[0]) * np.sqrt(samples))
    assert max(abs(by) for _, by in verdict.moves) < 1e-6


def test_the_two_delays_are_tied_to_one_sonar_and_to_nothing_else(paper):
    found = {v.effect.name: v for v in paper.verdicts}
    for one, other in (("command_delay", "sonar_latency"), ("sonar_latency", "command_delay")):
        assert found[one].standing == "tied" and found[one].left > SEEN
        assert found[one].rivals[0][0] == other and found[one].rivals[0][1] < 0.1
        assert found[one].rivals[1][1] > SEEN
    close = pairs(paper.information, paper.verdicts, FREE)
    assert {close[0].a.name, close[0].b.name} == {"command_delay", "sonar_latency"}
    assert sum("command_delay" in (p.a.name, p.b.name) for p in close) == 1  # the twin is not told twice


def test_lag_and_latency_are_near_one_another_at_one_frequency_and_apart_over_several(paper, slow):
    latency = BY_NAME["sonar_latency"]
    alone = separation(slow.information, latency, BY_NAME["thrust_lag"], FREE)
    together = separation(paper.information, latency, BY_NAME["thrust_lag"], FREE)
    assert slow.information.signature(["sonar_latency.d"]) > 40.0 and alone < 5.0
    assert together > 1.5 * np.sqrt(4.0) * alone  # four runs at 0.2 rad/s would bring a factor of 2


@pytest.mark.parametrize("name", ["linear_drag.c", "sonar_latency.d", "tether.k", "thrust_loss.gamma"])
def test_what_is_left_of_an_effect_is_what_a_refit_leaves(paper, name):
    """A small effect in recordings without noise, refitted by the estimator's own descent."""
    share = 0.02 if name != "thrust_loss.gamma" else -0.02
    size = paper.information.sizes([name])[0]
    runs = []
    for f in paper.flown:
        with_effect = vector({name: share * size}, f.p)
        runs.append(recorded(f.run, with_effect, f.scenario.standoff_m))
    problem = Problem(tuple(runs), paper.flown[0].p, FREE, noise=paper.flown[0].noise)
    theta = problem.initial()
    end = descend(problem, theta, beforehand(problem, theta), problem.filter(theta))
    assert np.sqrt(2.0 * end.cost) == pytest.approx(paper.information.separation([name], FREE, abs(share)), rel=0.02)
    verdict = next(v for v in paper.verdicts if f"{v.effect.name}." in name)
    refit = (end.theta[:3] - paper.true) / np.abs(paper.true)
    assert refit == pytest.approx(share * np.array([by for _, by in verdict.moves]), abs=2e-4)


def test_the_noise_of_the_tachometer_is_the_lags_answer_to_white_noise():
    """Variance of a first-order lag held from tick to tick, by adding up the squares of its response to one tick."""
    scenario = load_scenario("paper-ds1")
    p, n = TRUTH.vector(), np.array([3.0, -10.0, 12.0])
    sigma, memory = tachometer_disturbance(scenario, p, n)
    a = np.exp(-0.1 / TRUTH.tau_s)
    response = (1.0 - a) * a ** np.arange(2000)
    white = 2.0 * TRUTH.beta_m_per_rev2 * np.sqrt(np.mean(n**2)) * scenario.tachometer.noise_rev_s
    assert sigma == pytest.approx(white * np.sqrt(np.sum(response**2)))
    assert memory == TRUTH.tau_s
    without_lag = vector({"thrust_lag.tau": 0.0}, p)
    assert tachometer_disturbance(scenario, without_lag, n) == (pytest.approx(white), 0.05)


def test_noise_of_the_tachometer_and_turbulence_widen_the_bound(paper):
    noisy = study([load_scenario(name) for name in PAPER], TRUTH, "II")
    rough = study([load_scenario(name, ("turbulence.acceleration_m_s2=0.002",)) for name in PAPER], TRUTH, "II")
    assert np.all(noisy.relative > 1.1 * paper.relative)
    assert np.all(rough.relative > 1.5 * noisy.relative)


def test_profiles_are_parabolas_of_the_bound_where_the_bound_is_small(paper):
    found = profiles(paper, FREE, np.array([-2.0, -1.0, 0.0, 1.0, 2.0]))
    for profile in found:
        assert profile.drop == pytest.approx(profile.deviations**2, rel=0.03, abs=1e-6)
        assert profile.interval95 == pytest.approx((-1.96, 1.96), rel=0.03)


def test_weak_parameters_are_loose_or_correlated(paper):
    assert weak(paper) == list(FREE)  # all correlated by more than 0.9
    two = study([load_scenario(name, QUIET) for name in ("step-coast", "multisine")], TRUTH, "II")
    assert np.max(two.relative) < 0.01 and np.max(np.abs(two.correlation - np.eye(3))) < 0.9
    assert weak(two) == [FREE[np.argmax(two.relative)]]  # none is: the loosest stands in


@pytest.mark.parametrize(
    ("scenario", "settings", "model", "word"),
    [
        ("paper-ds1", (), "III", "thrust_loss.gamma"),
        ("paper-ds1", ("sonar.noise_m=0", "sonar.resolution_m=0"), "II", "sonar.noise_m"),
        ("station-keeping", (), "II", "waves"),
        ("sway", (), "II", "axis"),
    ],
)
def test_what_cannot_be_weighed_is_refused(scenario, settings, model, word):
    with pytest.raises(InputError, match=word):
        study([load_scenario(scenario, settings)], TRUTH, model)
