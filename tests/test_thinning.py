"""Long recordings are thinned so that the vehicle feels the same thrust, and short ones are left alone."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import observed, sine

from vtank.diagnose.thinning import MOST_SAMPLES, straightened, thin, thinned
from vtank.estimate.innovations import Noise, innovations, no_gain
from vtank.estimate.observed import RANGE, Observed
from vtank.estimate.optimum import Prior, descend
from vtank.estimate.problem import Problem
from vtank.plant.parameters import vector

P = vector({"alpha": -2.5, "beta": 5e-4, "thrust_lag.tau": 0.7})


def fast_run():
    """A minute at 50 Hz with a propeller that hunts from tick to tick."""
    wave = sine(12.0, 0.5)
    return observed(P, lambda t: wave(t) + 3.0 * np.sign(np.sin(97.0 * t)), {RANGE: 0.02}, every_s=0.02)


def test_a_thinned_run_is_simulated_alike():
    """Two levels of n|n| have the impulse and its moment; an average alone is off by its place within the step."""
    run = fast_run()

    def error(slow):
        return np.abs(innovations(slow, P, np.zeros(4), Noise(), no_gain(slow))).max()

    slow = thin(run, 0.15)
    assert slow.time_s.size < run.time_s.size / 7
    assert error(slow) < 1e-5
    assert error(thin(run, 0.15, levels=1)) > 20.0 * error(slow)
    assert error(thin(straightened(run), 0.15)) > 20.0 * error(slow)  # straight between samples, half a tick early


def test_of_two_ticks_each_nothing_is_left_out():
    run = fast_run()
    slow = thin(run, 0.04)
    assert slow.time_s.size == run.time_s.size // 2
    whole = np.interp(slow.input_time_s, run.input_time_s, np.arange(run.input.size)).round().astype(int)
    np.testing.assert_allclose(slow.input, run.input[whole], atol=1e-9)
    assert np.abs(innovations(slow, P, np.zeros(4), Noise(), no_gain(slow))).max() < 1e-7


@pytest.mark.parametrize(("input_name", "every_s"), [("n_rev_s", 0.02), ("command", 0.05), ("thrust_N", 0.1)])
def test_the_impulse_of_a_held_input_is_exact_at_every_stamp_kept(input_name, every_s):
    """At any rate, on uneven stamps, whatever the period asked for; and how far it moves a free body, but for few."""
    rng = np.random.default_rng(5)
    time = np.cumsum(rng.uniform(0.7, 1.3, 400)) * every_s
    held = rng.normal(size=time.size)
    run = Observed("run", input_name, time, held, time, held, np.full(time.size, RANGE))
    slow, every = thin(run, 0.31), int(np.ceil(0.31 / np.median(np.diff(time))))
    assert slow.input.size <= 2 * np.ceil(time.size / every) and np.isin(slow.input_time_s, time).all()

    def impulse(run, end):
        thrust = run.input if input_name == "thrust_N" else run.input * np.abs(run.input)
        return np.cumsum(thrust[:end] * np.diff(run.input_time_s)[:end])

    edges = time[every::every]
    np.testing.assert_array_equal(slow.time_s[1:], edges)
    ours = impulse(slow, slow.input.size - 1)[np.isin(slow.input_time_s[1:], edges)]
    np.testing.assert_allclose(ours, impulse(run, time.size - 1)[np.isin(time[1:], edges)], atol=1e-12)


def test_thinning_a_null_invents_no_delay():
    """Two tones held at 10 Hz, thinned threefold: no delay is found, but half a tick if they are taken for straight."""
    run = observed(P, lambda t: 9.0 * np.cos(0.5 * t) + 6.0 * np.cos(1.7 * t + 1.0))
    found = []
    for slow in (thin(run, 0.3), thin(straightened(run), 0.3)):
        problem = Problem((slow,), P, ("alpha", "beta", "thrust_lag.tau", "command_delay.d"))
        prior = Prior(*(np.full(problem.size, value) for value in (0.0, np.inf, -np.inf, np.inf)))
        optimum = descend(problem, problem.initial(), prior, problem.filter(problem.initial()))
        found.append(optimum.theta[3])
    assert found[0] == pytest.approx(0.0, abs=3e-3) and found[1] == pytest.approx(0.05, abs=0.01)  # [s]


def test_runs_that_are_short_enough_are_left_alone():
    run = fast_run()
    assert run.time_s.size < MOST_SAMPLES
    assert thinned([run])[0] is run


def test_many_samples_become_as_many_as_there_is_time_for():
    run = fast_run()
    runs = thinned([run] * 8)
    assert sum(r.time_s.size for r in runs) <= 1.01 * MOST_SAMPLES
