"""The Gymnasium environment passes Gymnasium's own checker and is the tank."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="needs gymnasium: pip install 'vtank[gym]'")


@pytest.fixture(params=["phoenix", "bluerov2"])
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
    ahead = np.zeros(made.action_space.shape)
    ahead[0] = 1.0
    for _ in range(20):
        after, reward, lost, cut, info = made.step(ahead)
    assert after[6] > 0.05 and after[0] < seen[0] - 0.05 and np.abs(after[1:3] - seen[1:3]).max() < 0.05
    assert reward == pytest.approx(-info["distance_m"] - 0.01 / ahead.size) and not (lost or cut)
