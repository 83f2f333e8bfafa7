"""The Gymnasium environment passes Gymnasium's own checker and is the tank."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="needs gymnasium: pip install 'vtank[gym]'")


@pytest.fixture(params=["phoenix", "bluerov2", "kingfisher", "remus100"])
def made(request: pytest.FixtureRequest):  # type: ignore[no-untyped-def]
    import vtank.gym  # noqa: F401

    return gymnasium.make("vtank/Tank-v0", vehicle=request.param)


@pytest.mark.filterwarnings("error::UserWarning")
def test_gymnasiums_own_checker_has_nothing_to_say(made) -> None:  # type: ignore[no-untyped-def]
    from gymnasium.utils.env_checker import check_env

    check_env(made.unwrapped, skip_render_check=True)
    assert mujoco.get_mjcb_control() is None  # nothing is left behind between steps


def test_full_ahead_goes_ahead_and_the_goal_is_told_in_the_vehicles_axes(made) -> None:  # type: ignore[no-untyped-def]
    seen, _ = made.reset(seed=4)
    parts = made.unwrapped.parts
    ahead = np.array([np.sign(round(part.direction[0], 6)) if hasattr(part, "direction") else 0.0 for part in parts])
    for _ in range(20):
        after, reward, lost, cut, info = made.step(ahead)
    assert after[6] > 0.05 and after[0] < seen[0] - 0.05 and np.abs(after[1:3] - seen[1:3]).max() < 0.05
    assert reward == pytest.approx(-info["distance_m"] - 0.01 * np.mean(ahead**2)) and not (lost or cut)


@pytest.mark.parametrize("name", ["kingfisher", "remus100"])
def test_each_thruster_and_fin_is_commanded_by_itself(name: str) -> None:
    import vtank.gym  # noqa: F401

    env = gymnasium.make("vtank/Tank-v0", vehicle=name).unwrapped
    turned = []
    for side in (1.0, -1.0):
        env.reset(seed=1)
        action = np.ones(env.action_space.shape)
        action[0 if name == "kingfisher" else -1] = side  # the port propeller astern; the rudder over
        for _ in range(15):
            after = env.step(action)[0]
        turned.append(after[11])
    assert abs(turned[0] - turned[1]) > 0.02
