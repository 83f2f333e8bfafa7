"""Intervals, calibration and names against hand-computed examples and brute force."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from vtank.studies.blind.calibration import corp, pav
from vtank.studies.blind.measures import NOTHING, first, quantile, share
from vtank.studies.blind.rows import canonical_name, chances_of
from vtank.studies.blind.seal import finite


def isotonic_by_force(stated: np.ndarray, happened: np.ndarray) -> np.ndarray:
    """Least squares over all ways to cut the sorted levels into blocks of non-decreasing means."""
    levels = np.unique(stated)
    best, found = math.inf, happened
    for cuts in itertools.product((False, True), repeat=levels.size - 1):
        block = np.concatenate([[0], np.cumsum(cuts)])[np.searchsorted(levels, stated)]
        means = np.array([happened[block == b].mean() for b in range(block.max() + 1)])
        cost = float(np.sum((means[block] - happened) ** 2))
        if np.all(np.diff(means) >= 0.0) and cost < best - 1e-12:
            best, found = cost, means[block]
    return found


@pytest.mark.parametrize("seed", range(12))
def test_pooling_finds_the_least_squares_monotone_fit(seed: int) -> None:
    random = np.random.default_rng(seed)
    stated = random.choice(np.linspace(0.1, 0.9, 7), 14)
    happened = (random.random(14) < stated).astype(float)
    assert pav(stated, happened) == pytest.approx(isotonic_by_force(stated, happened))


def test_corp_of_four_events_by_hand() -> None:
    # sorted by probability the outcomes are 0, 1, 0, 1: the two in the middle are pooled to 1/2
    found = corp(np.array([0.2, 0.4, 0.6, 0.8]), np.array([0.0, 1.0, 0.0, 1.0]))
    assert found.brier == pytest.approx((0.04 + 0.36 + 0.36 + 0.04) / 4)
    assert found.uncertainty == pytest.approx(0.25)
    assert found.miscalibration == pytest.approx(0.2 - 0.125)
    assert found.discrimination == pytest.approx(0.25 - 0.125)
    assert found.brier == pytest.approx(found.miscalibration - found.discrimination + found.uncertainty)


def test_miscalibration_tells_honest_from_boastful() -> None:
    random = np.random.default_rng(1)
    honest = random.uniform(0.3, 1.0, 3000)
    happened = (random.random(3000) < honest).astype(float)
    good, bad = corp(honest, happened), corp(honest**0.2, happened)
    assert good.miscalibration < 2.0 * good.expected < 0.02
    # the cost of stating p^(1/5) for p is the mean of (p^(1/5) - p)^2
    assert bad.miscalibration == pytest.approx(np.mean((honest**0.2 - honest) ** 2), abs=0.01)
    assert good.discrimination == pytest.approx(bad.discrimination)


def test_wilson_interval_of_eight_in_ten() -> None:
    found = share([True] * 8 + [False] * 2)
    assert (found.value, found.n) == (0.8, 10)
    assert (found.low, found.high) == pytest.approx((0.4902, 0.9433), abs=1e-4)
    assert share([True] * 5).high == 1.0
    assert share([]) is NOTHING


def test_the_interval_of_a_median_holds_it() -> None:
    random = np.random.default_rng(0)
    inside = 0
    for _ in range(300):
        m = quantile(random.normal(size=41).tolist(), 0.5)
        inside += m.low <= 0.0 <= m.high
    assert inside / 300 == pytest.approx(0.96, abs=0.03)


def test_ties_and_pairs_are_scored_under_one_name() -> None:
    assert first({"a": 0.5, "b": 0.3}) == "a"
    assert canonical_name("command_delay") == "sonar_latency"
    assert canonical_name("tether+command_delay") == canonical_name("sonar_latency+tether") == "sonar_latency+tether"
    assert chances_of({"command_delay": 1.0, "sonar_latency": 2.0, "none": 1.0, "tether": math.nan}) == {
        "sonar_latency": 0.75, "none": 0.25, "tether": 0.0}  # fmt: skip
    assert chances_of(["tether", "none"]) == {"tether": 1.0}


def test_a_truth_with_a_number_that_is_none_is_no_truth() -> None:
    assert finite({"held_out": {"refit": [0.1, 2]}}) and not finite({"held_out": {"refit": [0.1, float("nan")]}})
