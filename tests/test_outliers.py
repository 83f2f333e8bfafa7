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
    """Many hide each other, and the first and the last have neighbours on one side only."""
    rng = np.random.default_rng(6)
    late = rng.random(TIME.size) < share
    late[[0, -1]] = True
    value = MOTION + 0.004 * rng.standard_normal(TIME.size) + 0.3 * late
    flags = long_ranges(sonar(np.round(value / resolution) * resolution))
    assert np.mean(flags[late]) > 0.98
    assert np.sum(flags[~late]) <= 2


def switching(random, size):
    """Standard normal, and three times as wide in stretches of 40 samples."""
    return random.standard_normal(size) * np.where(np.repeat(random.random(size // 40) < 0.3, 40), 3.0, 1.0)


HEAVY = {
    "t3": lambda random, size: random.standard_t(3.0, size),
    "laplace": lambda random, size: random.laplace(size=size),
    "sech": lambda random, size: np.log(np.tan(0.5 * np.pi * random.random(size))),
    "contaminated": lambda random, size: random.standard_normal(size) * np.where(random.random(size) < 0.04, 6.0, 1.0),
    "cauchy": lambda random, size: random.standard_cauchy(size).clip(-300.0, 300.0),
    "switching": switching,
    "coarse": lambda random, size: np.round(random.standard_normal(size)),
}


@pytest.mark.parametrize("family", HEAVY)
def test_heavy_tails_are_no_multipath_and_hide_none(family):
    """Symmetric noise gains nothing; with late pings among it, of three of its own widths, multipath does."""
    random = np.random.default_rng(11)
    for _ in range(5):
        error = 0.006 * HEAVY[family](random, 4800)
        assert multipath(MULTIPATH, error)[0] < 0.0
    late = random.random(4800) < 0.05
    gain, share, extra = multipath(MULTIPATH, error + 0.1 * late)
    assert gain > 20.0 and share == pytest.approx(0.05, rel=0.3) and extra == pytest.approx(0.1, rel=0.15)


UNEVEN = {  # noise with one peak and a longer side, of deviation one or so
    "gumbel": lambda random, size: random.gumbel(size=size),
    "gamma": lambda random, size: random.gamma(3.0, size=size),
    "lognormal": lambda random, size: 2.0 * random.lognormal(0.0, 0.5, size=size),
    "exponential and normal": lambda random, size: random.exponential(size=size) + random.standard_normal(size),
    "bounded": lambda random, size: 6.0 * random.beta(2.0, 5.0, size=size),
}


@pytest.mark.parametrize("family", UNEVEN)
@pytest.mark.parametrize("size", [600, 4800])
def test_noise_that_leans_to_one_side_is_no_multipath_and_hides_none(family, size):
    """It falls away on both sides; echoes by a path of their own are a second peak, and gain."""
    random = np.random.default_rng(21)
    for _ in range(5):
        error = UNEVEN[family](random, size)
        error = 0.006 * (error - np.median(error))
        assert multipath(MULTIPATH, error)[0] < 0.0
    late = random.random(size) < 0.05
    gain, share, extra = multipath(MULTIPATH, error + 0.1 * late)
    assert gain > 3.0 and share == pytest.approx(0.05, rel=0.5) and extra == pytest.approx(0.1, rel=0.15)


def test_outliers_are_multipath_only_where_they_are_late():
    random = np.random.default_rng(12)
    noise, lone = 0.006 * random.standard_normal(2400), np.arange(2400) % 80 == 40
    fair = np.where(np.arange(2400) % 160 == 40, 1.0, -1.0)
    gain, share, extra = multipath(MULTIPATH, noise + 0.3 * lone)
    assert gain > 15.0 and share == pytest.approx(1 / 80, rel=0.01) and extra == pytest.approx(0.3, rel=0.01)
    for error in (-0.3 * lone, 0.3 * fair * lone, 0.6 * random.standard_normal(2400) * lone):
        assert multipath(MULTIPATH, noise + error)[0] < 0.0


def test_pauses_in_a_bent_motion_raise_no_flag():
    """Far from the wall, no echo for seconds; the neighbours beyond a pause say little of where a reading should be."""
    random = np.random.default_rng(13)
    for _ in range(5):
        value = MOTION + 0.006 * random.standard_normal(TIME.size)
        run = sonar(value)
        seen = (value < 3.2) | (random.random(TIME.size) < 0.1)
        run = Observed("run", "n_rev_s", TIME, run.input, TIME[seen], value[seen], run.kind[seen])
        assert not np.any(long_ranges(run))


def test_late_pings_within_the_noise_are_told_by_their_number():
    rng = np.random.default_rng(8)
    late = rng.random(4800) < 0.05
    good = 0.01 * rng.standard_normal(4800)
    gain, share, extra = multipath(MULTIPATH, good + 0.04 * late)
    assert gain > 10.0  # over noise that leans to one side, which nearly explains them; over even noise alone 50
    assert share == pytest.approx(np.mean(late), rel=0.1) and extra == pytest.approx(0.04, rel=0.05)
    assert multipath(MULTIPATH, good) == (none_seen(4800), 0.0, 0.0)
    assert multipath(MULTIPATH, good - 0.04 * late) == (none_seen(4800), 0.0, 0.0)


def test_readings_that_jump_are_no_evidence_of_spikes_by_themselves():
    jumps = 4.0 * (np.random.default_rng(7).random(TIME.size) < 0.03)
    run = with_lone_speeds([sonar(MOTION, 10.0 * np.sin(0.5 * TIME) + jumps)])[0]
    gain, share = spikes(SPIKES, np.array([0.0, 4.0]), [run])
    assert gain < 0.0 and 0.01 < share < 0.05
    assert spike_sizes([run]) == pytest.approx([4.0] * 3, rel=0.1)
