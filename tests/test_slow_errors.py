"""Instruments that drift a little: their slow errors are noise, whatever a free form makes of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_rigid_motion import multisine

import vtank as vt
from vtank.experiment.whole import fly_vehicle
from vtank.rigid import noise_search as search
from vtank.rigid.filtered import filtered, followed, innovations
from vtank.rigid.fit import Fit
from vtank.rigid.noise import SURELY, against, first_noise
from vtank.rigid.noise_search import settle
from vtank.rigid.recordings import record
from vtank.rigid.slow import likelihoods
from vtank.rigid.tangent import tangents
from vtank.rigid.trials import tried

ROV = vt.load_vehicle("bluerov2")
FEW = replace(ROV, sensors=tuple(s for s in ROV.sensors if s.name in ("imu", "ahrs", "dvl", "depth")))
SLOW_S = 2.0


def drifting(run: vt.Run, sizes: dict[str, float], seed: int) -> vt.Run:
    """The run with Ornstein-Uhlenbeck errors of a deviation, by column."""
    rng, columns = np.random.default_rng(seed), dict(run.columns)
    for name, size in sizes.items():
        value = columns[name].copy()
        at = np.flatnonzero(~np.isnan(value))
        keep = np.exp(-np.diff(run.time_s[at], prepend=-np.inf) / SLOW_S)
        error = 0.0
        for i, k in zip(at, keep, strict=True):
            error = k * error + np.sqrt(1.0 - k * k) * size * rng.normal()
            value[i] += error
        columns[name] = value
    return replace(run, columns=columns)


def flown(seconds: float, seed: int, **sizes: float) -> vt.Run:
    """A flight in the tank, errors by column with __ for the point."""
    run = fly_vehicle(FEW, multisine(FEW, seconds, seed), seconds, seed)
    return drifting(run, {name.replace("__", "."): size for name, size in sizes.items()}, seed)


@pytest.fixture(scope="module")
def short():
    """A few seconds, noise without slow errors, and with those of two columns."""
    layout, (run,), _ = record([flown(4.0, 5)], FEW)
    white = first_noise([run])
    slow, slow_s = np.zeros(white.variance.size), np.ones(white.variance.size)
    for name, share, memory_s in (("imu.yaw_rate_rad_s", 1.5, 2.0), ("dvl.sway_m_s", 0.5, 0.7)):
        c = layout.columns.index(name)
        slow[c], slow_s[c] = share * np.sqrt(white.variance[c]), memory_s
    return run, layout.null, white, replace(white, slow=slow, slow_s=slow_s)


def test_the_filter_takes_slow_errors_for_what_they_are(short):
    """What they add to the covariance of all measurements is an Ornstein-Uhlenbeck process of their columns."""
    run, p, white, noise = short
    f = filtered(run, p, white)
    readings = -np.eye(run.time_s.size)
    tangents(f.way, run.steps, run.column, f.gains, np.zeros((run.steps.now.size, 6, readings.shape[0])), readings)
    undone = np.linalg.inv(readings)  # from innovations to what a simulation that follows nothing misses
    same = run.column[:, None] == run.column[None, :]
    apart = np.abs(run.time_s[:, None] - run.time_s[None, :])
    slow, slow_s = noise.slow[run.column], noise.slow_s[run.column]
    drift = np.where(same, slow**2 * np.exp(-apart / slow_s), 0.0)
    order = run.steps.which
    covariance = (undone * f.variance @ undone.T + drift)[np.ix_(order, order)]
    factor = np.linalg.cholesky(covariance)
    (left,) = tried(run, f, [noise])
    np.testing.assert_allclose(
        left.variance[order], np.diag(factor) ** 2, rtol=1e-5
    )  # a depth is hardly known at first
    z = np.linalg.solve(factor, (undone @ f.innovation)[order])
    np.testing.assert_allclose(left.white(left.innovation)[order], z, atol=1e-5)
    assert np.abs(left.white(left.innovation) - f.white(f.innovation)).max() > 0.1


@pytest.mark.parametrize(("memory_s", "sigma", "odd"), [(3.0, 1e-3, 1), (1.0, 1e-3, 0), (3.0, 1e-5, 0)])
def test_a_disturbance_that_lasts_as_long_as_a_run_costs_as_a_slow_error_does(short, memory_s, sigma, odd):
    """Over 4 s: what is remembered for 3 s of them stands for a steady force, unless it is none."""
    run, _, white, noise = short
    still = {"sigma": np.full(6, 1e-5), "memory_s": np.full(6, 3.0)}
    heaving = {"sigma": still["sigma"] + [0, 0, sigma - 1e-5, 0, 0, 0],
               "memory_s": still["memory_s"] + [0, 0, memory_s - 3.0, 0, 0, 0]}  # fmt: skip
    for level, slow in ((white.even, 0), (noise, 2)):
        assert against(Fit((run,), replace(level, **still))) == slow * SURELY
        assert against(Fit((run,), replace(level, **heaving))) == (slow + odd) * SURELY


def test_all_ways_along_a_run_have_the_same_slow_errors(short):
    """The filter, the filter made linear, the simulation at its gains, and the path at the same gains."""
    run, p, white, noise = short
    f = filtered(run, p, noise)
    np.testing.assert_allclose(innovations(run, p, f.gains), f.innovation, rtol=1e-9, atol=1e-12)
    way, e = followed(run, p, f)
    np.testing.assert_allclose(e, f.innovation, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(way.before, f.way.before, rtol=1e-9, atol=1e-12)


def test_filters_side_by_side_are_those_that_go_alone(short):
    """At several noises about one path: exact at the noise of the path, elsewhere but for what is not linear."""
    run, p, white, noise = short
    f = filtered(run, p, noise)
    faster = replace(noise, sigma=1.5 * noise.sigma, memory_s=0.7 * noise.memory_s, variance=1.2 * noise.variance)
    same, back, other = tried(run, f, [noise, white, faster])
    for part in same.told._fields:
        np.testing.assert_allclose(getattr(same.told, part), getattr(f.told, part), rtol=1e-6, atol=1e-9)
    for left, level in ((back, white), (other, faster)):
        alone = filtered(run, p, level)
        np.testing.assert_allclose(left.variance, alone.variance, rtol=5e-3)
        assert np.linalg.norm(left.z - alone.z) < 0.1 * np.linalg.norm(f.z - alone.z)


def test_a_slow_error_of_a_column_alone_is_as_likely_as_its_covariance_says():
    """Samples at odd times, against Cholesky's factor of the whole covariance."""
    rng = np.random.default_rng(1)
    time, variance, e = np.sort(rng.uniform(0.0, 20.0, 80)), rng.uniform(0.5, 1.5, 80), rng.normal(size=80)
    apart = np.abs(time[:, None] - time[None, :])
    factor = np.linalg.cholesky(np.diag(variance) + 0.49 * np.exp(-apart / 1.5))
    z, gain = np.linalg.solve(factor, e), np.empty(1)
    likelihoods(time, e, variance, np.arange(80) == 0, 0.0, np.array([0.7]), np.array([1.5]), gain)
    expected = -0.5 * (z @ z - np.sum(e**2 / variance)) - np.sum(np.log(np.diag(factor) / np.sqrt(variance)))
    assert gain[0] == pytest.approx(expected, rel=1e-10)


def test_a_white_error_beside_a_slow_one_may_be_a_fifth_of_what_one_alone_is_at_least(short):
    """An instrument whose errors are all coloured has no white ones; below rounding there is none for any."""
    _, _, _, noise = short
    size = noise.variance.size
    parts = search.Parts.of(noise, np.full(size, 1e-4), np.r_[3e-5, np.full(size - 1, 1e-9)], 60.0)
    expected = np.where(noise.slow > 0.0, 4e-6, 1e-4)
    np.testing.assert_allclose(
        np.exp(parts.low[:size]), np.where(np.arange(size) == 0, np.maximum(expected, 3e-5), expected)
    )
    assert (noise.slow > 0.0).any() and (noise.slow == 0.0).any()


def test_slow_errors_are_found_where_they_are():
    """Beside the parameters that flew it: two columns of thirteen drift, by half a deviation of their averages."""
    sizes = {"imu.yaw_rate_rad_s": 0.0025, "dvl.sway_m_s": 0.004}
    run = flown(90.0, 5, **{name.replace(".", "__"): size for name, size in sizes.items()})
    layout, seen, _ = record([run], FEW)
    noise, found = settle(Fit(seen, white := first_noise(seen)), layout.null, white.variance)
    for c, name in enumerate(layout.columns):
        if name in sizes:
            assert noise.slow[c] == pytest.approx(sizes[name], rel=0.6), name
            assert 0.5 <= noise.slow_s[c] <= 8.0
    assert sum(noise.slow > 0.0) <= 4
    raw = Fit(seen, noise.even).filter(layout.null)
    at = layout.columns.index("imu.yaw_rate_rad_s")

    def lagged(z: np.ndarray) -> float:
        mine = z[seen[0].column == at]
        return float(mine[1:] @ mine[:-1] / (mine @ mine))

    assert abs(lagged(found[0].z)) < 0.6 * abs(lagged(raw[0].z))


@pytest.mark.slow
@pytest.mark.parametrize("modelled", [True, False])
def test_an_instrument_that_drifts_is_no_gap(monkeypatch, tmp_path, modelled: bool):
    """Taken for white, the slow errors of a simulator's own twin are a cause without a name."""
    if not modelled:
        monkeypatch.setattr(search, "SURELY", 1e9)
    errors = {f"imu__accel_{axis}_m_s2": 0.04 for axis in "xyz"} | {"imu__pitch_rate_rad_s": 0.004}
    found = vt.diagnose([flown(60.0, 6, **errors)], nominal=FEW, effects=["gyro_bias", "linear_drag"])
    assert (found.verdict.kind == "none") == modelled
    assert bool(found.document["slow_errors"]) == modelled
    found.report(tmp_path / "gap.html")
    assert ("Slow errors of instruments" in (tmp_path / "gap.html").read_text()) == modelled


@pytest.mark.slow
def test_a_slow_error_does_not_hide_what_a_heading_misreads():
    """The deviation of a compass, 3 degrees by the sine of the heading, is found beside a drift of the gyro."""
    run = flown(90.0, 7, imu__yaw_rate_rad_s=0.0025)
    heading = run.columns["ahrs.heading_rad"]
    bent = replace(run, columns={**run.columns, "ahrs.heading_rad": heading + 0.05 * np.sin(heading)})
    found = vt.diagnose([bent], nominal=FEW, effects=["gyro_bias", "linear_drag"])
    assert found.verdict.kind == "unknown" and found.verdict.places == ("ahrs",)
