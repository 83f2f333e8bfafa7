"""Heavy tails and a coloured sonar in the fit: found, allowed for, and no hindrance where there are none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student_t
from synthetic import STEP_S, observed, sine, turbulence

from vtank.estimate.heavy_tails import heavy, information, likeliest_freedom, standardised
from vtank.estimate.maximum_likelihood import identify
from vtank.estimate.problem import student
from vtank.plant.parameters import vector

TRUTH = {"alpha": -2.5, "beta": 5e-4, "thrust_lag.tau": 0.7}
P = vector(TRUTH)
SEEDS = 8


@pytest.fixture(scope="module")
def clean():
    """Two runs of a minute without noise."""
    return [observed(P, sine(15.0, w)) for w in (0.5, 0.3)]


def noisy(runs, error):
    """The runs with errors added that `error` makes of a run's number of ranges [m]."""
    return [replace(run, value=run.value + error(run.value.size)) for run in runs]


def drift(random, count):
    """6 mm with a memory of 0.5 s, at 10 Hz."""
    every = round(0.1 / STEP_S)
    return turbulence(0.006, 0.5, count * every, random)[::every]


def scores(estimate):
    """Errors over claimed deviations, shape (3,)."""
    return np.array([(estimate.values[name] - true) / estimate.sd[name] for name, true in TRUTH.items()])


def test_student_is_that_of_scipy():
    residual = np.array([-3.0, 0.2, 40.0])
    assert student(residual, 2.5) == pytest.approx(np.sum(student_t.logpdf(residual, 2.5)))


@pytest.mark.parametrize("freedom", [1.5, 3.0, 8.0])
def test_the_likeliest_freedom_and_scale(freedom):
    residual = 2.0 * np.random.default_rng(1).standard_t(freedom, 20_000)
    assert heavy(residual)
    found, scale = likeliest_freedom(residual)
    assert found == pytest.approx(freedom, rel=0.1) and scale == pytest.approx(2.0, rel=0.05)


def test_normal_and_bounded_errors_have_no_heavy_tails():
    random = np.random.default_rng(2)
    for _ in range(50):
        assert not heavy(random.standard_normal(1200)) and not heavy(random.uniform(-1.0, 1.0, 1200))


def test_weighted_squares_are_one_on_average_as_those_of_a_normal(clean):
    random = np.random.default_rng(3)
    estimate = identify(noisy(clean, lambda count: 0.01 * random.standard_t(3.0, count)))
    problem, theta = estimate.problem, estimate.theta
    residual = problem.residuals(theta, estimate.filtered)
    assert np.mean(residual**2) == pytest.approx(1.0, rel=0.02)
    assert np.std(standardised(problem, estimate.filtered)) > 1.3
    second, own = problem.alone(1), np.concatenate([theta[:3], theta[problem.own_slice(1)]])
    np.testing.assert_allclose(second.residuals(own, second.filter(own)), residual[clean[0].value.size :])


def test_information_is_fishers_where_the_residuals_follow_the_t():
    residual = np.random.default_rng(9).standard_t(3.0, 50_000)
    assert information(residual, 3.0) == pytest.approx(4.0 / 6.0, rel=0.03)


def test_normal_noise_is_left_alone(clean):
    random = np.random.default_rng(4)
    found = identify(noisy(clean, lambda count: 0.006 * random.standard_normal(count)))
    assert found.problem.weight is None and np.isinf(found.problem.noise.freedom) and found.problem.noise.quiet


def test_heavy_tails_cost_less_precision_than_least_squares_loses(clean):
    """Student's t of three degrees of freedom holds twice what its variance says (Fisher's information)."""
    random, found = np.random.default_rng(5), []
    for _ in range(SEEDS):
        found.append(identify(noisy(clean, lambda count: 0.006 * random.standard_t(3.0, count))))
    assert all(estimate.converged and 2.0 < estimate.problem.noise.freedom < 5.0 for estimate in found)
    assert np.mean([scores(estimate) ** 2 for estimate in found]) < 2.0
    white = identify(noisy(clean, lambda count: 0.006 * np.sqrt(3.0) * random.standard_normal(count)))
    spent = np.mean([estimate.sd["alpha"] for estimate in found]) / white.sd["alpha"]
    assert spent == pytest.approx(np.sqrt(0.5), rel=0.1)


def test_gross_outliers_do_not_move_the_estimate(clean):
    random = np.random.default_rng(6)
    for _ in range(4):
        runs = noisy(clean, lambda count: 0.006 * random.standard_normal(count))
        without = identify(runs)
        found = identify(noisy(runs, lambda count: 3.0 * (random.random(count) < 0.01)))
        assert found.converged and np.max(np.abs(scores(found) - scores(without))) < 2.0
        assert found.sd["alpha"] == pytest.approx(without.sd["alpha"], rel=0.25)


def test_a_coloured_sonar_is_no_rough_water(clean):
    """Simulation alone is right there; taken for a disturbance, drag came out twenty times too large."""
    random = np.random.default_rng(7)
    squares = []
    for _ in range(SEEDS):
        found = identify(noisy(clean, lambda count: drift(random, count)))
        noise = found.problem.noise
        assert found.converged and noise.sigma < 1e-4 and noise.colour_sigma == pytest.approx(0.006, rel=0.3)
        squares.append(scores(found) ** 2)
    assert np.max(squares) < 4.0**2 and np.mean(squares) < 2.0


def test_rough_water_under_a_coloured_sonar_shows_both():
    random = np.random.default_rng(8)
    found = []
    for k in range(4):
        rough = [turbulence(0.02, 3.0, 6000, random) for _ in range(2)]
        runs = [observed(P, sine(15.0, w), disturbance=d) for w, d in zip((0.5, 0.3), rough, strict=True)]
        runs = noisy(runs, lambda count: drift(random, count) + 0.003 * random.standard_normal(count))
        found.append(identify(runs))
        assert found[k].converged and np.max(np.abs(scores(found[k]))) < 4.0
    levels = [(estimate.problem.noise.sigma, estimate.problem.noise.colour_sigma) for estimate in found]
    assert np.median(levels, axis=0) == pytest.approx([0.02, 0.006], rel=0.5)
