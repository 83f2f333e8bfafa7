"""The noise of a vehicle's recordings: what is coloured within a few samples is an instrument's error, not motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_rigid_motion import multisine

import vtank as vt
from vtank.diagnose.whole.diagnosis import needed
from vtank.diagnose.whole.model import at_noise, blank
from vtank.diagnose.whole.own import own_unknowns
from vtank.diagnose.whole.settling import settled, sought
from vtank.experiment import fly_vehicle
from vtank.rigid import noise, noise_search
from vtank.rigid.filtered import Noise
from vtank.rigid.fit import Fit, log_likelihood
from vtank.rigid.recordings import record

COLUMN, MEMORY_S, SIZE_RAD_S, DURATION_S = "imu.yaw_rate_rad_s", 0.2, 0.02, 40.0


def coloured(run: vt.Run) -> vt.Run:
    values, random = run.columns[COLUMN].copy(), np.random.default_rng(5)
    read = np.flatnonzero(np.isfinite(values))
    keep = np.exp(-float(np.median(np.diff(run.time_s[read]))) / MEMORY_S)
    error = 0.0
    for k, z in zip(read, random.standard_normal(read.size), strict=True):
        error = keep * error + np.sqrt(1.0 - keep**2) * SIZE_RAD_S * z
        values[k] += error
    return replace(run, columns={**run.columns, COLUMN: values})


def pushed_about(vehicle: vt.Vehicle, memories_s: Mapping[str, float] | None = None) -> vt.Run:
    """A flight whose thrusters do a little more than their record says, for about a second each time, or another."""
    asked, random = multisine(vehicle, DURATION_S, 1), np.random.default_rng(8)
    step_s, told = float(asked["time_s"][1]), dict(asked)
    for name in sorted(set(asked) - {"time_s"}):  # in one order, whatever the hashes
        keep, noise_of, more = (
            np.exp(-step_s / (memories_s or {}).get(name, 1.0)),
            random.standard_normal(asked[name].size),
            np.zeros(asked[name].size),
        )
        for k in range(1, more.size):
            more[k] = keep * more[k - 1] + 0.03 * np.sqrt(1.0 - keep**2) * noise_of[k]
        told[name] = np.clip(asked[name] + more, -1.0, 1.0)
    run = fly_vehicle(vehicle, told, DURATION_S, 1, depth_m=5.0)
    at = np.searchsorted(asked["time_s"], run.time_s + 1e-9, side="right") - 1
    recorded = {
        name: np.where(np.isfinite(run.columns[name]), asked[name][at], np.nan) for name in asked if name != "time_s"
    }
    return replace(run, columns={**run.columns, **recorded})


def test_a_slow_error_is_told_from_motion() -> None:
    vehicle = vt.load_vehicle("bluerov2")
    flights = [
        fly_vehicle(vehicle, multisine(vehicle, DURATION_S, seed), DURATION_S, seed, depth_m=5.0) for seed in (1, 2)
    ]
    layout, runs, _ = record([coloured(flight) for flight in flights], vehicle)
    begin = noise.first_noise(runs)
    model = blank(Fit(tuple(runs), begin), layout, (), own_unknowns(layout, runs))

    fitted, _ = settled(model, begin.variance)
    here, c = fitted.fit.noise, layout.columns.index(COLUMN)
    assert here.slow[c] == pytest.approx(SIZE_RAD_S, rel=0.3) and 0.1 <= here.slow_s[c] <= 0.5


def test_size_and_memory_of_a_disturbance_go_together_where_neither_goes_alone() -> None:
    """Four times the memory at twice the size is as fast: a ridge, along which the search has to walk."""
    vehicle = vt.load_vehicle("bluerov2")
    layout, runs, _ = record([pushed_about(vehicle)], vehicle)
    first = noise.first_noise(runs)
    model, _ = settled(blank(Fit(tuple(runs), first), layout, (), own_unknowns(layout, runs)), first.variance)
    p, here = model.vector(), model.fit.noise
    far = replace(here, sigma=2.0 * here.sigma, memory_s=4.0 * here.memory_s)

    def likelihood(begin: Noise) -> float:
        _, found = noise_search.settle(replace(model.fit, noise=begin), p, first.variance, near=True)
        return sum(map(log_likelihood, found))

    assert likelihood(far) > likelihood(here) - 3.0


def test_each_axis_remembers_its_disturbance_for_a_time_of_its_own() -> None:
    """Thrusters that push up and down err for long, the others for short: one memory for all suits neither."""
    vehicle = vt.load_vehicle("bluerov2")
    memories_s = {t.column: 8.0 if abs(t.direction[2]) > 0.5 else 0.4 for t in vehicle.thrusters}
    layout, runs, _ = record([pushed_about(vehicle, memories_s)], vehicle)
    first = noise.first_noise(runs)
    own = own_unknowns(layout, runs)
    fitted, found = settled(blank(Fit(tuple(runs), first), layout, (), own), first.variance)
    here = fitted.fit.noise
    assert np.mean(here.memory_s[2:5]) > 1.5 * np.mean(here.memory_s[[0, 1, 5]])

    def likelihood(memory_s: float) -> float:
        alike = replace(here, memory_s=np.full(6, memory_s))
        return sum(map(log_likelihood, replace(fitted.fit, noise=alike).filter(fitted.vector())))

    assert sum(map(log_likelihood, found)) > max(map(likelihood, (0.6, 0.8, 1.0, 1.25, 1.6, 2.0))) + 10.0
    selection = SimpleNamespace(best=fitted, found=found)
    assert needed(selection, 0.1 * here.sigma) and not needed(selection, 0.98 * here.sigma)


def test_a_slow_error_has_to_be_likelier_by_what_speaks_against_it_beforehand() -> None:
    """A bias would be held against it otherwise: that pays for its prior, and a slow error fits it nearly as well."""
    vehicle = vt.load_vehicle("bluerov2")
    layout, runs, _ = record([fly_vehicle(vehicle, multisine(vehicle, 20.0, 1), 20.0, 1, depth_m=5.0)], vehicle)
    model = blank(Fit(tuple(runs), noise.first_noise(runs).even), layout, (), own_unknowns(layout, runs))
    slow = np.where(np.arange(len(layout.columns)) == layout.columns.index(COLUMN), 1e-9, 0.0)  # [rad/s] nothing else
    without, with_it = (at_noise(model, replace(model.fit.noise, slow=size))[0] for size in (0.0 * slow, slow))
    assert without.log_evidence - with_it.log_evidence == pytest.approx(noise.SURELY, abs=1e-3)


def test_a_covariance_of_which_rounding_leaves_nothing_is_no_likelihood() -> None:
    left = SimpleNamespace(variance=np.array([1.0, -1e-20]), z=np.zeros(2))
    assert log_likelihood(left) == -np.inf
    assert np.isfinite(log_likelihood(SimpleNamespace(variance=np.ones(2), z=np.zeros(2))))


def test_a_noise_at_which_the_filter_loses_its_way_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """However likely it seemed from the noise before; the search then stays with that one."""
    run = fly_vehicle(vt.load_vehicle("kingfisher"), multisine(vt.load_vehicle("kingfisher"), 10.0, 1), 10.0, 1)
    layout, seen, _ = record([run], vt.load_vehicle("kingfisher"))
    fit = Fit(seen, noise.first_noise(seen))
    quiet = replace(fit.noise, variance=1e-6 * fit.noise.variance)

    def foreseen(runs, found, parts):
        likelihood = sum(map(log_likelihood, found))
        return [noise_search.Tried(quiet, likelihood + 1e3, found)]

    def lost(fit: Fit, p: np.ndarray):
        if fit.noise is quiet:
            raise vt.InputError("the simulation diverges")
        return filtered(fit, p)

    filtered = Fit.filter
    monkeypatch.setattr(noise_search, "_scored", foreseen)
    monkeypatch.setattr(Fit, "filter", lost)
    found, _ = noise_search.settle(fit, layout.null, fit.noise.variance, near=True)
    np.testing.assert_array_equal(found.variance, fit.noise.variance)


def test_no_noise_beside_a_free_form_part_is_less_than_what_is_believed() -> None:
    """A simulator's own runs may have none at all."""
    vehicle = vt.load_vehicle("kingfisher")
    layout, seen, _ = record([fly_vehicle(vehicle, multisine(vehicle, 10.0, 1), 10.0, 1)], vehicle)
    fit = Fit(seen, noise.first_noise(seen))
    least = fit.noise.variance
    assert np.any(sought(fit, layout.null, least, 0.0).variance < 0.9 * least)
    assert np.all(sought(fit, layout.null, least, least).variance >= least * (1.0 - 1e-9))
