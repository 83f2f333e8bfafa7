"""Turbulence as water that moves: how it pushes, and that it is found in what it did."""

from __future__ import annotations

import importlib
from dataclasses import replace

import numpy as np
import pytest
from test_rigid_motion import multisine

import vtank as vt
from vtank.compiled import law
from vtank.diagnose.whole.model import blank
from vtank.experiment import fly_vehicle
from vtank.rigid.filtered import filtered, innovations, shaken
from vtank.rigid.fit import Fit, log_likelihood
from vtank.rigid.kalman import slope, swept
from vtank.rigid.layout import CURRENT
from vtank.rigid.motion import rates
from vtank.rigid.noise import first_noise
from vtank.rigid.readings import ACCEL, read
from vtank.rigid.recorded import Kept, Recorded
from vtank.rigid.recordings import record
from vtank.rigid.trials import tried

settling = importlib.import_module("vtank.diagnose.whole.settling")
GUST_M_S, MEMORY_S = 0.006, 4.0


@law
def sweeps(x, drive, hull, stir):
    """The first row of stir at the motion x."""
    D, scratch = np.zeros((12, 12)), np.zeros((28, 18))
    slope(0.0, x, 0, drive, hull, D, scratch)
    swept(D, x, stir, 0)


def calm(name: str, duration_s: float, seed: int = 1) -> Recorded:
    vehicle = vt.load_vehicle(name)
    run = fly_vehicle(vehicle, multisine(vehicle, duration_s, seed), duration_s, seed, depth_m=5.0)
    columns = {key: values for key, values in run.columns.items() if "accel" not in key}
    return record([replace(run, columns=columns)], vehicle)[1][0]


def rate(run: Recorded, i: int, x: np.ndarray, water: np.ndarray) -> np.ndarray:
    """d/dt of the motion x, (18,), in step i of a run, in water that moves north, east, and down, (3,)."""
    p, drive, out = run.layout.null.copy(), run.drive(run.layout.null), np.zeros(18)
    p[CURRENT : CURRENT + 3] = water
    hull = run.hull(run.layout.null)._replace(p=p)
    rates(0.0, x, drive.thrust[i], drive.asked[i], drive.fins[i], np.zeros(6), np.zeros(6), hull, out)
    return out


@pytest.mark.parametrize("name", ["bluerov2", "remus100"])
def test_moving_water_pushes_as_a_current_does(name: str) -> None:
    run, stir = calm(name, 4.0), np.zeros((1, 6, 3))
    x = np.zeros(18)
    x[2:12] = [5.0, 0.1, -0.15, 0.8, 0.9, 0.07, -0.05, 0.1, -0.2, 0.3]
    sweeps(x.copy(), run.drive(run.layout.null), run.hull(run.layout.null), stir)
    for c in range(3):
        by = 1e-5 * (np.arange(3) == c)
        change = (rate(run, 0, x, by) - rate(run, 0, x, -by))[6:12] / 2e-5
        np.testing.assert_allclose(stir[0, :, c], change, rtol=0.0, atol=1e-3 * np.abs(stir).max())


def gusty(run: Recorded, seed: int) -> Recorded:
    """The run as it would have been in gusts, by Runge-Kutta steps, read with white errors of its instruments."""
    rng, p, x, d = np.random.default_rng(seed), run.layout.null, np.zeros(18), np.zeros(3)
    x[:12], value, i = run.start, run.value.copy(), 0
    noise = {f"{s.name}.{c}": sd for s in run.layout.vehicle.sensors for c, sd in zip(s.channels, s.noise, strict=True)}
    d = GUST_M_S * rng.standard_normal(3)
    for m, upto in zip(run.steps.which, run.steps.upto, strict=True):
        while i < upto:
            h = run.steps.length[i]
            k1 = rate(run, i, x, d)
            k2 = rate(run, i, x + 0.5 * h * k1, d)
            k3 = rate(run, i, x + 0.5 * h * k2, d)
            x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(run, i, x + h * k3, d))
            keep = np.exp(-h / MEMORY_S)
            d = keep * d + GUST_M_S * np.sqrt(1.0 - keep * keep) * rng.standard_normal(3)
            i += 1
        assert run.kind[m] < ACCEL
        at = run.kind[m], run.sensor[m], run.column[m]
        value[m] = read(*at, x, np.zeros(18), p, run.layout.counts, run.start[:2], run.wall, run.facing)
        value[m] += noise[run.layout.columns[run.column[m]]] * rng.standard_normal()
    return replace(run, value=value, _kept=Kept(), _masses={})


@pytest.mark.slow
def test_gusts_are_found_in_what_they_did_and_no_slow_errors_instead() -> None:
    run = gusty(calm("bluerov2", 90.0), 2)
    floor = first_noise([run]).variance
    forces, found = settling.settled(blank(Fit((run,), first_noise([run])), run.layout, (), ()), floor)
    assert np.count_nonzero(forces.fit.noise.slow) >= 1, "what a force as large at all times leaves"
    water, there = settling.flowing(forces, found, floor)
    noise = water.fit.noise
    assert noise.flows and water.log_evidence > forces.log_evidence + 30.0
    assert np.count_nonzero(noise.slow) < np.count_nonzero(forces.fit.noise.slow)
    np.testing.assert_allclose(noise.sigma[:3], GUST_M_S, rtol=0.5)
    assert MEMORY_S / 2.0 < np.median(noise.memory_s[:3]) < 2.0 * MEMORY_S
    assert np.all(shaken(noise, there) < 0.2) and not np.array_equal(shaken(noise, there)[:3], noise.sigma[:3])


def test_filters_side_by_side_and_a_simulation_with_its_gains_see_the_same_water() -> None:
    run = gusty(calm("bluerov2", 15.0), 3)
    p, noise = run.layout.null, first_noise([run])
    sigma, memory_s = np.r_[np.full(3, GUST_M_S), noise.sigma[3:]], np.full(6, MEMORY_S)
    noise = replace(noise, sigma=sigma, memory_s=memory_s, flows=True)
    alone = filtered(run, p, noise)
    np.testing.assert_allclose(innovations(run, p, alone.gains), alone.innovation, rtol=0.0, atol=1e-12)
    (beside,) = tried(run, alone, [noise])
    np.testing.assert_allclose(beside.innovation, alone.innovation, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(beside.variance, alone.variance, rtol=1e-6)
    other = replace(noise, sigma=1.1 * sigma)
    (beside,) = tried(run, alone, [other])
    assert log_likelihood(beside) == pytest.approx(log_likelihood(filtered(run, p, other)), abs=0.5)


def test_in_still_water_nothing_flows() -> None:
    run = calm("bluerov2", 20.0)
    floor = first_noise([run]).variance
    still, found = settling.settled(blank(Fit((run,), first_noise([run])), run.layout, (), ()), floor)
    assert not settling.flowing(still, found, floor)[0].fit.noise.flows
    known = replace(run, knows=np.ones(15, bool))
    assert settling.flowing(replace(still, fit=Fit((known,), still.fit.noise)), found, floor)[0].fit.runs[0] is known
