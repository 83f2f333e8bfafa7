"""Random streams: reproducible, independent of each other and of the length drawn; turbulence by its correlation."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from vtank.experiment import noise

SIZE = 20_000


def test_a_stream_is_a_function_of_seed_run_and_source() -> None:
    drawn = {key: noise.normal(*key, 1.0, SIZE) for key in itertools.product((1, 2), (0, 7), range(noise.STREAMS))}
    for key, values in drawn.items():
        np.testing.assert_array_equal(values, noise.normal(*key, 1.0, SIZE))
    correlations = np.corrcoef(np.array(list(drawn.values()))) - np.eye(len(drawn))
    assert np.abs(correlations).max() < 5.0 / np.sqrt(SIZE)


def test_a_longer_draw_begins_like_a_shorter_one() -> None:
    for draw in (noise.normal, noise.uniform):
        np.testing.assert_array_equal(draw(5, 0, 1, 0.5, 1000)[:300], draw(5, 0, 1, 0.5, 300))
    long, short = (noise.turbulence(5, 0, 0.1, 2.0, 0.1, size) for size in (1000, 300))
    np.testing.assert_array_equal(long[:300], short)


def test_nothing_is_drawn_at_null_level() -> None:
    assert not noise.normal(1, 0, noise.SONAR, 0.0, 10).any()
    assert (noise.uniform(1, 0, noise.DROPOUT, 0.0, 10) == 1.0).all()
    assert not noise.turbulence(1, 0, 0.0, 1.0, 0.1, 10).any()


@pytest.mark.parametrize("time_s", [0.05, 0.5, 3.0])
def test_turbulence_has_its_deviation_and_correlation_from_the_first_tick(time_s: float) -> None:
    runs = np.array([noise.turbulence(3, run, 0.02, time_s, 0.1, 60) for run in range(4000)])
    tolerance = 5.0 / np.sqrt(len(runs))
    np.testing.assert_allclose(runs.std(axis=0), 0.02, rtol=tolerance)
    for lag in (1, 5, 20):
        correlation = np.mean(runs[:, 0] * runs[:, lag]) / 0.02**2
        assert correlation == pytest.approx(np.exp(-lag * 0.1 / time_s), abs=tolerance)
