"""Short events are found where readings lean together, and not where noise has tails, colour or lone outliers."""

from __future__ import annotations

import numpy as np
import pytest

from vtank.diagnose.freeform.events import events

TIME = np.arange(2000) / 10.0
LONGEST_S = 3.0
CLEAR = 7.0  # deviations that leave something over once 2e4 stretches have been looked through


def noise(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=TIME.size)


def test_a_stall_is_found_where_it_is() -> None:
    off = noise(1)
    off[700:709] += np.linspace(0.5, 8.0, 9)
    found = events(TIME, off, LONGEST_S)
    assert abs(found.lean[0]) > CLEAR
    start, end = found.spans[0]
    assert 69.9 <= start <= 70.4 and 70.5 <= end <= 71.0
    np.testing.assert_array_equal(found.functions(TIME)[:, 0] > 0.0, (start <= TIME) & (end >= TIME))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kind", ["normal", "t2", "two widths", "coloured", "coarse", "lone"])
def test_what_is_no_event_does_not_lean(kind: str, seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    off = noise(seed)
    if kind == "t2":
        off = rng.standard_t(2.0, TIME.size)
    if kind == "two widths":
        off *= np.where(rng.random(TIME.size) < 0.04, 6.0, 1.0)
    if kind == "coloured":
        off = np.convolve(off, np.exp(-np.arange(30) / 5.0))[: TIME.size]
    if kind == "coarse":
        off = np.round(np.sin(0.2 * TIME) * 20.0) - np.sin(0.2 * TIME) * 20.0
    if kind == "lone":
        off[rng.integers(TIME.size, size=20)] += 30.0
    assert np.all(np.abs(events(TIME, off, LONGEST_S).lean) < CLEAR)


def test_readings_that_do_not_count_are_passed_over() -> None:
    off = noise(2)
    off[300:312] += 6.0
    off[304:308] = np.nan
    found = events(TIME, off, LONGEST_S)
    assert abs(found.lean[0]) > CLEAR and found.spans[0][0] < 30.4 < 30.8 < found.spans[0][1]


def test_stretches_do_not_overlap_and_last_no_longer_than_asked() -> None:
    found = events(TIME, noise(3), 1.0)
    assert np.all(found.functions(TIME).sum(axis=1) <= 1.0)
    assert all(end - start <= 1.0 for start, end in found.spans)
    assert found.looked > TIME.size


def test_a_handful_of_readings_has_no_events() -> None:
    assert events(TIME[:8], noise(4)[:8], LONGEST_S).spans == ()
