"""The quick likelihood of a noise level against the extended Kalman filter, and the level it finds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from vtank.diagnose.noise_floor import noise_at
from vtank.estimate import noise_likelihood
from vtank.estimate.maximum_likelihood import refit
from vtank.estimate.noise_likelihood import linearised, squares_and_logs
from vtank.estimate.noise_search import HOPELESS, Likelihood, NoiseSearch
from vtank.estimate.observed import observe
from vtank.estimate.problem import FLAGGED, Noise, Problem
from vtank.estimate.simplex import simplex
from vtank.experiment import simulate_surge
from vtank.experiment.plan import plan_run
from vtank.experiment.scenario import load_scenario
from vtank.lanes import WIDTH
from vtank.plant.parameters import vector
from vtank.plant.truth import load_truth

P = load_truth("paper-ii").vector()
STILL = ("sonar.resolution_m=0", "sonar.noise_m=0.006", "tachometer.noise_rev_s=0")
NOISE = Noise((3.6e-5, 3.6e-5, 3.6e-5), 0.002, 2.0)
COLOURED = replace(NOISE, variance=(1e-6, 1e-6, 1e-6), colour_sigma=0.006, colour_time=0.5)


LATE = {"sonar_latency.d": 0.25, "clock_skew.s": 0.003}


def flown(settings, seed=3, values=None):
    names = ("paper-ds1", "paper-ds3")
    plans = [plan_run(load_scenario(name, settings), run=k, seed=seed) for k, name in enumerate(names)]
    plans = [replace(plan, p=vector(values or {}, plan.p)) for plan in plans]
    return tuple(observe(result.run) for result in simulate_surge(plans))


def fitted(runs, p=P, **more):
    """The problem and theta at its optimum under NOISE."""
    problem = Problem(runs, p, ("alpha", "beta"), **more)
    return problem, refit(problem.with_noise(NOISE), problem.initial()).theta


@pytest.mark.parametrize("noise", [NOISE, COLOURED, replace(NOISE, sigma=1e-5)])
def test_agrees_with_the_kalman_filter_where_the_model_is_right(noise):
    problem, theta = fitted(flown((*STILL, "turbulence.acceleration_m_s2=0.002", "turbulence.time_s=2")))
    (squares,), (logs,), count = squares_and_logs(linearised(problem, theta), [noise])
    exact = problem.with_noise(noise)
    filtered = exact.filter(theta)
    sigma = np.sqrt(0.5 * sum(f.innovation.size for f in filtered))  # scatter of a log-likelihood
    assert -0.5 * (squares + logs + count * np.log(2 * np.pi)) == pytest.approx(
        exact.log_likelihood(filtered), abs=0.02 * sigma + 0.002 * abs(squares - count)
    )


def test_late_skewed_and_flagged_measurements_are_met_in_the_filters_order():
    runs = flown(STILL, values=LATE)
    weight = tuple(np.where(np.arange(run.time_s.size) % 7 == 0, FLAGGED, 1.0) for run in runs)
    problem, theta = fitted(runs, vector(LATE, P), weight=weight)
    exact = problem.with_noise(NOISE)
    (squares,), (logs,), count = squares_and_logs(linearised(problem, theta), [NOISE])
    assert count == sum(int(np.sum(problem.used(k))) for k in range(len(runs)))
    got, want = -0.5 * (squares + logs + count * np.log(2 * np.pi)), exact.log_likelihood(exact.filter(theta))
    assert got == pytest.approx(want, abs=2.0)


def test_many_runs_and_levels_at_once_are_each_what_they_are_alone():
    long, short = flown(STILL)
    part = slice(0, 400)
    short = replace(short, time_s=short.time_s[part], value=short.value[part], kind=short.kind[part])
    problem = Problem((long, short) * 9 + (short,), P, ("alpha", "beta"))  # more than there are lanes
    runs, levels = linearised(problem, problem.initial()), [NOISE, COLOURED, replace(NOISE, sigma=0.05)]
    each = [linearised(problem.alone(k), problem.alone(k).initial()) for k in range(2)]
    counted = (9, 10)
    for level, squares, logs in zip(levels, *squares_and_logs(runs, levels)[:2], strict=True):
        alone = [squares_and_logs(own, [level]) for own in each]
        assert squares == pytest.approx(sum(n * float(a[0][0]) for n, a in zip(counted, alone, strict=True)), rel=1e-12)
        assert logs == pytest.approx(sum(n * float(a[1][0]) for n, a in zip(counted, alone, strict=True)), rel=1e-12)


@pytest.mark.parametrize("evaluations", [7, 12, 30, 200])
def test_the_simplex_walks_as_the_one_of_scipy_does(evaluations: int) -> None:
    def cost(x: np.ndarray) -> float:
        return float((1.0 - x[0]) ** 2 + 100.0 * (x[1] - x[0] ** 2) ** 2 + np.sin(5.0 * x[2]) ** 2)

    corners = np.array([-1.2, 1.0, 0.5]) + np.vstack([np.zeros(3), np.diag([0.3, -0.4, 0.5])])
    options = {"maxfev": evaluations, "xatol": 1e-2, "fatol": 1e-3, "initial_simplex": corners}
    walk = simplex(corners, evaluations, 1e-2, 1e-3)
    asked, end = next(walk), None
    while end is None:
        try:
            asked = walk.send([cost(x) for x in asked])
        except StopIteration as stop:
            end = stop.value
    assert end.tolist() == minimize(cost, corners[0], method="Nelder-Mead", options=options).x.tolist()


@pytest.mark.parametrize("seed", [1, 2])
def test_turbulence_of_long_memory_is_found_again(seed):
    problem, theta = fitted(flown((*STILL, "turbulence.acceleration_m_s2=0.0015", "turbulence.time_s=4"), seed))
    found = noise_at(problem, theta)
    assert found.colour_sigma == 0.0
    assert found.variance[0] == pytest.approx(3.6e-5, rel=0.1)
    assert found.sigma == pytest.approx(0.0015, rel=0.4) and 1.5 < found.correlation_time < 12.0


def search(likelihood: Likelihood) -> NoiseSearch:
    return NoiseSearch(likelihood, Noise(), sizes=(1e-5, 20.0), memories=(0.2, 30.0))


def test_a_search_ends_at_the_likeliest_size_and_memory() -> None:
    def likelihood(noises: Sequence[Noise]) -> tuple[np.ndarray, np.ndarray, int]:
        off = np.log([(noise.sigma / 0.01, noise.correlation_time / 2.0) for noise in noises])
        return np.full(len(noises), 4e-2), 100.0 * np.sum(off**2, axis=1), 100  # scale 4e-4: a fiftieth in deviation

    found, cost = search(likelihood).likeliest(np.log([0.1, 1.0]), (-0.3, 0.3), 200, 1e-4, 1e-6)
    assert found.sigma == pytest.approx(0.01 / 50.0, rel=1e-3) and found.correlation_time == pytest.approx(
        2.0, rel=1e-3
    )
    assert found.variance == pytest.approx([4e-8] * 3) and cost == pytest.approx(50.0 * np.log(4e-4), abs=1e-3)


def test_where_the_simulation_runs_away_no_level_is_found() -> None:
    lost = search(lambda noises: (np.full(len(noises), np.nan), np.zeros(len(noises)), 10))
    noise, cost = lost.level(np.zeros(2))
    assert noise is lost.noise and cost == HOPELESS


@pytest.mark.parametrize("noise", [NOISE, COLOURED, replace(NOISE, sigma=3e-4, correlation_time=10.0)])
def test_a_long_run_is_as_likely_in_parts(monkeypatch, noise):
    settings = ("duration_s=600", "turbulence.acceleration_m_s2=0.002", "turbulence.time_s=2")
    problem, theta = fitted(flown((*STILL, *settings)))
    whole = squares_and_logs(linearised(problem, theta), [noise])
    monkeypatch.setattr(noise_likelihood, "LONG", 1000)
    parts = linearised(problem, theta)
    assert [size for size, _ in parts] == [WIDTH]
    np.testing.assert_allclose(np.hstack(squares_and_logs(parts, [noise])), np.hstack(whole), rtol=0.0, atol=0.02)
