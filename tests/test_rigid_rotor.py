"""A rotor whose speed lags, and not its force."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from vtank.rigid.layout import DIRECTION, GAIN, HULL, LAG, ROTOR, SAG, SATURATION, THRUSTER
from vtank.rigid.steps import thrusts

LAG_S, REACH, STEP_S = 0.3, 20.0, 0.1


def forces(share: float) -> tuple[np.ndarray, ...]:
    """Mean and half the change of n|n| over steps of 0.1 s, of speeds held for two of them each."""
    p = np.zeros(HULL + THRUSTER)
    own = p[HULL:]
    own[DIRECTION], own[GAIN], own[SATURATION], own[LAG], own[ROTOR], own[SAG] = 1.0, 1.0, np.inf, LAG_S, share, 0.0
    asked = np.linspace(-REACH, REACH, 4001)
    now = STEP_S * np.arange(200)
    stamps, speeds = now[::2].copy(), np.random.default_rng(3).uniform(-REACH, REACH, (100, 1))
    force, swing, _ = thrusts(now, np.full(now.size, STEP_S), stamps, speeds, (asked * np.abs(asked))[None],
                              np.array([REACH]), p, 1, True)  # fmt: skip
    return force[:, 0], swing[:, 0], speeds[:, 0]


def test_speed_lags_as_in_closed_form() -> None:
    force, swing, speeds = forces(1.0)
    n = 0.0
    for k, mean in enumerate(force):
        goal, begin = speeds[k // 2], n

        def thrust(t: float, goal: float = goal, begin: float = begin) -> float:
            turning = goal + (begin - goal) * np.exp(-t / LAG_S)
            return float(turning * abs(turning))

        assert mean == pytest.approx(
            quad(thrust, 0.0, STEP_S)[0] / STEP_S, abs=0.6
        )  # of 400, where a speed turns round amid a step
        assert swing[k] == pytest.approx(0.5 * (thrust(STEP_S) - thrust(0.0)), abs=0.02)
        n = goal + (begin - goal) * np.exp(-STEP_S / LAG_S)


def test_a_share_lies_between_both() -> None:
    force, rotor, half = forces(0.0)[0], forces(1.0)[0], forces(0.5)[0]
    assert np.abs(rotor - force).max() > 10.0
    np.testing.assert_allclose(half, 0.5 * (force + rotor), atol=1e-9)
