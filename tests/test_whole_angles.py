"""Recorded angles go on beyond a turn, whatever unit they are in, and however often noise crosses the mark."""

from __future__ import annotations

import numpy as np
import pytest

from vtank.rigid.known import onward

TIME = np.arange(0.0, 60.0, 0.1)


def recorded(turn: float, noise: float, pace: float = 0.4) -> tuple[np.ndarray, np.ndarray]:
    """An angle that turns on and hangs about the mark, as it is and as it is written, within half a turn."""
    true = turn / (2.0 * np.pi) * (pace * TIME - 2.0 * np.cos(0.2 * TIME))
    true = true + noise * np.random.default_rng(4).standard_t(3, TIME.size)
    return true, (true + 0.5 * turn) % turn - 0.5 * turn


@pytest.mark.parametrize("turn", [2.0 * np.pi, 360.0, 1.1 * 2.0 * np.pi, 1.03 * 2.0 * np.pi])
@pytest.mark.parametrize("share", [0.0, 0.002])
def test_an_angle_goes_on(turn: float, share: float) -> None:
    true, written = recorded(turn, share * turn)
    found = onward(written)
    assert found - found[0] == pytest.approx(true - true[0], abs=0.03 * turn)


@pytest.mark.parametrize("noise", [0.03, 0.15])
def test_noise_that_crosses_the_mark_makes_no_other_turn(noise: float) -> None:
    _, written = recorded(2.0 * np.pi, noise, pace=0.05)
    assert np.count_nonzero(np.abs(np.diff(written)) > np.pi) >= 4
    np.testing.assert_array_equal(onward(written), np.unwrap(written))
