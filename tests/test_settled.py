"""The fit and its noise are each at the other's: a disturbance is no larger for parameters that were far off before."""

from __future__ import annotations

import importlib
from dataclasses import replace

import numpy as np
import pytest
from test_rigid_motion import multisine

import vtank as vt
from vtank.diagnose.whole.own import own_unknowns
from vtank.experiment import fly_vehicle
from vtank.experiment.whole_scenario import fly_scenarios
from vtank.rigid.filtered import Noise, free, innovations
from vtank.rigid.fit import Fit
from vtank.rigid.noise import first_noise
from vtank.rigid.places import Sizes, catalogue
from vtank.rigid.recorded import Kept
from vtank.rigid.recordings import record

model = importlib.import_module("vtank.diagnose.whole.model")
selection = importlib.import_module("vtank.diagnose.whole.selection")
settling = importlib.import_module("vtank.diagnose.whole.settling")


@pytest.mark.parametrize(("factor", "alike"), [(1.6, True), (2.5, False)])
def test_a_noise_is_like_another_within_a_factor_of_two(factor: float, alike: bool):
    noise = Noise(np.ones(3), np.array([0.001, 0.0, 0.002, 0.0, 0.0, 0.01]))
    assert noise.like(replace(noise, sigma=noise.sigma * [1.0, 1.0, factor, 1.0, 1.0, 1.0])) is alike
    assert noise.like(replace(noise, memory_s=factor * noise.memory_s)) is alike


@pytest.mark.slow
def test_a_vehicle_far_from_its_file_leaves_no_more_disturbance_than_there_was():
    """In still water a file with 0.6 of the drag and 0.7 of the moment of inertia: what it leaves goes with it."""
    true = vt.load_vehicle("bluerov2")
    drag, added = true.quadratic_drag.copy(), true.added_mass.copy()
    drag[[0, 1, 5]] *= 0.6
    added[5, 5] *= 0.7
    run = fly_vehicle(true, multisine(true, 60.0, 2), 60.0, 2)
    layout, seen, _ = record([run], replace(true, quadratic_drag=drag, added_mass=added))
    noise = first_noise(seen)
    own = own_unknowns(layout, seen)
    settled, _ = settling.settled(model.blank(Fit(seen, noise), layout, (), own), noise.variance)
    assert np.all(settled.fit.noise.sigma < 0.001)  # [m/s2, rad/s2] 0.0006 of 0.3 s in yaw, or none: as likely


@pytest.mark.slow
def test_a_fit_that_begins_far_off_is_led_to_where_it_ends():
    """A thruster that lost 30 % turns a simulation in still water away: gains found from there are as good as any."""
    _, (flown,) = fly_scenarios(
        ["whole/zigzag"], ("vehicle=bluerov2", "duration_s=60", 'effects."thruster_dead@thruster_1".share=0.3')
    )
    layout, seen, _ = record([flown.run], vt.load_vehicle("bluerov2"))
    noise = first_noise(seen)
    still = replace(noise, sigma=np.minimum(noise.sigma, 1e-5))
    far = model.blank(Fit(seen, still), layout, (), own_unknowns(layout, seen))
    found = far.fit.filter(far.vector())
    e = far.fit.residuals([far.vector()], found)
    assert np.mean(e**2) > 10.0
    assert 2.0 * model.refit(far, found, far.theta).cost < len(e), "no worse than the noise"


def test_a_disturbance_that_may_stand_for_a_steady_force_is_tried_as_one_that_forgets():
    vehicle = vt.load_vehicle("bluerov2")
    layout, seen, _ = record([fly_vehicle(vehicle, multisine(vehicle, 20.0, 1), 20.0, 1)], vehicle)
    noise = replace(first_noise(seen), sigma=np.where(seen[0].moves, 0.001, 0.0))
    own = own_unknowns(layout, seen)
    still = model.blank(Fit(seen, replace(noise, memory_s=np.ones(6))), layout, (), own)
    assert not settling.forgetful(still, noise.variance)
    slow = replace(still, fit=replace(still.fit, noise=replace(noise, memory_s=np.full(6, 30.0))))
    ((calm, there),) = settling.forgetful(slow, noise.variance)
    assert np.all(calm.fit.noise.memory_s <= 2.0) and len(there) == 1


def test_a_bias_that_a_slow_error_stands_for_is_found_without_it():
    """A slow error of half a minute follows a bias for as long as a short run lasts; it is likelier to be steady."""
    vehicle, name = vt.load_vehicle("bluerov2"), "imu.yaw_rate_rad_s"
    run = fly_vehicle(vehicle, multisine(vehicle, 40.0, 1), 40.0, 1)
    biased = replace(run, columns={**run.columns, name: run.columns[name] + 0.01})
    layout, seen, _ = record([biased], vehicle)
    biases = [placed for placed in catalogue(layout, seen[0].moves, Sizes.unit(layout)) if placed.effect == "gyro_bias"]
    column, white = layout.columns.index(name), first_noise(seen).even
    slow, slow_s = white.slow.copy(), white.slow_s.copy()
    slow[column], slow_s[column] = 0.01, 32.0
    fit = Fit(seen, replace(white, sigma=np.where(seen[0].moves, 1e-5, 0.0), slow=slow, slow_s=slow_s))
    drifting = model.blank(fit, layout, (), own_unknowns(layout, seen))
    found = fit.filter(drifting.vector())
    drifting = model.refit(drifting, found, drifting.theta)
    (hidden, *_), _ = selection._promising(drifting, found, layout, biases)
    (begin,) = settling.forgetful(drifting, white.variance)
    assert begin[0].fit.noise.slow[column] == 0.0
    (named,), strong = selection.steadied([begin], drifting, layout, biases, white.variance)
    assert strong == {"gyro_bias@imu"}
    gained = named.log_evidence - drifting.log_evidence
    assert named.names == ("gyro_bias@imu",) and gained > hidden.gain + 5.0
    assert named.values(named.effects[0])["yaw_rate_rad_s"][0] == pytest.approx(0.01, abs=0.0005)


@pytest.mark.slow
def test_fins_are_fitted_from_where_other_simulators_have_them():
    """A simulator whose lift drags along the hull, of the wrong sign: from a plate the slope leads to another."""
    vehicle, times = vt.load_vehicle("remus100"), np.arange(0.0, 60.0, 0.2)
    rudder, plane = 0.12 * np.sign(np.sin(0.55 * times)), 0.06 * np.sin(0.8 * times)
    asked = {"time_s": times, "propeller_rev_s": np.full(times.size, 20.0), "rudder_rad": rudder, "plane_rad": plane}
    run = fly_vehicle(vehicle, asked, 60.0, 3, depth_m=10.0)
    columns = {name: values for name, values in run.columns.items() if "accel" not in name}
    layout, (seen,), _ = record([replace(run, columns=columns)], vehicle)
    p = layout.null.copy()
    for fin in vehicle.fins:
        p[layout.at([f"suction@{fin.name}", f"leans@{fin.name}"])] = 1.0, -1.0
    noise = {f"{s.name}.{c}": sd for s in vehicle.sensors for c, sd in zip(s.channels, s.noise, strict=True)}
    sd = np.array([noise[layout.columns[c]] for c in seen.column])
    told = seen.value - innovations(seen, p, free(seen)) + sd * np.random.default_rng(1).standard_normal(sd.size)
    fit = Fit((replace(seen, value=told, _kept=Kept(), _masses={}),), first_noise([seen]))
    own = own_unknowns(layout, [seen])
    begun, found = settling.settled(model.blank(fit, layout, (), own), fit.noise.variance)
    right, _ = settling.reformed(begun, found, fit.noise.variance)
    assert right.log_evidence > begun.log_evidence + 10.0
    values = {u.name: theta + u.base.mean() for u, theta in zip(right.unknowns, right.theta, strict=True)}
    assert values["leans@fins"] < -0.5 and values["suction@fins"] > 0.5
    assert settling.reformed(right, found, fit.noise.variance)[0].log_evidence >= right.log_evidence
    assert settling.reformed(replace(begun, unknowns=(), theta=np.array([])), found, fit.noise.variance)[1] is found
