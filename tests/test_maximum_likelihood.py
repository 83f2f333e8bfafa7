"""The maximum-likelihood fit: finds the truth, says how sure it is, and what it cannot say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom
from synthetic import observed, sine, turbulence

from vtank.errors import InputError
from vtank.estimate.first_guess import first_guesses
from vtank.estimate.maximum_likelihood import MODELS, fit, identify
from vtank.estimate.observed import POSITION, RANGE, SPEED, observe
from vtank.estimate.optimum import Prior, descend
from vtank.estimate.problem import Filtered, Problem
from vtank.estimate.process_noise import SUSPICIOUS, colour
from vtank.plant.parameters import slot, vector
from vtank.record import Run

TRUTH = {"alpha": -2.5, "beta": 5e-4, "thrust_loss.gamma": -0.05, "thrust_lag.tau": 0.7}
OMEGAS = (0.5, 0.3, 0.8)


def truth_of(model, **other):
    return vector({name: value for name, value in TRUTH.items() if name in MODELS[model]} | other)


def runs_of(p, channels=None, seed=None, **how):
    """Three sinusoids."""
    seeds = [None if seed is None else 10 * seed + i for i in range(len(OMEGAS))]
    pairs = zip(OMEGAS, seeds, strict=True)
    return [observed(p, sine(15.0, w), channels, s, name=f"run_{w}", **how) for w, s in pairs]


# --- it finds the truth ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", MODELS)
def test_noise_free_data_give_the_truth_back(model):
    estimate = identify(runs_of(truth_of(model)), model)
    assert estimate.converged
    for name, value in estimate.values.items():
        assert value == pytest.approx(TRUTH[name], rel=1e-4)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("channels", [{RANGE: 0.1}, {POSITION: 0.25}, {SPEED: 0.1}, {RANGE: 0.1, SPEED: 0.5}])
def test_noisy_data_give_the_truth_within_the_errors_claimed(model, channels):
    estimate = identify(runs_of(truth_of(model), channels, seed=1), model)
    assert estimate.converged and estimate.problem.noise.sigma == 0.0
    for name, value in estimate.values.items():
        assert abs(value - TRUTH[name]) < 4 * estimate.sd[name]
        assert estimate.sd[name] < 0.5 * abs(TRUTH[name])
    for kind in channels:
        assert estimate.rms(kind) == pytest.approx({RANGE: 0.006, POSITION: 0.006, SPEED: 0.01}[kind], rel=0.1)


def test_range_and_position_together_need_no_surveyed_standoff():
    p = truth_of("II", standoff=4.2)
    estimate = identify(runs_of(p, {RANGE: 0.1, POSITION: 0.2}, seed=2), "II")
    assert estimate.converged and abs(estimate.values["alpha"] - TRUTH["alpha"]) < 4 * estimate.sd["alpha"]
    assert estimate.problem.model(estimate.theta, 0)[0][slot("standoff")] == pytest.approx(4.2, abs=0.005)


def test_a_run_may_start_in_motion_and_at_a_latent_thrust():
    p = truth_of("II")
    runs = runs_of(p, seed=3, state=(0.4, -0.2, 0.05, 0.0))
    estimate = identify(runs, "II")
    assert abs(estimate.values["thrust_lag.tau"] - 0.7) < 4 * estimate.sd["thrust_lag.tau"]
    start = estimate.problem.model(estimate.theta, 0)[1]
    np.testing.assert_allclose(start[:3], [0.0, -0.2, 0.05], atol=0.05)  # x counts from where the run starts


def test_a_thrust_input_gives_the_moving_mass():
    mass = 212.8
    p = vector({"alpha": -0.8, "beta": 1 / mass, "linear_input": 1.0})
    runs = [
        observed(p, lambda t, w=w: 20.0 * np.cos(w * t), {POSITION: 0.1}, seed, "thrust_N")
        for seed, w in enumerate((0.4, 0.7))
    ]
    estimate = identify(runs, "I")
    assert estimate.problem.base[slot("linear_input")] == 1.0
    assert 1 / estimate.values["beta"] == pytest.approx(mass, rel=0.01)


TROUBLED = [
    (seed, model, kind) for seed in range(8) for model in ("II", "III") for kind in ("sines", "one sine", "steps")
]


@pytest.mark.parametrize(("seed", "model", "kind"), TROUBLED)
def test_the_start_is_found_wherever_the_truth_lies(seed, model, kind):
    """Drag over three decades, lag over two, thrust over two; some runs start in motion."""
    rng = np.random.default_rng([seed, len(model), len(kind)])
    values = {"alpha": -(10 ** rng.uniform(-1.5, 1.3)), "beta": 10 ** rng.uniform(-3.8, -2.0)}
    values |= {"thrust_lag.tau": 10 ** rng.uniform(-1.3, 0.7)}
    values |= {"thrust_loss.gamma": -(10 ** rng.uniform(-3, -0.7))} if model == "III" else {}
    start = (0.0, rng.uniform(-0.3, 0.3) if seed % 2 else 0.0, 0.0, 0.0)
    inputs = {
        "sines": [sine(rng.uniform(8, 20), rng.uniform(0.15, 0.9)) for _ in range(3)],
        "one sine": [sine(rng.uniform(8, 20), rng.uniform(0.15, 0.9))],
        "steps": [lambda t: 12.0 * np.sign(np.sin(0.25 * t + 0.1)), sine(15.0, 0.5)],
    }[kind]
    runs = [observed(vector(values), n, seed=10 * seed + i, state=start) for i, n in enumerate(inputs)]
    estimate = identify(runs, model, process_noise=False)
    assert estimate.rms(RANGE) < 1.1 * 0.006


# --- it says how sure it is ------------------------------------------------------------------------------------------


def z_scores(model, seeds, p, sigma=0.0, **how):
    """Errors over their claimed deviations, shape (seeds, parameters), and the estimates."""
    estimates, scores = [], []
    for seed in range(seeds):
        rng = np.random.default_rng([7, seed])
        runs = [
            observed(p, sine(15.0, w), None, 100 * seed + i, disturbance=turbulence(sigma, 1.5, 6000, rng), **how)
            for i, w in enumerate(OMEGAS[:2])
        ]
        estimates.append(identify(runs, model))
        found = estimates[-1]
        scores.append([(found.values[name] - TRUTH[name]) / found.sd[name] for name in found.values])
    return np.array(scores), estimates


@pytest.mark.slow
@pytest.mark.parametrize("sigma", [0.0, 0.004], ids=["calm", "turbulent"])
def test_intervals_cover_in_calm_and_in_turbulent_water(sigma):
    seeds = 24
    scores, estimates = z_scores("II", seeds, truth_of("II"), sigma)
    inside = int(np.sum(np.abs(scores) < 1.96, axis=0).min())
    assert inside >= binom.ppf(1e-4, seeds, 0.95)
    squares = np.mean(scores**2, axis=0)  # one, and 4 deviations of it to either side
    assert np.all(squares < 1 + 4 * np.sqrt(2 / seeds)) and np.all(squares > 0.25)
    assert np.all(np.abs(np.mean(scores, axis=0)) < 4 / np.sqrt(seeds))
    found = [estimate.problem.noise.sigma for estimate in estimates]
    if sigma:
        assert np.median(found) == pytest.approx(sigma, rel=0.4) and min(found) > 0
    else:
        assert sum(level > 0 for level in found) <= 1  # false alarms


@pytest.mark.slow
def test_in_turbulence_simulation_alone_goes_astray():
    """What the process noise is for: it halves the errors here, and still finds the sonar's noise."""
    p, errors = truth_of("II"), []
    for seed in range(6):
        rng = np.random.default_rng([8, seed])
        runs = [
            observed(p, sine(15.0, w), None, 100 * seed + i, disturbance=turbulence(0.006, 1.5, 6000, rng))
            for i, w in enumerate(OMEGAS)
        ]
        fits = identify(runs, "II"), identify(runs, "II", process_noise=False)
        assert fits[0].log_likelihood > fits[1].log_likelihood + 100
        assert fits[0].problem.noise.variance[RANGE] == pytest.approx(0.006**2, rel=0.15)
        errors.append([abs(found.values["thrust_lag.tau"] - 0.7) for found in fits])
    careful, careless = np.sqrt(np.mean(np.square(errors), axis=0))
    assert careful < 0.5 * careless


def test_intervals_and_correlation_are_those_of_the_covariance():
    estimate = identify(runs_of(truth_of("II"), seed=4), "II")
    low, high = estimate.interval95("beta")
    assert high - low == pytest.approx(2 * 1.96 * estimate.sd["beta"], rel=1e-4)
    assert estimate.values["beta"] == pytest.approx((low + high) / 2)
    correlation = estimate.correlation
    assert np.allclose(np.diag(correlation), 1) and np.allclose(correlation, correlation.T)
    assert estimate.vector()[slot("thrust_lag.tau")] == estimate.values["thrust_lag.tau"]
    assert np.isnan(estimate.rms(SPEED))


# --- it says what it cannot say --------------------------------------------------------------------------------------


def test_one_sinusoid_does_not_carry_model_iii():
    """A second optimum, of six times the drag, is as likely but for chance: it is told beside the first."""
    one = identify([observed(truth_of("III"), sine(9.0, 0.5), seed=5)], "III")
    for name in MODELS["III"]:
        assert abs(one.values[name] - TRUTH[name]) < 3.0 * one.sd[name]
    assert "explained about as well by alpha = -14.6, beta = 0.00131" in " ".join(one.warnings)
    three = identify(runs_of(truth_of("III"), seed=5), "III")
    assert not any("not determined" in warning for warning in three.warnings)


def test_a_lag_that_is_not_there_runs_into_its_bound():
    estimate = identify(runs_of(truth_of("I"), seed=6), "II")
    assert any("thrust_lag.tau has run into its bound" in warning for warning in estimate.warnings)


def test_drag_is_never_negative():
    """A hull that something pushes along its way would ask for it."""
    driven = vector({"alpha": 0.3, "beta": 2e-3})
    estimate = identify([observed(driven, sine(12.0, 0.7), seed=7, duration_s=15.0)], "I", process_noise=False)
    assert estimate.values["alpha"] == 0.0
    assert any("alpha has run into its bound" in warning for warning in estimate.warnings)


def test_runs_that_do_not_go_together_are_refused():
    p = truth_of("II")
    force = observed(vector({"alpha": -1.0, "beta": 0.01, "linear_input": 1.0}), sine(5.0, 0.5), input_name="thrust_N")
    with pytest.raises(InputError, match="the same input; found run_0.5: n_rev_s.*run: thrust_N"):
        identify([*runs_of(p), force], "I")
    with pytest.raises(InputError, match="Model III needs a propeller speed"):
        identify([force], "III")


# --- parts -----------------------------------------------------------------------------------------------------------


def test_the_jacobian_is_the_derivative_of_the_residuals():
    base = vector({"thrust_lag.tau": 0.5, "wake_memory.k": 0.1, "seiche.amplitude": 0.02, "tether.k": 0.01})
    runs = tuple(runs_of(truth_of("III"), {RANGE: 0.1, SPEED: 0.5}, seed=8))
    free = (*MODELS["III"], "linear_drag.c", "sonar_latency.d", "thrust_deadband.n0")
    problem = Problem(runs, base, free, ("seiche.phase",))
    theta = problem.initial(
        vector(TRUTH | {"linear_drag.c": 0.1, "sonar_latency.d": 0.13, "thrust_deadband.n0": 0.7}, base)
    )
    theta += 0.01
    for noise in (problem.noise, replace(problem.noise, sigma=0.02)):
        problem = problem.with_noise(noise)
        held = problem.filter(theta)
        J = problem.jacobian(theta, held)
        for i in range(problem.size):
            h = 1e-5
            up, down = (problem.residuals(theta + sign * h * np.eye(problem.size)[i], held) for sign in (1, -1))
            central = (up - down) / (2 * h)
            np.testing.assert_allclose(J[:, i], central, atol=2e-3 * np.abs(central).max() + 1e-6)
        residual, beside = problem.linearise(theta, held)
        np.testing.assert_array_equal(beside, J)
        np.testing.assert_array_equal(residual, problem.residuals(theta, held))


def test_a_run_has_its_own_unknowns_and_no_other():
    runs = (observed(truth_of("II"), sine(15.0, 0.5)), observed(truth_of("II"), sine(15.0, 0.5), {SPEED: 0.1}))
    problem = Problem(runs, vector({"thrust_lag.tau": 0.5}), MODELS["II"], ("seiche.phase",))
    assert problem.size == 3 + (1 + 3) + (1 + 2) and problem.start_states(1) == (1, 2)
    theta = np.arange(1.0, problem.size + 1)
    p, start = problem.model(theta, 1)
    assert p[slot("thrust_lag.tau")] == 3.0 and p[slot("seiche.phase")] == 8.0
    assert start.tolist() == [0.0, 9.0, 10.0, 0.0]
    J = problem.jacobian(problem.initial(), problem.filter(problem.initial()))
    assert not J[: runs[0].time_s.size, problem.own_slice(1)].any()


def test_descent_stops_at_a_bound_and_at_a_prior():
    problem = Problem(tuple(runs_of(truth_of("I"), seed=9)), vector({}), MODELS["I"])
    theta = problem.initial(vector({"alpha": -2.0, "beta": 4e-4}))
    nothing = np.full(problem.size, np.inf)
    open_ = Prior(np.zeros(problem.size), nothing, -nothing, nothing)
    held = problem.filter(theta)
    free = descend(problem, theta, open_, held)
    assert free.converged and free.theta[0] == pytest.approx(TRUTH["alpha"], rel=0.02)
    walled = replace(open_, low=np.concatenate([[-2.2], -nothing[1:]]))
    assert descend(problem, theta, walled, held).theta[0] == -2.2
    tight = replace(open_, mean=np.full(problem.size, -2.1), sd=np.concatenate([[1e-6], nothing[1:]]))
    assert descend(problem, theta, tight, held).theta[0] == pytest.approx(-2.1, abs=1e-4)


def test_a_model_that_runs_away_is_a_bad_fit_and_no_crash():
    problem = Problem(tuple(runs_of(truth_of("I"), seed=9)), vector({}), MODELS["I"])
    theta = problem.initial(vector({"alpha": 50.0, "beta": 4e-2}))
    held = problem.filter(problem.initial(truth_of("I")))
    assert np.isfinite(problem.residuals(theta, held)).all() and np.isfinite(problem.jacobian(theta, held)).all()


def test_colour_tells_white_residuals_from_drifting_ones():
    rng = np.random.default_rng(12)

    def of(e):
        return colour([Filtered(e, np.ones(e.size), np.zeros((e.size, 6)))])

    assert max(of(rng.standard_normal(3000)) for _ in range(200)) < SUSPICIOUS + 0.5
    drift = 0.3 * turbulence(1.0, 0.5, 3000, rng)
    assert of(rng.standard_normal(3000) + drift) > SUSPICIOUS


def test_first_guesses_are_of_the_right_order():
    problem = Problem(tuple(runs_of(truth_of("III"), seed=13)), vector({"thrust_lag.tau": 0.5}), MODELS["III"])
    guess = dict(zip(problem.free, first_guesses(problem)[0], strict=False))
    for name, value in guess.items():
        assert 0.3 < value / TRUTH[name] < 3.0
    held = replace(problem, free=("alpha",), base=truth_of("III"))
    assert first_guesses(held)[0][0] == pytest.approx(TRUTH["alpha"], rel=0.5)


def test_only_what_is_free_is_fitted():
    base = truth_of("III")
    problem = Problem(tuple(runs_of(base, seed=14)), base, ("thrust_loss.gamma",))
    estimate = fit(problem, first_guesses(problem))
    assert estimate.values.keys() == {"thrust_loss.gamma"}
    assert abs(estimate.values["thrust_loss.gamma"] + 0.05) < 4 * estimate.sd["thrust_loss.gamma"]


# --- from a run ------------------------------------------------------------------------------------------------------


def test_a_run_is_observed_as_it_was_recorded():
    time = np.arange(20) * 0.1
    nan = np.nan
    run = Run.from_channels(
        "r",
        {
            "n_rev_s": (time, np.arange(20.0)),
            "surge_m_s": (time[::5] + 0.02, np.arange(4.0)),
            "range_m": (time[::2], 3.0 - 0.1 * np.arange(10)),
            "depth_m": (time, np.zeros(20)),
        },
    )
    o = observe(run)
    assert o.time_s.size == 14 and np.all(np.diff(o.time_s) >= 0) and o.input_name == "n_rev_s"
    assert set(o.kind) == {RANGE, SPEED} and o.has_position and o.first == {RANGE: 3.0, SPEED: 0.0}
    assert o.start(vector({"standoff": 5.0})).tolist() == [2.0, 0.0, 0.0, 0.0] and o.input.tolist() == list(
        np.arange(20.0)
    )
    blind = Run("blind", time, {"n_rev_s": np.ones(20), "depth_m": np.full(20, nan)})
    with pytest.raises(
        InputError, match="run 'blind': no measurement to fit; expected one of range_m, position_m, surge_m_s"
    ):
        observe(blind)
