"""The motion over which what has no name is sought: a controller's answers must not tell it the errors of readings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from recorded import NOMINAL, STANDOFF_M
from synthetic import advance

from vtank.diagnose.evidence import evaluate
from vtank.diagnose.freeform.dictionary import SENSOR
from vtank.diagnose.freeform.motion import motions
from vtank.diagnose.freeform.pursuit import WORTHWHILE, _Pursuit
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.selection import prepare
from vtank.diagnose.thinning import CLOSED, thin, thinned
from vtank.estimate.observed import RANGE, Observed
from vtank.estimate.problem import Noise

TICK_S = 0.02
WHITE_M, COLOUR_M, COLOUR_S = 0.001, 0.004, 0.7
NOISE = Noise((WHITE_M**2,) * 3, 0.0, 1.0, COLOUR_M, COLOUR_S)


def held_by_its_sonar(seed: int) -> Observed:
    """A vehicle that follows a slow sine by its sonar, whose error lasts a while; it answers every reading at once."""
    rng, keep = np.random.default_rng(seed), np.exp(-TICK_S / COLOUR_S)
    time = TICK_S * np.arange(2000)
    x = u = z = wake = 0.0
    slow, asked, reading = COLOUR_M * rng.normal(), np.empty(time.size), np.empty(time.size)
    for k, t in enumerate(time):
        reading[k] = STANDOFF_M - x + slow + WHITE_M * rng.normal()
        there = STANDOFF_M - reading[k] - 0.1 * np.sin(0.3 * t)
        asked[k] = np.clip(-120.0 * there - 40.0 * u, -14.0, 14.0)
        x, u, z, wake = advance(t, TICK_S, x, u, z, wake, asked[k], 0.0, NOMINAL)
        slow = keep * slow + COLOUR_M * np.sqrt(1.0 - keep**2) * rng.normal()
    return Observed("held", "n_rev_s", time, asked, time, reading, np.full(time.size, RANGE))


@pytest.mark.parametrize("every", [1, 2, 4])
def test_what_goes_with_an_error_is_older_than_the_answer_to_any_reading_left_out(every: int) -> None:
    run = thin(held_by_its_sonar(1), every * TICK_S)
    assert run.thinned == (every > 1)
    ((_, read),) = motions(evaluate(prepare([run], NOMINAL).with_noise(NOISE), Hypothesis()))
    assert read.past == (2 if every > 1 else 1)
    answered = run.time_s[np.maximum(np.arange(run.time_s.size) - read.past + 1, 0)]  # by no input before it
    held = [np.flatnonzero(run.input_time_s < t) for t in answered]
    assert np.array_equal(read.n, [run.input[before[-1] if before.size else 0] for before in held])
    step = np.diff(read.u) / np.diff(run.time_s)
    assert np.array_equal(read.variables["acceleration"][read.past :], step[: step.size + 1 - read.past])


@pytest.mark.parametrize("every", [1, 2, 4])
def test_answers_to_readings_that_were_left_out_are_no_cause(every: int) -> None:
    runs = [thin(held_by_its_sonar(seed), every * TICK_S) for seed in range(4)]
    fit = evaluate(prepare(runs, NOMINAL).with_noise(NOISE), Hypothesis())
    free = _Pursuit(fit, None).followed(wandering=False, channels=(SENSOR,))
    assert free.gain < WORTHWHILE


def test_readings_that_a_controller_answers_are_left_out_only_where_there_are_far_too_many() -> None:
    held, free = held_by_its_sonar(1), replace(held_by_its_sonar(1), input=held_by_its_sonar(2).input)
    many = held.time_s.size
    assert thinned([held], many // 2)[0] is held
    assert not thinned([held], many // (2 * CLOSED))[0].time_s.size > many // 2 + 1
    assert thinned([free], many // 2)[0].time_s.size == pytest.approx(many / 2, abs=1)
