"""Innovations of the surge model: against a plain filter, against simulation, and white where they should be."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numba.core.errors import NumbaError
from scipy.stats import chi2
from synthetic import SONAR_M, observed, sine, turbulence

from vtank.channels.channel import Channel, readers
from vtank.compiled import term
from vtank.estimate.innovations import Noise, innovations, no_gain
from vtank.estimate.innovations import filtered as filtered_by
from vtank.estimate.observed import POSITION, RANGE, SPEED, Observed
from vtank.estimate.problem import Problem
from vtank.plant.parameters import vector
from vtank.plant.surge import SURGE

PLAIN = {"alpha": -2.5, "beta": 5e-4, "thrust_loss.gamma": -0.01, "thrust_lag.tau": 0.7}
P = vector(PLAIN)
REST = np.zeros(4)
VARIANCE = np.array([SONAR_M[kind] ** 2 for kind in (RANGE, POSITION, SPEED)])


def simulate(p, run: Observed, start=REST, gain=None):
    """Innovations along a run, shape (M,)."""
    gain = no_gain(run) if gain is None else gain
    return innovations(run, p, start, Noise(), gain)


def filtered(p, run: Observed, sigma, memory=1.0, start=REST, start_sd=REST, variance=None, colour=(0.0, 1.0)):
    """Innovations, their variances and the gains."""
    level = Noise(sigma=sigma, correlation_time=memory, colour_sigma=colour[0], colour_time=colour[1])
    noise = VARIANCE[run.kind] if variance is None else variance
    found = filtered_by(run, p, start, level, noise, np.asarray(start_sd, float))
    return found.innovation, found.variance, found.gain


# --- against a filter written here in plain numpy --------------------------------------------------------------------


def plain_filter(run: Observed, sigma: float, memory: float, start_sd, colour=(0.0, 1.0), substeps: int = 20):
    """Continuous-discrete extended Kalman filter of six states, the last the sonar's coloured error.

    Mean and covariance are integrated by many midpoint steps.
    """
    error_m, error_s = colour
    a, b, g, tau = (PLAIN[k] for k in ("alpha", "beta", "thrust_loss.gamma", "thrust_lag.tau"))

    def drift(s, n):
        x, u, z, _, d, c = s
        pull = a * u * abs(u) + z + g * abs(n) * u + d
        return np.array([u, pull, (b * n * abs(n) - z) / tau, 0.0, -d / memory, -c / error_s])

    def spread(s, P, n):
        A = np.zeros((6, 6))
        A[0, 1] = A[1, 2] = A[1, 4] = 1.0
        A[1, 1], A[2, 2], A[4, 4] = 2 * a * abs(s[1]) + g * abs(n), -1 / tau, -1 / memory
        A[5, 5] = -1 / error_s
        Q = np.zeros((6, 6))
        Q[4, 4], Q[5, 5] = 2 * sigma**2 / memory, 2 * error_m**2 / error_s
        return A @ P + P @ A.T + Q

    s, P, now, out = np.zeros(6), np.diag([*np.square(start_sd), sigma**2, error_m**2]), run.time_s[0], []
    for t, value, kind in zip(run.time_s, run.value, run.kind, strict=True):
        stops = np.linspace(now, t, round((t - now) / 0.1) * substeps + 1)
        for here, there in zip(stops[:-1], stops[1:], strict=True):
            h, n = there - here, run.input[int((here + 1e-9) / 0.1)]
            middle = s + 0.5 * h * drift(s, n)
            half = P + 0.5 * h * spread(s, P, n)
            s, P = s + h * drift(middle, n), P + h * spread(middle, half, n)
        now = t
        H = np.zeros(6)
        H[5] = 1.0 if kind == RANGE else 0.0
        H[1 if kind == SPEED else 0] = -1.0 if kind == RANGE else 1.0
        e = value - ((3.048 if kind == RANGE else 0.0) + H @ s)
        S = H @ P @ H + VARIANCE[kind]
        K = P @ H / S
        s, P = s + K * e, P - np.outer(K, K) * S
        out.append((e, S, *K))
    return np.array(out)


@pytest.mark.parametrize("colour", [(0.0, 1.0), (0.02, 0.6)])
def test_filter_agrees_with_a_plain_one(colour):
    run = observed(P, sine(15.0, 0.9), {RANGE: 0.1, SPEED: 0.5}, seed=3, duration_s=8.0)
    start_sd = [0.05, 0.05, 0.03, 0.0]
    e, S, K = filtered(P, run, 0.02, 0.8, start_sd=start_sd, colour=colour)
    plain = plain_filter(run, 0.02, 0.8, start_sd, colour)
    np.testing.assert_allclose(e, plain[:, 0], atol=5e-5)
    np.testing.assert_allclose(S, plain[:, 1], rtol=2.5e-3)
    np.testing.assert_allclose(K, plain[:, 2:], atol=4e-3 * np.abs(plain[:, 2:]).max())


def test_without_process_noise_the_filter_is_a_simulation():
    run = observed(P, sine(15.0, 0.9), seed=3, duration_s=20.0)
    e, S, K = filtered(P, run, 0.0)
    np.testing.assert_array_equal(e, simulate(P, run))
    assert np.all(S == VARIANCE[RANGE]) and not K.any()


def test_the_simulation_that_a_run_keeps_is_the_one_that_is_asked_for() -> None:
    """By parameters, start and known push; and nobody can change it for the next who asks."""
    run = observed(P, sine(15.0, 0.9), seed=3, duration_s=20.0)
    push = np.full(run.input.size, 0.01)
    moved = REST + [0.0, 0.1, 0.0, 0.0]
    asked = [(P, REST, None), (P * 1.01, REST, None), (P, moved, None), (P, REST, push), (P, REST, None)]
    for p, start, forcing in [*asked, *asked]:
        found = filtered_by(run, p, start, Noise(), VARIANCE[run.kind], forcing=forcing).innovation
        assert np.array_equal(found, innovations(run, p, start, Noise(), no_gain(run), forcing=forcing))
        with pytest.raises(ValueError, match="read-only"):
            found[0] = 1.0


def test_held_gains_give_the_filters_innovations():
    run = observed(P, sine(15.0, 0.9), {RANGE: 0.1, POSITION: 0.3, SPEED: 0.5}, seed=4, duration_s=20.0)
    e, _, K = filtered(P, run, 0.02)
    np.testing.assert_allclose(simulate(P, run, gain=K), e, atol=1e-13)


def test_the_filter_knows_where_forces_depend_on_the_place():
    """Analytic column for x where nothing does; beside a tether it must be formed like the others."""
    run = observed(P, sine(15.0, 0.9), seed=3, duration_s=20.0)
    free = filtered(P, run, 0.02, start_sd=[0.1, 0.0, 0.0, 0.0])[1]
    barely = filtered(vector({"tether.k": 1e-12}, P), run, 0.02, start_sd=[0.1, 0.0, 0.0, 0.0])[1]
    tight = filtered(vector({"tether.k": 2.0}, P), run, 0.02, start_sd=[0.1, 0.0, 0.0, 0.0])[1]
    np.testing.assert_allclose(barely, free, rtol=1e-6)
    assert not np.allclose(tight, free, rtol=1e-2)


# --- matched data: white, of the right size --------------------------------------------------------------------------


@pytest.mark.parametrize(
    "channels", [{RANGE: 0.1}, {POSITION: 0.1}, {SPEED: 0.1}, {RANGE: 0.2, POSITION: 0.5, SPEED: 1.0}]
)
@pytest.mark.parametrize("sigma", [0.0, 0.02])
def test_innovations_of_matched_data_are_white_and_of_the_size_they_claim(channels, sigma):
    eps = []
    for seed in range(4):
        push = turbulence(sigma, 0.8, 6000, np.random.default_rng(100 + seed))
        run = observed(P, sine(15.0, 0.5 + 0.1 * seed), channels, seed=seed, disturbance=push)
        e, S, _ = filtered(P, run, sigma, 0.8)
        eps.append(e / np.sqrt(S))
    nis = float(np.sum(np.concatenate(eps) ** 2))
    count = sum(e.size for e in eps)
    low, high = chi2.ppf([5e-5, 1 - 5e-5], count)
    assert low < nis < high
    for lag in range(1, 11):
        r = sum(float(e[lag:] @ e[:-lag]) for e in eps) / nis
        assert abs(r) < 4.5 / math.sqrt(count)


def test_ignored_turbulence_shows():
    push = turbulence(0.02, 0.8, 6000, np.random.default_rng(5))
    run = observed(P, sine(15.0, 0.5), seed=5, disturbance=push)
    e, S, _ = filtered(P, run, 0.0)
    assert np.sum(e**2 / S) > 5 * e.size


# --- rates, gaps, clocks ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("every_s", [0.01, 0.05, 0.1, 0.5])
def test_any_rate_of_input_and_measurement(every_s):
    """Innovations of noise-free data are zero up to the error of steps ten times as long as those it was made with."""
    run = observed(P, sine(15.0, 0.6), {RANGE: 0.01, SPEED: 0.07, POSITION: 1.3}, every_s=every_s)
    assert run.time_s.size > 6000
    assert np.abs(simulate(P, run)).max() < 2e-6
    coarse = observed(P, sine(15.0, 0.6), {RANGE: 0.7}, every_s=every_s)
    assert np.abs(simulate(P, coarse)).max() < 2e-6


def test_steps_of_a_tick_cost_a_micrometre_in_two_minutes():
    run = observed(P, sine(18.0, 0.5), duration_s=120.0)
    assert np.abs(simulate(P, run)).max() < 1e-6


def test_missing_pings_leave_the_others_alone():
    run = observed(P, sine(15.0, 0.6), seed=7)
    lost = np.random.default_rng(0).uniform(size=run.time_s.size) < 0.4
    lost[0] = False
    thinned = replace(run, time_s=run.time_s[~lost], value=run.value[~lost], kind=run.kind[~lost])
    np.testing.assert_allclose(simulate(P, thinned), simulate(P, run)[~lost], atol=1e-12)
    infinite = np.where(lost, np.inf, VARIANCE[RANGE])
    for whole, part in zip(filtered(P, run, 0.02, variance=infinite), filtered(P, thinned, 0.02), strict=True):
        np.testing.assert_allclose(whole[~lost], part, rtol=1e-6, atol=1e-12)


def test_a_late_propeller_and_a_late_sonar_are_the_same_to_one_sonar():
    run = observed(P, sine(15.0, 0.6), seed=7)
    late_input = simulate(vector({"command_delay.d": 0.23}, P), run)
    late_echo = simulate(vector({"sonar_latency.d": 0.23}, P), run)
    np.testing.assert_allclose(late_input, late_echo, atol=1e-12)
    assert np.abs(late_input - simulate(P, run)).max() > 0.01


def test_a_skewed_clock_is_another_set_of_stamps():
    run = observed(P, sine(15.0, 0.6), seed=7)
    skewed = simulate(vector({"clock_skew.s": -0.01}, P), run)
    np.testing.assert_allclose(skewed, simulate(P, replace(run, time_s=run.time_s * 0.99)), atol=1e-12)


@pytest.mark.parametrize("latency", [0.0, 0.1, 0.25])
def test_a_late_sonar_beside_another_channel(latency):
    """Echo instants then no longer follow the stamps, and the speed is not late."""
    run = observed(P, sine(15.0, 0.6), {RANGE: 0.1, SPEED: 0.1})
    late = (run.kind == RANGE) & (run.time_s >= latency)
    keep = late | (run.kind == SPEED)
    value = run.value.copy()
    dense = observed(P, sine(15.0, 0.6), {RANGE: 0.01})
    true = {round(t, 6): v for t, v in zip(dense.time_s, dense.value, strict=True)}
    value[late] = [true[round(t - latency, 6)] for t in run.time_s[late]]
    recorded = replace(run, time_s=run.time_s[keep], value=value[keep], kind=run.kind[keep])
    assert np.abs(simulate(vector({"sonar_latency.d": latency}, P), recorded)).max() < 2e-6


def test_tachometer_faults_are_taken_off_the_input():
    run = observed(P, sine(15.0, 0.6))
    bias = replace(run, input=run.input + 0.4)
    assert np.abs(simulate(vector({"tachometer_bias.b": 0.4}, P), bias)).max() < 1e-6
    spiked, lone = run.input.copy(), np.zeros(run.input.size)
    spiked[50::97], lone[50::97] = spiked[50::97] + 6.0, 5.5
    repaired = simulate(vector({"tachometer_spikes.size": 6.0}, P), replace(run, input=spiked, lone=lone))
    raw = simulate(P, replace(run, input=spiked))
    assert np.abs(repaired).max() < 1e-6 and np.abs(raw).max() > 0.02


def test_absorbed_effects_are_absorbed():
    """A stretched range is another drag and thrust; an offset is another starting place."""
    s, o = 0.03, 0.2
    run = observed(P, sine(15.0, 0.6), seed=7)
    stretched = vector({"sonar_scale.s": s}, P)
    other = vector({"alpha": PLAIN["alpha"] / (1 + s), "beta": PLAIN["beta"] * (1 + s)}, P)
    start = np.array([-s * 3.048, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(simulate(stretched, run), simulate(other, run, start), atol=1e-12)
    moved = simulate(P, run, np.array([-o, 0.0, 0.0, 0.0]))
    np.testing.assert_allclose(simulate(vector({"sonar_offset.o": o}, P), run), moved, atol=1e-12)


@pytest.mark.parametrize("name", ["sonar_latency.d", "command_delay.d", "clock_skew.s"])
def test_derivatives_are_right_where_an_instant_leaves_its_tick(name):
    run = observed(P, sine(15.0, 0.6))
    problem = Problem((run,), P, (name,))
    theta = problem.initial()
    filtered = problem.filter(theta)
    residual = problem.residuals(theta, filtered)
    fine = problem.jacobian(theta, filtered)[:, 0]
    moved = theta.copy()
    moved[0] += 1e-5
    coarse = (problem.residuals(moved, filtered) - residual) / 1e-5
    np.testing.assert_allclose(fine, coarse, atol=2e-3 * np.abs(coarse).max())


def test_a_reading_of_derivatives_that_does_not_say_so_does_not_compile() -> None:
    """It would read the state itself, without a word."""
    felt, state = Channel("surge_m_s2", "m/s2", term(lambda t, s, ds, p: ds[1])), (0.0, 0.2, 0.05, 0.0, 0.0)
    asked = (0, 0.0, state, (0.0,), 0.0, vector({"thrust_lag.tau": 0.7}))
    with pytest.raises(NumbaError, match="getitem"):
        readers(SURGE, [felt])["read"](*asked)
    said = replace(felt, of_rates=True)
    assert readers(SURGE, [said])["read"](*asked) == pytest.approx(0.05, abs=1e-12)  # without drag, thrust alone
