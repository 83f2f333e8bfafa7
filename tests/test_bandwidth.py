"""Frequency response: the linear loop exactly, describing functions against their closed forms, harmonic balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vtank.errors import InputError
from vtank.experiment import plan_run, simulate_surge
from vtank.experiment.scenario import Scenario, load_scenario
from vtank.plant.truth import Truth, load_truth
from vtank.studies.bandwidth.balance import balance
from vtank.studies.bandwidth.loop import Loop
from vtank.studies.bandwidth.response import Response, crossing, harmonics, measured_s, sine_plan, sweep, unwrapped

QUIET = ("sonar.noise_m=0", "sonar.resolution_m=0", "sonar.width_deg=0", "tachometer.noise_rev_s=0", "hold=rigid")
LINEAR = (*QUIET, "control.blunt_rev_s=0", "n_limit_rev_s=1e6")
W = np.array([0.15, 0.5, 1.2])


def scenario(*settings: str) -> Scenario:
    return load_scenario("paper-ds1", settings)


def truth(**parameters: float) -> Truth:
    return replace(load_truth("paper-ii"), **parameters)


@pytest.mark.parametrize("tau", [0.7074, 0.0])
def test_without_drag_and_limit_the_tank_is_the_linear_model(tau: float) -> None:
    """Square-root control of a square-law thrust is linear; the model is exact at the ticks."""
    easy = truth(alpha_per_m=0.0, tau_s=tau)
    measured = sweep(scenario(*LINEAR), (0.1,), W, easy)
    linear = Loop(plan_run(scenario(*LINEAR), truth=easy)).response(W)
    np.testing.assert_allclose(measured.response[0], linear, rtol=0, atol=1e-6)
    assert not measured.at_limit.any() and (measured.distortion < 1e-6).all() and (measured.unrest < 1e-6).all()


def test_linear_drag_is_in_the_linear_model() -> None:
    easy, drag = truth(alpha_per_m=0.0), "effects.linear_drag.c_per_s=0.4"
    measured = sweep(scenario(*LINEAR, drag), (0.1,), W[1:2], easy)
    linear = Loop(plan_run(scenario(*LINEAR, drag), truth=easy)).response(W[1:2])
    np.testing.assert_allclose(measured.response[0], linear, rtol=0, atol=1e-6)


def test_the_linear_model_tends_to_the_continuous_loop_with_a_short_tick() -> None:
    """x/r = (k + d s)/(s^2 + d s + k) with perfect sensing, unit beta ratio and no lag."""
    quick = scenario(*LINEAR, "period_s=0.01", "filter.q_ft2_per_s5=1e9", "control.thrust_m_per_rev2=1e-3")
    loop = Loop(plan_run(quick, truth=truth(tau_s=0.0, beta_m_per_rev2=1e-3)))
    s, control = 1j * W, quick.control
    k, d = control.position_per_s2, control.speed_per_s
    np.testing.assert_allclose(loop.response(W), (k + d * s) / (s * s + d * s + k), rtol=0.01)
    assert np.abs(loop.response(np.array([1e-3])) - 1.0) < 1e-4


def test_stability_is_that_of_the_continuous_loop() -> None:
    """With perfect sensing tau s^3 + s^2 + b d s + b k is stable while d > k tau (Routh and Hurwitz)."""
    for tau, stable in ((2.4, True), (2.6, False)):
        quick = scenario(*LINEAR, "period_s=0.01", "filter.q_ft2_per_s5=1e9", "control.thrust_m_per_rev2=1e-3")
        assert Loop(plan_run(quick, truth=truth(tau_s=tau, beta_m_per_rev2=1e-3))).stable() == stable
    assert Loop(plan_run(scenario())).stable()


def test_the_filters_transfer_is_what_the_filter_does() -> None:
    plan = plan_run(scenario(*QUIET))
    result = simulate_surge([sine_plan(scenario(*QUIET), 0.1, 0.5)])[0]
    assert result.run.time_s[-1] > 60.0
    position, rate = Loop(plan).estimate(np.array([0.05, 0.5]))
    assert np.abs(position[0] - 1.0) < 1e-3 and rate[0] == pytest.approx(0.05j, rel=1e-3)
    assert abs(rate[1]) / 0.5 == pytest.approx(1.042, abs=0.003)  # phoenix.md's table for q = 1 ft2/s5: 1.042, -0.5 deg
    assert np.degrees(np.angle(rate[1] / 1j)) == pytest.approx(-0.5, abs=0.1)


@pytest.mark.parametrize(("name", "close"), [("paper-ii", 0.03), ("physical", 0.03), ("paper-iii", 0.1)])
def test_harmonic_balance_meets_the_tank(name: str, close: float) -> None:
    """Both know drag, thrust loss, lag, blunting and limit; what is left are the higher harmonics.

    They count for more with paper-iii, whose linear loop is unstable: the limit alone keeps it within bounds.
    """
    quiet = scenario(*QUIET)
    measured = sweep(quiet, (0.1, 0.4), W, name)
    for i, amplitude in enumerate(measured.amplitude_m):
        balanced, share = balance(plan_run(quiet, truth=name), float(amplitude), W)
        np.testing.assert_allclose(measured.response[i], balanced, rtol=close)
        np.testing.assert_allclose(measured.at_limit[i], share, atol=0.06)
    assert measured.at_limit[1, 2] > 0.3


def test_balance_of_a_small_linear_motion_is_the_linear_model() -> None:
    plan = plan_run(scenario(*LINEAR), truth=truth(alpha_per_m=0.0))
    balanced, share = balance(plan, 0.1, W)
    np.testing.assert_allclose(balanced, Loop(plan).response(W), rtol=2e-3)  # the hold between ticks is a mere delay
    assert not share.any()


def test_drag_of_a_sinusoid_is_eight_over_three_pi() -> None:
    """With linear control the balance is (w^2 + i w (8/3 pi)|alpha| U) x + beta-ratio x demand = 0, U = w|x|."""
    plan = plan_run(scenario(*LINEAR, "period_s=0.01"), truth=truth(tau_s=0.0))
    amplitude, w = 0.4, 0.5
    (response,), _ = balance(plan, amplitude, np.array([w]))
    command, feedback = (part[0] for part in Loop(plan).controller(np.array([w])))
    ratio = plan.truth.beta_m_per_rev2 / plan.thrust_m_per_rev2
    hold = (1.0 - np.exp(-0.01j * w)) / (0.01j * w)
    drag = 8.0 / (3.0 * np.pi) * -plan.truth.alpha_per_m * w * abs(response) * amplitude
    left = (-(w**2) + 1j * w * drag) * response - hold * ratio * (command + feedback * response)
    assert abs(left) < 1e-4 * w**2


def test_the_full_limit_leaves_four_over_pi_of_it() -> None:
    """A command that saturates the propellers throughout: thrust is a square wave of 4/pi times its height."""
    plan = plan_run(scenario(*QUIET, "n_limit_rev_s=1"), truth=truth(alpha_per_m=0.0, tau_s=0.0))
    (response,), (share,) = balance(plan, 0.6, np.array([2.0]))
    assert share > 0.98
    square = 4.0 / np.pi * plan.truth.beta_m_per_rev2
    assert abs(response) * 0.6 * 4.0 == pytest.approx(square, rel=2e-3)


@pytest.mark.slow
def test_a_stronger_command_is_followed_less_far_and_meets_the_limit_sooner() -> None:
    measured = sweep(scenario(), (0.1, 0.4), np.array([0.3, 0.6, 0.9, 1.2, 1.6]))
    weak, strong = measured.bandwidth_rad_s()
    assert 0.6 < strong < weak < 1.6
    weak_limit, strong_limit = measured.limit_rad_s()
    assert strong_limit < weak_limit
    assert (np.diff(measured.phase_rad) < 0.0).all()


def test_runs_into_a_wall_are_not_measured() -> None:
    measured = sweep(scenario(*LINEAR), (0.65,), np.array([0.9]), truth(alpha_per_m=0.0))
    assert np.isnan(measured.response).all() and np.isnan(measured.bandwidth_rad_s()).all()


def test_a_command_that_would_hit_a_wall_is_refused() -> None:
    with pytest.raises(InputError, match="paper-ds1.toml.*wall astern"):
        sweep(scenario(), (0.9,), W)


def test_harmonics_of_a_known_signal_at_any_sampling() -> None:
    t = np.arange(0.0, 40.0, 0.1)
    value = 0.3 + 2.0 * np.sin(0.7 * t + 0.4) - 0.5 * np.cos(1.4 * t)
    found = harmonics(t, value, 0.7)
    np.testing.assert_allclose(found, [2.0 * np.exp(0.4j), -0.5j, 0.0], atol=1e-12)


def test_measured_time_is_whole_cycles() -> None:
    for w in (0.05, 0.3, 2.0):
        cycles = measured_s(w) * w / (2.0 * np.pi)
        assert cycles == pytest.approx(round(cycles)) and cycles >= 2 and measured_s(w) >= 60.0


def test_crossings_are_found_between_the_points() -> None:
    w = np.array([0.1, 1.0, 10.0])
    assert crossing(w, np.array([1.0, 1.0, 0.0]), 0.5, falling=True) == pytest.approx(10.0**0.5)
    assert crossing(w, np.array([0.0, np.nan, 1.0]), 0.5, falling=False) == pytest.approx(1.0)
    assert crossing(w, np.array([0.1, 0.2, 0.3]), 0.5, falling=True) == pytest.approx(0.1)
    assert np.isnan(crossing(w, np.array([0.1, 0.2, 0.3]), 0.5, falling=False))


def test_phase_is_continuous_and_leaves_gaps_alone() -> None:
    turning = np.exp(-1j * np.array([[0.0, 2.0, np.nan, 4.0, 6.0]]))
    np.testing.assert_allclose(unwrapped(turning), [[0.0, -2.0, np.nan, -4.0, -6.0]])


def test_a_response_does_not_depend_on_company_or_threads() -> None:
    few = sweep(scenario(), (0.2,), W[2:])
    many = sweep(scenario(*()), (0.2, 0.3), W[2:], nthread=2)
    assert isinstance(few, Response)
    assert few.response[0, 0] == many.response[0, 0]
