"""Long recordings are thinned so that the vehicle feels the same thrust, and short ones are left alone."""

from __future__ import annotations

import numpy as np
from synthetic import observed, sine

from vtank.diagnose.thinning import MOST_SAMPLES, thin, thinned
from vtank.estimate.innovations import Noise, innovations, no_gain
from vtank.estimate.observed import RANGE
from vtank.plant.parameters import vector

P = vector({"alpha": -2.5, "beta": 5e-4, "thrust_lag.tau": 0.7})


def fast_run():
    """A minute at 50 Hz with a propeller that hunts from tick to tick."""
    wave = sine(12.0, 0.5)
    return observed(P, lambda t: wave(t) + 3.0 * np.sign(np.sin(97.0 * t)), {RANGE: 0.02}, every_s=0.02)


def test_a_thinned_run_is_simulated_alike():
    """Held inputs are averaged in n|n|: what is left is the average's place within the step."""
    run = fast_run()
    slow = thin(run, 0.15, held=True)
    assert slow.time_s.size < run.time_s.size / 7
    error = innovations(slow, P, np.zeros(4), Noise(), no_gain(slow))
    assert np.abs(error).max() < 3e-4  # 5 % of 6 mm
    crooked = thin(run, 0.15)  # straight between samples, half a tick early
    worse = innovations(crooked, P, np.zeros(4), Noise(), no_gain(crooked))
    assert np.abs(worse).max() > 3.0 * np.abs(error).max()


def test_runs_that_are_short_enough_are_left_alone():
    run = fast_run()
    assert run.time_s.size < MOST_SAMPLES
    assert thinned([run], held=True)[0] is run


def test_many_samples_become_as_many_as_there_is_time_for():
    run = fast_run()
    runs = thinned([run] * 8, held=True)
    assert sum(r.time_s.size for r in runs) <= 1.01 * MOST_SAMPLES
