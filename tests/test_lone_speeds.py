"""Lone readings of the propeller: spikes are found though the propeller hunts, and hunting is no spike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vtank.diagnose.lone_speeds import lone_speeds
from vtank.effects.tachometer_spikes import SEEN
from vtank.estimate.observed import RANGE, Observed

TICK_S, TICKS = 0.1, 1200
TIME = TICK_S * np.arange(TICKS)
SIZE = 3.0  # rev/s


def hunting(seed, blunt=3.0, missed=0.0, limit=np.inf, step=False, tachometer=0.03):
    """A hull under a controller that is not the tank's: alpha-beta filter, then error and speed, then a square root.

    Returns the true propeller speed [rev/s] and the run with a noisy tachometer.
    """
    rng = np.random.default_rng(seed)
    x = u = guess = rate = 0.0
    n, heard, keep = np.empty(TICKS), np.empty(TICKS), rng.random(TICKS) >= missed
    keep[:10] = True
    for k, t in enumerate(TIME):
        heard[k] = 3.0 - x + 0.008 * rng.normal()
        guess += TICK_S * rate
        if k == 0:
            guess = heard[0]
        elif keep[k]:
            error = heard[k] - guess
            guess, rate = guess + 0.45 * error, rate + 0.14 * error / TICK_S
        place = 0.3 * np.sign(np.sin(0.2 * t)) if step else 0.3 * np.sin(0.4 * t)
        c = (0.5 * (guess - 3.0 + place) + 1.2 * rate) / 5e-4
        n[k] = np.clip(c / np.sqrt(abs(c) + blunt**2), -limit, limit)
        u += TICK_S * (5e-4 * n[k] * abs(n[k]) - 2.5 * u * abs(u))
        x += TICK_S * u
    read = n + tachometer * rng.normal(size=TICKS)
    return n, Observed("run", "n_rev_s", TIME, read, TIME[keep], heard[keep], np.full(int(keep.sum()), RANGE))


def spiked(run, seed, share=0.015):
    """The run with spikes, and their places, shape (I,)."""
    rng = np.random.default_rng(seed)
    sign = rng.choice([-1.0, 0.0, 1.0], TICKS, p=[share / 2, 1.0 - share, share / 2])
    sign[:3] = 0.0
    return replace(run, input=run.input + SIZE * sign), SIZE * sign


@pytest.mark.parametrize("blunt", [0.5, 3.0, 8.0])
def test_a_hunting_propeller_raises_no_flag(blunt):
    runs = [hunting(seed, blunt)[1] for seed in range(4)]
    jumps = np.median([np.median(np.abs(np.diff(run.input))) for run in runs])
    assert jumps > 0.5  # it truly hunts
    assert np.mean(np.concatenate(lone_speeds(runs)) != 0.0) < 0.002


@pytest.mark.parametrize(("blunt", "missed"), [(0.5, 0.0), (3.0, 0.0), (8.0, 0.0), (3.0, 0.05)])
def test_spikes_are_found_by_what_the_ranges_foretell(blunt, missed):
    pairs = [spiked(hunting(seed, blunt, missed)[1], 100 + seed) for seed in range(4)]
    lone = np.concatenate(lone_speeds([run for run, _ in pairs]))
    true = np.concatenate([spikes for _, spikes in pairs])
    hit = true != 0.0
    assert np.mean(lone[hit] != 0.0) > (0.7 if missed else 0.8)
    assert np.mean(lone[~hit] != 0.0) < 0.01 and np.sum(np.abs(lone[~hit]) > SEEN * SIZE) <= 2
    found = hit & (lone != 0.0)
    assert np.median(np.abs(lone[found] - true[found])) < 0.1 * SIZE


def test_steps_of_the_command_are_not_spikes():
    """In closed loop the seconds about a step may be flagged, since no range foretells it: the ranges then decide."""
    runs = [hunting(seed, step=True)[1] for seed in range(4)]
    place = TIME % (np.pi / 0.2)
    quiet = np.tile((place > 2.0) & (place < np.pi / 0.2 - 1.5), 4)
    assert np.mean(np.concatenate(lone_speeds(runs))[quiet] != 0.0) < 0.01
    square = 10.0 * np.sign(np.sin(0.5 * TIME)) + 0.03 * np.random.default_rng(3).normal(size=TICKS)
    open_loop = Observed("run", "n_rev_s", TIME, square, TIME, hunting(5)[1].value, np.full(TICKS, RANGE))
    assert not np.any(lone_speeds([open_loop])[0])


def test_open_loop_spikes_are_found_without_a_controller():
    smooth = 10.0 * np.sin(0.5 * TIME) + 0.05 * np.random.default_rng(3).normal(size=TICKS)
    run, true = spiked(Observed("run", "n_rev_s", TIME, smooth, TIME, hunting(5)[1].value, np.full(TICKS, RANGE)), 4)
    lone = lone_speeds([run])[0]
    np.testing.assert_array_equal(lone != 0.0, true != 0.0)
    np.testing.assert_allclose(lone[true != 0.0], true[true != 0.0], atol=0.4)


def test_three_spikes_in_a_row_are_three_and_a_command_of_three_ticks_that_goes_on_is_none():
    """The median of five is one of them; what lies between two readings at one level is seen all the same."""
    rng = np.random.default_rng(7)
    run = hunting(0)[1]
    steady = 9.0 * np.sign(np.sin(0.2 * TIME)) + 0.03 * rng.normal(size=TICKS)
    lone = np.zeros(TICKS)
    lone[[300, 500, 501, 502, 700]] = SIZE
    stairs = steady + np.where((TIME > 90.0) & (TIME < 90.35), 4.0, np.where(TIME >= 90.35, 8.0, 0.0))
    [found] = lone_speeds([replace(run, input=stairs + lone)])
    assert np.flatnonzero(np.abs(found) > SEEN * SIZE).tolist() == np.flatnonzero(lone).tolist()
    assert found[lone > 0.0] == pytest.approx(SIZE, abs=0.2)


@pytest.mark.parametrize("every", [25, 8])
def test_no_reading_beyond_the_limiter_is_believed(every):
    limit = 9.0
    n, run = hunting(1, limit=limit)
    assert np.mean(np.abs(n) == limit) > 0.05
    places = np.flatnonzero(n == limit)[10::every]
    read = run.input.copy()
    read[places] += SIZE
    lone = lone_speeds([Observed("run", "n_rev_s", TIME, read, TIME, run.value, run.kind)])[0]
    np.testing.assert_allclose(lone[places], SIZE, atol=0.3)


def test_runs_without_ranges_or_samples_are_taken_as_they_are():
    few = Observed("run", "n_rev_s", TIME[:5], np.ones(5), TIME[:5], np.zeros(5), np.full(5, RANGE))
    assert not np.any(lone_speeds([few])[0])
    speed = Observed("run", "command", TIME, np.sin(TIME), TIME, np.zeros(TICKS), np.full(TICKS, 2))
    assert not np.any(lone_speeds([speed])[0])
