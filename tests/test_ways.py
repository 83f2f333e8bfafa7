"""Which way a variable went last: play by its closed form, and what sticks is found by it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from recorded import recordings
from test_freeform import first

from vtank.diagnose.freeform.functions import PLAYS, dragged, ways_of

HALF, TOP = 0.2, 1.0


def triangle(count: int) -> np.ndarray:
    """From 0 up and down between both tops, in steps that are the same everywhere."""
    phase = np.linspace(0.0, 3.0, count)
    return TOP * (1.0 - np.abs((phase + 1.0) % 4.0 - 2.0))


def test_play_drags_behind_by_half_of_it_and_turns_round_after_all_of_it() -> None:
    t, values = np.linspace(0.0, 3.0, 3001), triangle(3001)
    out = dragged(values, HALF)
    assert np.all(np.abs(values - out) <= HALF + 1e-12)
    ahead = (t > HALF) & (t < 1.0)  # up to the first top
    assert out[ahead] == pytest.approx(values[ahead] - HALF, abs=1e-3)
    lost = (t > 1.0) & (t < 1.0 + 2.0 * HALF)  # play is taken up
    assert out[lost] == pytest.approx(TOP - HALF, abs=1e-3)
    back = (t > 1.0 + 2.0 * HALF) & (t < 3.0)
    assert out[back] == pytest.approx(values[back] + HALF, abs=1e-3)


def test_the_way_of_what_stands_still_stays() -> None:
    share = np.concatenate([np.linspace(0.2, 0.9, 50), np.full(50, 0.9), np.linspace(0.9, 0.1, 80), np.full(50, 0.1)])
    ways = ways_of(share)
    assert ways.shape == (share.size, 2 * len(PLAYS)) and np.abs(ways).max() <= 1.0 + 1e-12
    assert np.ptp(ways[60:100], axis=0).max() == 0.0 and np.ptp(ways[-40:], axis=0).max() == 0.0
    assert ways[70, 0] == pytest.approx(1.0) and ways[-1, 0] == pytest.approx(-1.0)


def test_a_sonar_on_a_slack_bracket_reads_by_which_way_it_went() -> None:
    slack_m = 0.012
    runs = recordings()
    runs = [replace(run, value=run.value + slack_m * way(run.value)) for run in runs]
    found = first(runs)
    assert (found.channel, found.about) == ("sensor", "place, which way it went")


def way(range_m: np.ndarray) -> np.ndarray:
    """-1 or 1 by which way a range went last, by more than its noise."""
    smooth = np.convolve(range_m, np.ones(9) / 9.0, mode="same")
    return np.asarray((smooth - dragged(smooth, 0.02)) / 0.02)
