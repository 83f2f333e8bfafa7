"""Readings that a logger wrote again are no readings."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import vtank as vt
from vtank.estimate.observed import stretches
from vtank.record.manifest import DataSetWarning
from vtank.record.repeats import own_readings, smallest_step


def speeds(size: int, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.sin(0.1 * np.arange(size)) + 0.01 * rng.normal(size=size)


@pytest.mark.parametrize(("rows_hz", "reads_hz"), [(20.0, 5.0), (10.0, 7.0), (50.0, 1.0), (10.0, 4.0)])
def test_a_slow_instrument_in_fast_rows_is_read_as_often_as_it_read(rows_hz: float, reads_hz: float) -> None:
    row_s = np.arange(0.0, 200.0, 1.0 / rows_hz)
    reading = np.floor(row_s * reads_hz + 1e-9).astype(int)
    own = own_readings(speeds(reading.max() + 1)[reading])
    np.testing.assert_array_equal(own, np.diff(reading, prepend=-1) > 0)


def resting() -> np.ndarray:
    return np.concatenate([np.zeros(400), speeds(600)])


def stuck() -> np.ndarray:
    return np.concatenate([speeds(300), np.full(300, 0.2), speeds(400, 2)])


def coarse() -> np.ndarray:
    return np.round(speeds(1000), 1)


@pytest.mark.parametrize("made", [speeds, resting, stuck, coarse, np.zeros, np.arange])
def test_what_rests_is_stuck_or_coarse_was_read(made) -> None:
    values = np.asarray(made(1000) if made in (speeds, np.zeros, np.arange) else made(), dtype=float)
    assert own_readings(values).all()


@pytest.mark.parametrize("size", [0, 1, 2])
def test_few_values_are_their_own(size: int) -> None:
    assert own_readings(np.zeros(size)).tolist() == [True] * size


def test_the_smallest_step_is_no_dust_of_binary_fractions() -> None:
    assert smallest_step(np.array([0.1 + 0.2, 0.3, 0.7, 0.4])) == pytest.approx(0.1)


def test_runs_are_taken_in_without_what_was_written_again() -> None:
    """And it is said how much that was; inputs are held, and told columns that repeat nothing stay as they are."""
    time_s = np.arange(0.0, 60.0, 0.05)
    held = speeds(time_s.size)[::4].repeat(4)[: time_s.size]
    columns = {
        "n_rev_s": np.repeat([5.0, 7.0], time_s.size // 2),
        "surge_m_s": held,
        "range_m": 9.0 - speeds(time_s.size),
    }
    with pytest.warns(DataSetWarning, match="run one: readings written again by the logger are left out: 75% of surge"):
        (run,) = stretches([vt.Run("one", time_s, columns)])
    assert run.samples("surge_m_s")[0].tolist() == pytest.approx(time_s[::4].tolist())
    for name in ("n_rev_s", "range_m"):
        np.testing.assert_array_equal(run.columns[name], columns[name])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stretches([run])
