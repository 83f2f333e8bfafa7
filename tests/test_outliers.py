"""Lone readings: which ranges are flagged, and that a hunting propeller is not mistaken for a spiking tachometer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from vtank.diagnose.lone_speeds import with_lone_speeds
from vtank.diagnose.outliers import long_ranges, multipath, none_seen, spike_sizes, spikes
from vtank.effects.sonar_multipath import EFFECT as MULTIPATH
from vtank.effects.tachometer_spikes import EFFECT as SPIKES
from vtank.estimate.observed import RANGE, Observed
from vtank.estimate.problem import Filtered

TIME = np.arange(1200) * 0.1
MOTION = 3.0 - 0.4 * np.sin(1.2 * TIME)  # up to 48 mm from ping to ping


def sonar(value, n=None):
    n = 10.0 * np.sin(0.5 * TIME) if n is None else n
    return Observed("run", "n_rev_s", TIME, n, TIME, value, np.full(TIME.size, RANGE))


@pytest.mark.parametrize("memory_s", [0.0, 0.3, 1.5])
@pytest.mark.parametrize("resolution", [0.0, 0.002, 0.01])
def test_noise_and_motion_alone_raise_no_flag(memory_s, resolution):
    rng = np.random.default_rng(5)
    keep = np.exp(-0.1 / memory_s) if memory_s else 0.0
    noise = lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], 0.006 * rng.standard_normal(TIME.size))
    value = MOTION + noise
    if resolution:
        value = np.round(value / resolution) * resolution
    assert not np.any(long_ranges(sonar(value)))


@pytest.mark.parametrize("share", [0.005, 0.06])
@pytest.mark.parametrize("resolution", [0.001, 0.01])
def test_long_echoes_are_flagged_and_their_neighbours_are_not(share, resolution):
    rng = np.random.default_rng(6)
    late = rng.random(TIME.size) < share
    late[[0, -1]] = False  # the first and the last reading have neighbours on one side only
    value = MOTION + 0.004 * rng.standard_normal(TIME.size) + 0.3 * late
    flags = long_ranges(sonar(np.round(value / resolution) * resolution))
    assert np.mean(flags[late]) > 0.9
    assert np.sum(flags[~late]) <= 2


def test_outliers_on_the_short_side_are_no_multipath():
    error = np.zeros(1200)
    flags = np.zeros(1200, dtype=bool)
    flags[::100] = True
    for size, gains in ((0.3, True), (-0.3, False)):
        error[flags] = size
        gain, share, extra = multipath(MULTIPATH, [Filtered(error, np.full(1200, 1e-4), np.zeros((1200, 6)))], [flags])
        if gains:
            assert gain > 10.0 and share == pytest.approx(0.01, rel=0.01) and extra == pytest.approx(size)
        else:
            assert (gain, share) == (none_seen(1200), 0.0)


def test_late_pings_within_the_noise_are_told_by_their_number():
    rng = np.random.default_rng(8)
    late = rng.random(4800) < 0.05
    good = 0.01 * rng.standard_normal(4800)
    none = np.zeros(4800, dtype=bool)

    def found(error):
        return multipath(MULTIPATH, [Filtered(error, np.full(4800, 1e-4), np.zeros((4800, 6)))], [none])

    gain, share, extra = found(good + 0.04 * late)
    assert gain > 100.0
    assert share == pytest.approx(np.mean(late), rel=0.1) and extra == pytest.approx(0.04, rel=0.05)
    assert found(good) == (none_seen(4800), 0.0, 0.0)
    assert found(good - 0.04 * late) == (none_seen(4800), 0.0, 0.0)


def test_readings_that_jump_are_no_evidence_of_spikes_by_themselves():
    jumps = 4.0 * (np.random.default_rng(7).random(TIME.size) < 0.03)
    run = with_lone_speeds([sonar(MOTION, 10.0 * np.sin(0.5 * TIME) + jumps)])[0]
    gain, share = spikes(SPIKES, np.array([0.0, 4.0]), [run])
    assert gain < 0.0 and 0.01 < share < 0.05
    assert spike_sizes([run]) == pytest.approx([4.0] * 3, rel=0.1)
