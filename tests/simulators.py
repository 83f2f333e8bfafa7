"""Simulators of others, for the tests of what is diagnosed against them: a few lines of Euler steps each."""

from __future__ import annotations

import numpy as np

from vtank.record import Run

HOLD_S = 0.1  # of inputs, and of what is recorded


def commands(names: tuple[str, ...], duration_s: float, seed: int, low: float, high: float) -> dict[str, np.ndarray]:
    """Commands that jump every few seconds, each its own."""
    rng, count = np.random.default_rng(seed), round(duration_s / HOLD_S)
    found = {}
    for name in names:
        hold = np.cumsum(rng.integers(15, 50, count))
        values = rng.uniform(low, high, count).round(3)
        found[name] = values[np.searchsorted(hold, np.arange(count), side="right")]
    return found


def surge(duration_s: float, seed: int, friction_N: float = 0.0, noise: np.random.Generator | None = None) -> Run:
    """A tug of 20 kg with linear and quadratic drag and a lag, under a command; its speed, with dry friction."""
    told = commands(("command",), duration_s, seed, -0.8, 0.8)["command"]
    speed, z, u, h = np.empty(told.size), 0.0, 0.0, 0.02
    for k, command in enumerate(told):
        speed[k] = u
        for _ in range(round(HOLD_S / h)):
            z += h * (40.0 * command - z) / 0.3
            u += h * (z - 30.0 * u * abs(u) - 6.0 * u - friction_N * np.tanh(u / 0.01)) / 20.0
    if noise is not None:
        speed += noise.normal(0.0, 0.005, speed.size)
    return Run(f"run_{seed}", HOLD_S * np.arange(told.size), {"command": told, "surge_m_s": speed.round(5)})


def boat(duration_s: float, seed: int, weak: float = 1.0, noise: np.random.Generator | None = None) -> Run:
    """A boat of two hulls, 45 kg, with the Kingfisher's thrusters; `weak`: share of its force that port makes.

    What it reads without noise is of no instrument and at the origin; with it, a gyro and a GPS 0.2 s late.
    """
    told = commands(("port_command", "starboard_command"), duration_s, seed, 0.0, 0.7)
    nu, eta, force, h, late, states = np.zeros(3), np.zeros(3), np.zeros(2), 0.02, 2, []
    mass, coupling = np.diag([50.0, 78.0, 15.0]), 78.0 - 50.0
    for k in range(next(iter(told.values())).size):
        states.append([*eta, *nu])
        goal = 22.0 * np.clip(np.array([told["port_command"][k] * 1.0, told["starboard_command"][k]]) - 0.1, 0.0, 0.6)
        for _ in range(round(HOLD_S / h)):
            force += h * (goal / 0.6 * (weak, 1.0) - force) / 0.25
            u, v, r = nu
            tau = np.array([force.sum(), 0.0, 0.39 * (force[0] - force[1])])
            turning = np.array([mass[1, 1] * v * r, -mass[0, 0] * u * r, -coupling * u * v])
            drag = np.array([6.0, 25.0, 4.0]) * nu + np.array([12.0, 90.0, 6.0]) * nu * np.abs(nu)
            c, s = np.cos(eta[2]), np.sin(eta[2])
            eta = eta + h * np.array([c * u - s * v, s * u + c * v, r])
            nu = nu + h * (tau + turning - drag) / np.diag(mass)
    time, found = HOLD_S * np.arange(len(states)), np.array(states)
    names = ("north_m", "east_m", "heading_rad", "surge_m_s", "sway_m_s", "yaw_rate_rad_s")
    if noise is None:
        return Run(f"run_{seed}", time, told | dict(zip(names, found.round(5).T, strict=True)))
    delayed = np.vstack([found[:1]] * late + [found[:-late]])
    read = {"gps.north_m": delayed[:, 0], "gps.east_m": delayed[:, 1], "gps.surge_m_s": delayed[:, 3],
            "compass.heading_rad": found[:, 2], "compass.yaw_rate_rad_s": found[:, 5]}  # fmt: skip
    sd = (0.1, 0.1, 0.02, 0.03, 0.005)
    noisy = {
        name: values + noise.normal(0.0, s, values.size) for (name, values), s in zip(read.items(), sd, strict=True)
    }
    return Run("real", time, told | noisy)
