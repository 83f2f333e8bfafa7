"""Changes followed along a run are those that a simulation would have made; noise is found as it was put in."""

from __future__ import annotations

import importlib
from dataclasses import replace

import numpy as np
import pytest
from test_rigid_motion import flown

from vtank.lanes import WIDTH
from vtank.rigid.fit import Fit
from vtank.rigid.kalman import slope
from vtank.rigid.motion import rates
from vtank.rigid.noise import first_noise
from vtank.rigid.noise_search import settle
from vtank.rigid.tangent import accelerations


@pytest.fixture(scope="module")
def fitted():
    run = flown("bluerov2", 30.0)
    noise = first_noise([run])
    fit = Fit((run,), noise)
    return fit, fit.filter(run.layout.null)


@pytest.mark.parametrize("slow", [0.0, 1.0])
@pytest.mark.parametrize(
    ("slot", "change"),
    [
        ("linear_drag@yaw", 0.01), ("drag_asymmetry@surge", 0.01), ("current_north@hull", 0.002),
        ("added_mass@heave", 0.05), ("lost@thruster_3", 0.01), ("slower@thruster_1", 0.005),
        ("delay@thruster_5", 0.005), ("latency@dvl", 0.005), ("rotation_yaw@dvl", 0.005),
        ("bias@imu.yaw_rate_rad_s", 0.001), ("left_out@hull", 0.02),
        ("position_x@dvl", 0.01), ("centre_of_buoyancy_x@hull", 1e-4),
    ],
)  # fmt: skip
def test_a_change_followed_is_a_change_simulated(fitted, slot, change, slow):
    """Also beside slow errors of all instruments, as large as what is white."""
    fit, found = fitted
    layout = fit.runs[0].layout
    if slow:
        drifting = replace(fit.noise, slow=slow * np.sqrt(fit.noise.variance))
        fit = replace(fit, noise=drifting)
        found = fit.filter(layout.null)
    p = layout.null
    moved = layout.null.copy()
    moved[layout.slot(slot)] += change
    sides = fit.residuals([p, moved], found)
    exact, linear = sides[:, 1] - sides[:, 0], fit.answers(fit.paths(p, found), [moved])[:, 0]
    assert np.linalg.norm(exact) > 0.1, "it moves something"
    size, followed = np.linalg.norm(exact), np.linalg.norm(linear)
    assert followed == pytest.approx(size, rel=0.1)
    assert linear @ exact > 0.99 * size * followed


def test_pushes_are_followed_however_they_lie_in_memory(fitted):
    fit, found = fitted
    (path,) = fit.paths(fit.runs[0].layout.null, found)
    push = np.random.default_rng(1).normal(size=(path.run.steps.now.size, 6, WIDTH))
    shift = np.zeros((path.run.time_s.size, WIDTH))
    turned = (np.asfortranarray(push), np.asfortranarray(shift))
    np.testing.assert_array_equal(path.follow(*turned), path.follow(push, shift))


@pytest.mark.parametrize("slot", ["lost@thruster_3", "slower@thruster_1", "delay@thruster_5", "yawed@thruster_2"])
@pytest.mark.parametrize("losing", [0.0, 0.1])
def test_thrust_alone_pushes_as_the_whole_equation_of_motion_says(fitted, slot, losing):
    """Also where speed takes something off the thrust, which then is not all that changes."""
    fit, found = fitted
    layout = fit.runs[0].layout
    (path,) = fit.paths(layout.vector({"loss@thruster_1": losing}), found)
    moved = path.p.copy()
    moved[layout.slot(slot)] += 0.01
    push, _ = path.cause(moved)
    whole, run = np.empty_like(push), path.run
    accelerations(run.hull(moved), run.steps, run.drive(moved), path.way.states, whole)
    assert np.abs(push).max() > 1e-4
    np.testing.assert_allclose(push, whole - path.acceleration, atol=1e-12)


def test_parameters_that_run_away_are_linearised_along_the_filters_own_path(fitted):
    fit, found = fitted
    layout = fit.runs[0].layout
    (path,) = fit.paths(layout.vector({"linear_drag@yaw": -500.0, "linear_drag@sway": -5000.0}), found)
    assert path.way is found[0].way
    assert np.isfinite(path.innovation).all() and np.isfinite(path.way.states).all()


def test_white_errors_are_found_as_they_were_put_in(fitted):
    fit, _ = fitted
    run = fit.runs[0]
    noise, found = settle(fit, fit.runs[0].layout.null, fit.noise.variance)
    stated = {f"{s.name}.{c}": (sd, s.rate_hz) for s in run.layout.vehicle.sensors
              for c, sd in zip(s.channels, s.noise, strict=True)}  # fmt: skip
    for c, column in enumerate(run.layout.columns):
        sd, rate = stated[column]
        averaged = sd / np.sqrt(max(rate * np.ptp(run.time_s) / np.sum(run.column == c), 1.0))
        assert np.sqrt(noise.variance[c]) == pytest.approx(averaged, rel=0.25), column
    z = found[0].innovation / np.sqrt(found[0].variance)
    assert np.mean(z**2) == pytest.approx(1.0, abs=0.1)


def test_the_modules_of_the_rigid_body_know_nothing_of_the_tank():
    for name in ("layout", "motion", "readings", "kernels", "recorded", "fit", "tangent", "places"):
        source = importlib.import_module(f"vtank.rigid.{name}").__file__
        with open(source, encoding="utf-8") as file:
            assert "tank" not in "".join(line for line in file if line.startswith(("from", "import")))


def test_a_slope_beside_a_jump_is_that_on_its_own_side():
    """A fin that stalls loses the suction of its leading edge at once: a difference across that would be any number."""
    run = flown("remus100", 2.0)
    p = run.layout.null.copy()
    p[run.layout.at([f"suction@{fin.name}" for fin in run.layout.vehicle.fins])] = 1.0
    hull, drive = run.hull(p, soft=True), run.drive(p)

    def surge(sway: float) -> float:
        x, rate = np.zeros(18), np.zeros(18)
        x[6], x[7] = 1.5, sway
        rates(0.0, x, drive.thrust[0], drive.asked[0], drive.fins[0], np.zeros(6), drive.known[0, 9:], hull, rate)
        return float(rate[6])

    def slope_at(sway: float) -> np.ndarray:
        x, D = np.zeros(18), np.empty((12, 12))
        x[6], x[7] = 1.5, sway
        slope(0.0, x, 0, drive, hull, D, np.zeros((28, 18)))
        return D

    grid = np.linspace(0.1, 1.4, 2601)
    k = int(np.argmax(np.abs(np.diff([surge(v) for v in grid]))))
    low, high = grid[k], grid[k + 1]
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        above = abs(surge(middle) - surge(low)) < abs(surge(high) - surge(middle))
        low, high = (middle, high) if above else (low, middle)
    assert abs(surge(high) - surge(low)) > 0.01, "there is a jump [m/s2]"
    assert slope_at(low) == pytest.approx(slope_at(low - 1e-5), rel=1e-3, abs=1e-3)
