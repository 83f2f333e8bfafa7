"""The sonar's beam in the tank: nearest echoes of a turned hull against closed forms and against many rays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vtank.experiment.beam import ACROSS_RAD, TARGETS, aim, into_cone, into_fan, rotation
from vtank.experiment.hold import attitude
from vtank.plant.truth import load_truth
from vtank.plant.vehicle import load_vehicle
from vtank.tank import Tank, load_model


@pytest.fixture(scope="module")
def tank() -> Tank:
    return Tank(load_model(), load_vehicle(), load_truth("paper-ii").vector())


def quaternion(yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0) -> np.ndarray:
    """Pose of the body, axes x forward, y starboard, z down, turned by yaw, pitch, roll [rad] in the z-up world."""
    z, y, x = np.array([yaw, pitch, roll]) / 2.0
    about_z, about_y, about_x = (
        [math.cos(z), 0, 0, math.sin(z)],
        [math.cos(y), 0, math.sin(y), 0],
        [math.cos(x), math.sin(x), 0, 0],
    )
    q = np.array([0.0, 1.0, 0.0, 0.0])
    for turn in (about_z, about_y, about_x):
        q = product(q, np.array(turn))
    return q


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Product of quaternions."""
    return np.concatenate([[a[0] * b[0] - a[1:] @ b[1:]], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])])


def nearest(tank: Tank, point: list[float], q: np.ndarray, fan: bool, half: float) -> float:
    directions = np.zeros((TARGETS, 3))
    aim(q, fan, half, directions)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    return float(tank.ray(np.array(point), directions).min())


def distances(tank: Tank, point: list[float]) -> dict[str, float]:
    axes = np.array([[1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, -1]], dtype=float)
    return dict(zip(("ahead", "port", "starboard", "down"), tank.ray(np.array(point), axes)[0], strict=True))


POINT = [1.0, 0.2, -0.9]


def test_attitude_recovers_yaw_pitch_and_roll() -> None:
    for angles in [(0.3, -0.2, 0.1), (-1.0, 0.5, -0.4), (0.0, 0.0, 0.0)]:
        q = quaternion(*angles)
        roll, pitch, yaw = attitude(q)
        assert (yaw, pitch, roll) == pytest.approx(angles)
        r = np.array(rotation(q)).reshape(3, 3)
        np.testing.assert_allclose(r @ r.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize("degrees", [0.0, 0.3, 0.5, 3.0, -12.0])
@pytest.mark.parametrize("axis", ["yaw", "pitch"])
def test_a_turned_pencil_reads_the_edge_of_its_cone(tank: Tank, axis: str, degrees: float) -> None:
    half, angle = math.radians(0.5), math.radians(degrees)
    read = nearest(tank, POINT, quaternion(**{axis: angle}), False, half)
    wall = distances(tank, POINT)["ahead"]
    if axis == "yaw" or degrees != -12.0:  # nose down by 12 deg the floor is no nearer than the wall: 1.2 m/sin 12.5
        assert read == pytest.approx(wall / math.cos(max(abs(angle) - half, 0.0)), rel=1e-12)


@pytest.mark.parametrize("degrees", [0.0, 7.0, -12.0, 14.0])
def test_a_pitched_fan_still_looks_straight_at_the_wall(tank: Tank, degrees: float) -> None:
    half, pitch = math.radians(12.0), math.radians(degrees)
    read = nearest(tank, POINT, quaternion(pitch=pitch), True, half)
    wall = distances(tank, POINT)
    expected = wall["ahead"] / math.cos(max(abs(pitch) - half, 0.0))
    down = half - pitch  # the fan's lower edge, positive below the horizontal
    floor = wall["down"] / math.sin(down) if down > 0.0 else math.inf
    assert read == pytest.approx(min(expected, floor), rel=1e-9)


def test_a_yawed_hull_hears_the_side_wall_where_that_is_nearer(tank: Tank) -> None:
    wall, yaw, half = distances(tank, POINT), math.radians(60.0), math.radians(0.5)
    read = nearest(tank, POINT, quaternion(yaw=yaw), False, half)
    side = wall["starboard"] / math.sin(yaw + half)
    assert side < wall["ahead"] / math.cos(yaw - half)
    assert read == pytest.approx(side, rel=1e-9)


@pytest.mark.parametrize("fan", [False, True])
def test_few_rays_find_what_many_rays_find(tank: Tank, fan: bool) -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        q = quaternion(*rng.uniform(-0.6, 0.6, 3))
        point, half = rng.uniform([0.0, -1.0, -1.5], [2.0, 1.0, -0.5]), rng.uniform(0.02, 0.2)
        if fan:
            azimuth, elevation = rng.uniform(-ACROSS_RAD, ACROSS_RAD, 4000), rng.uniform(-half, half, 4000)
            body = np.array(
                [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
            )
        else:
            away, around = half * np.sqrt(rng.uniform(0, 1, 4000)), rng.uniform(0, 2 * np.pi, 4000)
            body = np.array([np.cos(away), np.sin(away) * np.cos(around), np.sin(away) * np.sin(around)])
        many = float(tank.ray(point, (np.array(rotation(q)).reshape(3, 3) @ body).T).min())
        few = nearest(tank, point.tolist(), q, fan, half)
        assert few <= many + 1e-9
        assert few == pytest.approx(many, rel=2e-2)


def test_a_beam_without_width_is_one_ray() -> None:
    for direction in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-0.6, 0.0, 0.8)):
        assert into_cone(*direction, 0.0) == pytest.approx((1.0, 0.0, 0.0))
    single = np.zeros((1, 3))
    aim(quaternion(yaw=0.3), False, 0.0, single)
    np.testing.assert_allclose(single[0], [math.cos(0.3), -math.sin(0.3), 0.0], atol=1e-12)
    assert into_fan(1.0, 0.0, 0.0, 0.1) == (1.0, 0.0, 0.0)
