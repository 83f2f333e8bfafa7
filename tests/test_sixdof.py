"""The terms of the equation of motion against matrix algebra and finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from bodies import skew, symmetric_mass
from scipy.spatial.transform import Rotation

from vtank.plant import sixdof

RNG = np.random.default_rng(11)
TURN = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()


def six(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=6)


def coriolis_matrix(mass: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """Fossen (2011), theorem 3.2."""
    a = skew(mass[:3] @ nu)
    return -np.block([[np.zeros((3, 3)), a], [a, skew(mass[3:] @ nu)]])


def test_rotation_there_and_back() -> None:
    v = six(1)[:3]
    assert sixdof.to_world(TURN, tuple(v)) == pytest.approx(TURN @ v, abs=1e-15)
    assert sixdof.to_body(TURN, tuple(v)) == pytest.approx(TURN.T @ v, abs=1e-15)


def test_products_are_those_of_matrices() -> None:
    matrix, x = RNG.normal(size=(6, 6)), six(2)
    assert sixdof.multiply(matrix, tuple(x)) == pytest.approx(matrix @ x, abs=1e-14)


def test_wrench_of_a_force_at_a_position() -> None:
    force, position = six(3)[:3], six(4)[:3]
    expected = np.concatenate([force, np.cross(position, force)])
    assert sixdof.at(tuple(force), tuple(position)) == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("seed", range(4))
def test_coriolis_terms_are_fossens_and_do_no_work(seed: int) -> None:
    mass, nu = symmetric_mass(seed), six(seed)
    found = np.array(sixdof.coriolis(mass, tuple(nu)))
    assert found == pytest.approx(coriolis_matrix(mass, nu) @ nu, abs=1e-12)
    assert found @ nu == pytest.approx(0.0, abs=1e-12 * np.abs(found).max())


def test_drag_opposes_every_axis() -> None:
    linear, quadratic, nu = np.abs(six(5)), np.abs(six(6)), six(7)
    found = sixdof.drag(linear, quadratic, tuple(nu))
    assert found == pytest.approx(-linear * nu - quadratic * np.abs(nu) * nu, abs=1e-15)


def test_added_mass_forces_follow_from_the_fluids_impulse() -> None:
    """-d/dt of the impulse, in world axes by finite differences, along a turning path in accelerating water."""
    mass, h = symmetric_mass(), 1e-4
    w, v0, v1, flow0, flow1 = (RNG.normal(size=3) for _ in range(5))

    def impulse(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Rotation, velocity through the water in body axes, and the impulse (p, h) in world axes."""
        turn = TURN @ Rotation.from_rotvec(w * t).as_matrix()
        through = v0 + v1 * t - turn.T @ (flow0 + flow1 * t)
        momentum = mass @ np.concatenate([through, w])
        return turn, through, turn @ momentum[:3], turn @ momentum[3:]

    (_, _, p_after, h_after), (_, _, p_before, h_before) = impulse(h), impulse(-h)
    turn, through, p, _ = impulse(0.0)
    force = turn.T @ (p_before - p_after) / (2.0 * h)
    moment = turn.T @ ((h_before - h_after) / (2.0 * h) - np.cross(turn @ through, p))

    nu, acceleration = np.concatenate([v0, w]), np.concatenate([v1, np.zeros(3)])
    flow, water = turn.T @ flow0, turn.T @ flow1
    rest = sixdof.added_mass_forces(mass, tuple(nu), tuple(flow), tuple(water), tuple(acceleration))
    assert rest == pytest.approx(np.concatenate([force, moment]), rel=1e-6, abs=1e-5)
