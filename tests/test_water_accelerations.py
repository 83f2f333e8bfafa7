"""Accelerations of anything in water against equations of motion written anew (chains.py)."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from chains import Link, accelerations, random_links, specification, strips

from vtank import water

GRAVITY = np.array([0.3, -0.2, -9.7])  # [m/s2], askew on purpose
STATES = 1000


def wet_model(links: list[Link]) -> mujoco.MjModel:
    spec = specification(links)
    spec.option.gravity = GRAVITY
    return water.add(spec, {link.name: link.water for link in links if link.water})


@pytest.fixture(scope="module")
def links() -> list[Link]:
    return random_links()


@pytest.fixture(scope="module")
def model(links: list[Link]) -> mujoco.MjModel:
    return wet_model(links)


def stir(model: mujoco.MjModel, data: mujoco.MjData, rng: np.random.Generator) -> None:
    """Any pose, any velocity."""
    data.qpos[:] = rng.normal(size=model.nq)
    mujoco.mj_normalizeQuat(model, data.qpos)
    data.qvel[:] = rng.normal(size=model.nv)
    data.qfrc_applied[:] = 5.0 * rng.normal(size=model.nv)


def test_accelerations_are_those_of_independent_equations(links: list[Link], model: mujoco.MjModel) -> None:
    """Free, jointed and fixed bodies, all couplings and forces, in water that moves and accelerates: to 1e-12."""
    rng, data, worst = np.random.default_rng(2), mujoco.MjData(model), 0.0
    flow, rate = np.array([0.4, -0.3, 0.2]), np.array([0.2, 0.5, -0.4])
    rows = model.body_user[[model.body(link.name).id for link in links if link.water]]
    from vtank.water.record import field

    field(rows, "water_m_s")[:], field(rows, "water_m_s2")[:] = flow, rate
    kept = model.body_user.copy()
    model.body_user[[model.body(link.name).id for link in links if link.water]] = rows
    with water.forces():
        for _ in range(STATES):
            stir(model, data, rng)
            data.time = rng.uniform(0.0, 2.0)
            mujoco.mj_forward(model, data)
            expected = accelerations(
                links, data.qpos, data.qvel, GRAVITY, flow + rate * data.time, rate, data.qfrc_applied
            )
            worst = max(worst, float(np.abs(data.qacc - expected).max() / np.abs(expected).max()))
    model.body_user[:] = kept
    assert worst < 1e-12


def test_eight_strips_are_as_good_as_ten_thousand() -> None:
    """Within 1 % of the largest force where the flow turns round along the hull, exact to 1e-9 where it does not."""
    hull, rng = np.array([-0.6, 0.8, 3.0, 5.0]), np.random.default_rng(3)
    for _ in range(100):
        nu = rng.normal(size=6)
        fine = strips(hull, nu, exact=True)
        assert strips(hull, nu) == pytest.approx(fine, abs=0.01 * np.abs(fine).max())
    straight = np.array([1.0, 2.0, 0.0, 0.0, 0.0, 0.5])
    assert strips(hull, straight) == pytest.approx(strips(hull, straight, exact=True), rel=1e-7)
