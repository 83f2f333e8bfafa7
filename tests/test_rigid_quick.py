"""A vehicle that is quicker than its estimator's steps and its sensors' averages: nothing of that passes for noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vtank.errors import InputError
from vtank.experiment import fly_vehicle
from vtank.experiment.whole_scenario import fly_whole, load_whole_scenario
from vtank.plant.vehicle import load_vehicle
from vtank.record import Run
from vtank.rigid import recordings
from vtank.rigid.driven import driven
from vtank.rigid.fit import Fit, begun
from vtank.rigid.kalman import Told, carry, weigh
from vtank.rigid.noise import first_noise
from vtank.rigid.noise_search import settle
from vtank.rigid.recorded import Kept, Recorded
from vtank.rigid.recordings import record
from vtank.rigid.thinned import bins_of

YAW_RATE = "imu.yaw_rate_rad_s"


@pytest.fixture(scope="module")
def spun():
    """A BlueROV that spins to one side and to the other, all of its yaw moment at once, from the first moment on."""
    times = np.arange(0.0, 20.0, 1.5)
    side = np.where(np.arange(times.size) % 2, -0.6, 0.6)
    signs = {1: -1.0, 2: 1.0, 3: 1.0, 4: -1.0}
    commands = {"time_s": times, **{f"thruster_{k}_command": sign * side for k, sign in signs.items()}}
    run = fly_vehicle("bluerov2", commands, duration_s=20.0, seed=3)
    _, (seen,), _ = record([run], load_vehicle("bluerov2"))
    return seen


def innovations(run, noise, column):
    (found,) = Fit((run,), noise).filter(run.layout.null)
    mine = run.column == run.layout.columns.index(column)
    return run.time_s[mine], found.innovation[mine], np.sqrt(found.variance[mine])


def test_white_errors_are_no_larger_because_the_motion_is_fast(spun):
    first = first_noise([spun])
    noise, _ = settle(Fit((spun,), first), spun.layout.null, first.variance)
    stated = {f"{s.name}.{c}": (sd, s.rate_hz) for s in spun.layout.vehicle.sensors
              for c, sd in zip(s.channels, s.noise, strict=True)}  # fmt: skip
    for c, column in enumerate(spun.layout.columns):
        sd, rate = stated[column]
        averaged = sd / np.sqrt(max(rate * 20.0 / np.sum(spun.column == c), 1.0))
        assert np.sqrt(noise.variance[c]) == pytest.approx(averaged, rel=0.25), column


def test_thrusters_that_begin_at_once_are_seen_to_begin_at_rest(spun):
    assert spun.resting
    time, e, sd = innovations(spun, first_noise([spun]), YAW_RATE)
    assert np.abs(e / sd)[time < 1.0].max() < 5.0


def test_whether_thrusters_have_pushed_before_a_run_is_told_by_its_first_moments(spun):
    p, noise = spun.layout.null, first_noise([spun])
    (told,) = begun(Fit((replace(spun, resting=False, _kept=Kept()),), noise), p).runs
    assert told.resting
    (again,) = begun(Fit((told,), noise), p).runs
    assert again is told


def test_a_beginning_from_which_the_filter_runs_away_is_none(spun, monkeypatch):
    fit = Fit((spun,), first_noise([spun]))
    monkeypatch.setattr(Recorded, "switched", property(lambda run: replace(run, start=run.start + 1e200, _kept=Kept())))
    with pytest.raises(InputError, match="diverges"):
        replace(fit, runs=(spun.switched,)).filter(spun.layout.null)
    assert begun(fit, spun.layout.null).runs[0] is spun


def test_a_step_is_as_good_as_many(spun):
    still = replace(first_noise([spun]), sigma=np.zeros(6), timing=0.0)
    fine = replace(spun, _kept=Kept(), _masses={})
    fine.__dict__["longest_s"] = spun.longest_s / 10.0
    _, coarse_e, _ = innovations(spun, still, YAW_RATE)
    _, fine_e, _ = innovations(fine, still, YAW_RATE)
    assert np.sqrt(np.mean((coarse_e - fine_e) ** 2)) < 0.1 * 0.005  # of the gyro's noise


def test_no_average_goes_across_a_jump_of_the_inputs():
    """An accelerometer that jumps with the thrusters: half of it before and half after is no reading of either."""
    rng, jump_s = np.random.default_rng(5), 10.03
    time_s = np.unique(np.r_[0.0, jump_s, np.arange(0.0, 20.0, 0.02) + rng.uniform(0.0, 0.019, 1000)])
    ahead = np.where(time_s >= jump_s, 0.5, -0.5)
    columns = {f"thruster_{k}_command": sign * ahead for k, sign in {1: 1.0, 2: 1.0, 3: -1.0, 4: -1.0}.items()}
    columns["imu.accel_x_m_s2"] = np.where(time_s > jump_s, 1.0, -1.0)
    _, (seen,), _ = record([Run("jump", time_s, columns)], load_vehicle("bluerov2"))
    assert seen.time_s.size < 0.5 * time_s.size
    np.testing.assert_allclose(np.abs(seen.value), 1.0, atol=1e-12)
    np.testing.assert_array_equal(seen.value > 0.0, seen.time_s > jump_s)


def test_averages_of_what_follows_a_jump_are_readings_at_their_time():
    """An accelerometer that dies away as its thrusters' lag does, beside thrusters that hardly more than twitch."""
    rng, lag_s, noise = np.random.default_rng(6), 0.1, 0.05
    ticks, time_s = np.arange(0.0, 60.0, 0.1), np.arange(0.0, 60.0, 0.02)
    held = np.searchsorted(ticks, time_s + 1e-9) - 1
    side, twitch = np.where(np.arange(ticks.size) // 15 % 2, -0.5, 0.5), rng.normal(0.0, 0.002, (2, ticks.size))
    columns = {f"thruster_{k}_command": sign * side[held] for k, sign in {1: 1.0, 2: 1.0, 3: -1.0, 4: -1.0}.items()}
    columns |= {f"thruster_{k}_command": some[held] for k, some in zip((5, 6), twitch, strict=True)}

    def felt(t):
        return 0.8 * np.where(t // 1.5 % 2, -1.0, 1.0) * np.exp(-(t % 1.5) / lag_s)

    columns["imu.accel_x_m_s2"] = felt(time_s - 1e-9) + rng.normal(0.0, noise, time_s.size)
    _, (seen,), _ = record([Run("dies", time_s, columns)], load_vehicle("bluerov2"))
    assert seen.time_s.size < 0.6 * time_s.size
    told = columns["imu.accel_x_m_s2"]

    def share(time_s, value):
        there = felt(time_s - 1e-9)
        return there @ value / (there @ there)

    assert share(seen.time_s, seen.value) == pytest.approx(share(time_s, told), abs=0.01)


def test_what_averages_miss_of_a_closed_loop_is_hidden_by_noise(monkeypatch):
    """A flight without noise, averaged as one with noise: by the vehicle's own numbers nothing is left of it."""
    rov = load_vehicle("bluerov2")
    zigzag = load_whole_scenario("whole/zigzag", ["vehicle=bluerov2", "duration_s=30"])
    quiet = replace(rov, sensors=tuple(replace(s, noise=(1e-9,) * len(s.noise)) for s in rov.sensors))
    noisy, still = (fly_whole(zigzag, vehicle).run for vehicle in (rov, quiet))
    layout, (loud,), _ = record([noisy], rov)
    bins, share = bins_of([noisy], layout, [driven(noisy, layout)])
    monkeypatch.setattr(recordings, "bins_of", lambda *_: (bins, share))
    _, (seen,), _ = record([still], rov)
    variance = first_noise([loud]).variance
    fit = Fit((seen,), replace(first_noise([seen]), variance=variance, sigma=np.zeros(6)))
    e = fit.residuals([layout.null], fit.filter(layout.null))[:, 0]
    assert np.median(np.diff(seen.time_s[seen.column == layout.columns.index("imu.accel_x_m_s2")])) > 0.03
    assert 0.5 * e @ e < 2.0


def test_a_covariance_stays_one_where_the_motion_is_unstable():
    """A mode that grows while it is measured: what rounding makes skew must not grow beside it."""
    rng, F = np.random.default_rng(0), np.eye(12) * 0.98
    F[6, 7], F[7, 6], F[3, 9] = 0.3, 0.3, 0.1
    P = np.diag(np.full(18, 1e-4))
    T, A, C, gain, H = np.zeros((18, 12)), np.zeros((18, 18)), np.zeros(18), np.zeros(18), np.zeros(18)
    told, still, jolts = Told(*np.empty((5, 1))), np.zeros((0, 6, 3)), np.zeros((1, 6))
    for _ in range(4000):
        carry(F, 0.05, np.full(6, 1e-3), np.full(6, 2.0), np.empty(0), np.empty(0), still, jolts, 0, T, P, A)
        H[:] = 0.0
        H[:12] = rng.normal(size=12) * (rng.uniform(size=12) < 0.3)
        weigh(P, H, -1, 1e-6, C, gain, 0, told)
        assert told.explained[0] >= 0.0
    assert np.array_equal(P, P.T)
    assert np.linalg.eigvalsh(P).min() > -1e-12 * np.linalg.eigvalsh(P).max()


def test_what_was_under_way_when_a_recording_began_was_pushed_before():
    vehicle = load_vehicle("remus100")
    times = np.arange(0.0, 20.0, 0.1)
    rudder = 0.1 * np.sign(np.sin(0.9 * times))
    commands = {"time_s": times, "propeller_rev_s": np.full(times.size, 21.0), "rudder_rad": rudder}
    whole = fly_vehicle(vehicle, commands, 20.0, 3, depth_m=3.0)
    later = whole.time_s >= 12.0
    began = {name: values[later] for name, values in whole.columns.items()}
    held = {"propeller_rev_s": 21.0, "rudder_rad": rudder[times < 12.0 + 1e-9][-1]}  # as they stand in the first row
    for name, value in held.items():
        began[name] = np.where(np.arange(later.sum()) == 0, value, began[name])
    _, (seen,), _ = record([Run("cut", whole.time_s[later] - 12.0, began)], vehicle)
    assert not seen.resting and seen.steps.now[0] >= seen.stamps[0] - 1e-6
    time, e, sd = innovations(seen, first_noise([seen]), "imu.accel_x_m_s2")
    assert np.abs(e / sd)[time < 1.0].max() < 3.5
    drive = seen.drive(seen.layout.null)
    assert drive.thrust[:, 0] == pytest.approx(drive.thrust[-1, 0]) and drive.fins[0, -1] == 0.0
    assert drive.fins[0] == pytest.approx(drive.fins[1])
