"""The planar plant: its kernels know nothing of surge, and recover a vehicle that turns."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vtank.channels import channels
from vtank.estimate.innovations import Noise, filtered, innovations, no_gain
from vtank.estimate.observed import Observed
from vtank.estimate.optimum import Prior, descend
from vtank.estimate.problem import Problem
from vtank.plant.planar import PLANAR

TRUTH = {"m_u": 20.0, "m_v": 33.0, "m_r": 1.6, "X_u": 3.0, "Y_v": 5.0, "N_r": 0.3, "X_uu": 18.0, "Y_vv": 40.0,
         "N_rr": 1.1, "tau": 0.25}  # fmt: skip
P = PLANAR.parameters.vector(TRUTH)
FREE = tuple(TRUTH)
ROWS = {row.name: kind for kind, row in enumerate(channels(PLANAR))}
TICK_S = 0.05
NOISE = {"north_m": 0.01, "east_m": 0.01, "heading_rad": 0.005, "surge_m_s": 0.01, "sway_m_s": 0.01,
         "yaw_rate_rad_s": 0.005, "accel_x_m_s2": 0.05, "accel_y_m_s2": 0.05}  # fmt: skip


def derivative(s, force):
    """The planar equations once more, as matrices: M dnu/dt = -C(nu) nu - D(nu) nu + X, and the lag."""
    nu, thrust, psi = s[3:6], s[6:9], s[2]
    u, v, r = nu
    M = np.diag([TRUTH["m_u"], TRUTH["m_v"], TRUTH["m_r"]])
    C = np.array([[0, 0, -M[1, 1] * v], [0, 0, M[0, 0] * u], [M[1, 1] * v, -M[0, 0] * u, 0]])
    linear = np.array([TRUTH["X_u"], TRUTH["Y_v"], TRUTH["N_r"]])
    D = np.diag(linear + np.array([TRUTH["X_uu"], TRUTH["Y_vv"], TRUTH["N_rr"]]) * np.abs(nu))
    turn = np.array([[np.cos(psi), -np.sin(psi), 0], [np.sin(psi), np.cos(psi), 0], [0, 0, 1]])
    return np.concatenate([turn @ nu, np.linalg.solve(M, thrust - (C + D) @ nu), (force - thrust) / TRUTH["tau"]])


def forces(time: np.ndarray, shift: float) -> np.ndarray:
    """Multisines of three axes [N, N, N m], shape (K, 3)."""
    waves = [((0.25, 12.0), (0.9, 6.0)), ((0.4, 14.0), (1.1, 5.0)), ((0.33, 0.9), (0.7, 0.6))]
    return np.column_stack([sum(a * np.cos(w * time + shift * w * 7) for w, a in axis) for axis in waves])


def flown(shift: float, seed: int | None, duration_s: float = 40.0, only: tuple[str, ...] = tuple(NOISE)) -> Observed:
    """A run by scipy's integrator, tick by tick, with all sensors; without noise where there is no seed."""
    time = np.arange(0.0, duration_s, TICK_S)
    force, states = forces(time, shift), [np.zeros(9)]
    for k in range(time.size - 1):
        step = solve_ivp(lambda t, s, f=force[k]: derivative(s, f), (0, TICK_S), states[-1], rtol=1e-10, atol=1e-12)
        states.append(step.y[:, -1])
    s = np.array(states)
    ds = np.array([derivative(row, f) for row, f in zip(s, force, strict=True)])
    seen = dict(zip(list(NOISE)[:6], s.T[:6], strict=True))
    seen |= {"accel_x_m_s2": ds[:, 3] - s[:, 4] * s[:, 5], "accel_y_m_s2": ds[:, 4] + s[:, 3] * s[:, 5]}
    rng = np.random.default_rng(seed)
    values = [seen[name] + (NOISE[name] * rng.standard_normal(time.size) if seed is not None else 0.0) for name in only]
    kinds = [np.full(time.size, ROWS[name]) for name in only]
    stamps, order = np.tile(time, len(only)), np.argsort(np.tile(time, len(only)), kind="stable")
    return Observed(f"run {shift:g}", "forces", time, force, stamps[order], np.concatenate(values)[order],
                    np.concatenate(kinds)[order], plant=PLANAR)  # fmt: skip


@pytest.fixture(scope="module")
def quiet_run() -> Observed:
    return flown(0.0, None)


def level(sigma: float = 0.0) -> Noise:
    return Noise(tuple(NOISE[row.name] ** 2 for row in channels(PLANAR)), sigma=sigma)


def test_the_simulation_agrees_with_an_independent_one_on_every_channel(quiet_run):
    """Forces are held, so that the only error is that of the Runge-Kutta step: below 1 % of every sensor's noise."""
    e = innovations(quiet_run, P, np.zeros(9), level(), no_gain(quiet_run))
    for name, kind in ROWS.items():
        assert np.abs(e[quiet_run.kind == kind]).max() < 0.01 * NOISE[name], name


def test_the_step_is_of_fourth_order():
    start, force = (0.1, -0.2, 0.7, 0.4, -0.2, 0.3, 5.0, -4.0, 0.5), (10.0, 6.0, -1.0)
    exact = solve_ivp(lambda t, s: derivative(s, np.array(force)), (0, 0.4), start, rtol=1e-12, atol=1e-13).y[:, -1]
    errors = []
    for count in (4, 8, 16):
        s = start
        for k in range(count):
            s = PLANAR.move(0.4 * k / count, 0.4 / count, s, force, (0.0, 0.0, 0.0), P)
        errors.append(np.abs(np.array(s) - exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.8), orders


def test_eight_parameter_sets_at_once_are_eight_simulations(quiet_run):
    many = np.repeat(P[:, None], 11, axis=1) * (1.0 + 1e-3 * np.arange(11))
    together = innovations(quiet_run, many, np.zeros(9), level(), no_gain(quiet_run))
    for k in (0, 7, 10):
        alone = innovations(quiet_run, many[:, k].copy(), np.zeros(9), level(), no_gain(quiet_run))
        np.testing.assert_allclose(together[:, k], alone, atol=1e-13)


@pytest.mark.slow
def test_the_vehicle_is_identified_from_runs_with_noise():
    runs = tuple(flown(shift, seed) for shift, seed in ((0.0, 1), (1.0, 2)))
    wrong = PLANAR.parameters.vector({name: value * 1.3 for name, value in TRUTH.items()})
    problem = Problem(runs, wrong, FREE, noise=level())
    guess, free = problem.initial(), np.full(problem.size, np.inf)
    low = np.where(np.arange(problem.size) < len(FREE), 1e-3, -np.inf)
    end = descend(problem, guess, Prior(np.zeros(problem.size), free, low, free), problem.filter(guess))
    assert end.converged
    sd = np.sqrt(np.diag(np.linalg.inv(end.information)))[: len(FREE)]
    found, true = end.theta[: len(FREE)], np.array(list(TRUTH.values()))
    assert np.all(np.abs(found - true) < 4.0 * sd), dict(zip(FREE, (found - true) / sd, strict=True))
    assert np.all(sd < 0.2 * true)
    residual = problem.residuals(end.theta, problem.filter(end.theta))
    assert np.mean(residual**2) == pytest.approx(1.0, abs=0.04)


def test_the_filter_of_twelve_states_whitens_a_disturbed_run(quiet_run):
    """Sway is pushed at random: simulation drifts off, the filter that knows of it leaves innovations of unit size."""
    rng, run = np.random.default_rng(3), flown(0.5, 4)
    sigma, memory = 0.05, 1.0
    force = run.input.copy()
    push, keep = 0.0, np.exp(-TICK_S / memory)
    for k in range(force.shape[0]):
        push = keep * push + sigma * np.sqrt(1 - keep**2) * rng.standard_normal()
        force[k, 1] -= push * TRUTH["m_v"]  # asked for less than acted: an acceleration that nobody recorded
    unknown = Observed("pushed", "forces", run.input_time_s, force, run.time_s, run.value, run.kind, plant=PLANAR)
    variance = np.array(level().variance)[run.kind]
    blind = innovations(unknown, P, np.zeros(9), level(), no_gain(unknown))
    knowing = filtered(unknown, P, np.zeros(9), level(sigma), variance)
    assert np.mean(blind**2 / variance) > 10.0
    assert np.mean(knowing.innovation**2 / knowing.variance) < 1.2
