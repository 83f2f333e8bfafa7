"""The other axes: thruster forces make the wanted wrench, stay within limits and bring the hull back."""

from __future__ import annotations

import numpy as np
import pytest

from vtank.experiment.hold import AS_IT_WAS, AXES, allocation, attitude, hold
from vtank.plant.truth import load_truth
from vtank.plant.vehicle import load_vehicle
from vtank.tank import Tank, load_model


def tank() -> Tank:
    return Tank(load_model(), load_vehicle(), load_truth("paper-ii").vector())


def test_allocated_forces_make_the_wanted_wrench() -> None:
    simulated = tank()
    wrenches = simulated.wrenches
    wanted = np.array([1.0, -2.0, 0.3, 0.7])
    made = wrenches.T @ (allocation(wrenches) @ wanted)
    np.testing.assert_allclose(made[list(AXES)], wanted, atol=1e-12)


@pytest.mark.parametrize(
    "start",
    [{"depth": 0.1}, {"sway": 0.1}, {"yaw": 0.1}, {"pitch": 0.1}, {"depth": -0.05, "yaw": -0.05, "sway": 0.05}],
    ids=str,
)
def test_the_hull_comes_back_from_a_displaced_start(start: dict[str, float]) -> None:
    simulated = tank()
    limit = np.array([thruster.limit_N for thruster in simulated.vehicle.steering])
    inertia = np.diagonal(simulated.mass)[list(AXES)].copy()
    allocate = allocation(simulated.wrenches)
    depth = -simulated.qpos[0, 2]
    gains = np.array([[depth, 0.5, 1.0]])
    simulated.qpos[0, 1] -= start.get("sway", 0.0)
    simulated.qpos[0, 2] -= start.get("depth", 0.0)
    yaw, pitch = start.get("yaw", 0.0), start.get("pitch", 0.0)
    simulated.qpos[0, 3:7] = [0.0, np.cos(yaw / 2) * np.cos(pitch / 2), np.sin(yaw / 2), np.sin(pitch / 2)]
    simulated.qpos[0, 3:7] /= np.linalg.norm(simulated.qpos[0, 3:7])
    offset = [-simulated.qpos[0, 1], -simulated.qpos[0, 2] - depth, *attitude(simulated.qpos[0, 3:7])]
    assert np.abs(offset).max() > 0.04
    orders = np.tile(AS_IT_WAS, (1, 4, 1))
    with simulated:
        for _ in range(600):
            hold(simulated.qpos, simulated.qvel, gains, inertia, allocate, limit, orders, simulated.tunnel_N)
            assert (np.abs(simulated.tunnel_N[0]) <= limit).all()
            simulated.step(10)
    roll, pitch, yaw = attitude(simulated.qpos[0, 3:7])
    left = [simulated.qpos[0, 1], -simulated.qpos[0, 2] - depth, roll, pitch, yaw]
    np.testing.assert_allclose(left, 0.0, atol=2e-3)
