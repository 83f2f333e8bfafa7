"""Instruments that drift a little: their slow errors are noise, whatever a free form makes of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_rigid_motion import multisine

import vtank as vt
from vtank.experiment.whole import fly_vehicle
from vtank.rigid import noise as search
from vtank.rigid.fit import Fit
from vtank.rigid.noise import first_noise, settle
from vtank.rigid.recorded import record
from vtank.rigid.tint import likelihoods, tint_of

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


def test_innovations_are_made_white_as_their_covariance_says():
    """Two columns with samples at odd times: likelihood and whitening against Cholesky's of the whole covariance."""
    rng = np.random.default_rng(1)
    time, column = np.sort(rng.uniform(0.0, 20.0, 80)), rng.integers(0, 2, 80)
    slow, slow_s, variance = np.array([0.7, 0.0]), np.array([1.5, 1.0]), rng.uniform(0.5, 1.5, 80)
    e = rng.normal(size=80)
    apart = np.abs(time[:, None] - time[None, :])
    same = (column[:, None] == 0) & (column[None, :] == 0)
    covariance = np.diag(variance) + np.where(same, slow[0] ** 2 * np.exp(-apart / slow_s[0]), 0.0)
    factor = np.linalg.cholesky(covariance)
    tint = tint_of(column, time, e, variance, slow, slow_s)
    np.testing.assert_allclose(tint.without(e) / np.sqrt(tint.variance), np.linalg.solve(factor, e), rtol=1e-10)
    changes = rng.normal(size=(80, 3))
    white = tint.without(changes) / np.sqrt(tint.variance)[:, None]
    np.testing.assert_allclose(white, np.linalg.solve(factor, changes), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(np.sum(np.log(tint.variance)), np.linalg.slogdet(covariance)[1], rtol=1e-12)
    mine, gain = column == 0, np.empty(1)
    first = np.arange(mine.sum()) == 0
    likelihoods(time[mine], e[mine], variance[mine], first, slow[:1], slow_s[:1], gain)
    z = np.linalg.solve(factor, e)[mine]
    expected = -0.5 * (z @ z - np.sum(e[mine] ** 2 / variance[mine]))
    expected -= 0.5 * np.sum(np.log(tint.variance[mine] / variance[mine]))
    assert gain[0] == pytest.approx(expected, rel=1e-10)


def test_without_slow_errors_nothing_is_touched():
    e = np.random.default_rng(2).normal(size=20)
    tint = tint_of(np.zeros(20, int), np.arange(20.0), e, np.ones(20), np.zeros(1), np.ones(1))
    assert tint.without(e) is e and not tint.any


def test_a_spike_is_no_slow_error():
    e = np.zeros(200)
    e[100] = 60.0
    tint = tint_of(np.zeros(200, int), 0.1 * np.arange(200), e, np.ones(200), np.array([0.5]), np.array([2.0]))
    np.testing.assert_array_equal(tint.without(e)[101:], 0.0)


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
    raw = [f.innovation / np.sqrt(f.variance) for f in found]
    at = layout.columns.index("imu.yaw_rate_rad_s")

    def lagged(z: np.ndarray) -> float:
        mine = z[seen[0].column == at]
        return float(mine[1:] @ mine[:-1] / (mine @ mine))

    assert abs(lagged(found[0].z)) < 0.6 * abs(lagged(raw[0]))


@pytest.mark.slow
@pytest.mark.parametrize("modelled", [True, False])
def test_an_instrument_that_drifts_is_no_gap(monkeypatch, tmp_path, modelled: bool):
    """Taken for white, the slow errors of a simulator's own twin are a cause without a name."""
    if not modelled:
        monkeypatch.setattr(search, "SURELY", np.inf)
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
