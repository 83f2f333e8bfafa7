"""A vehicle that is left alone shows what the water does."""

from __future__ import annotations

import numpy as np
import pytest
from recorded import NOISE, NOISE_M, NOMINAL, record, sine, turbulent

from vtank.diagnose.evidence import STILL_SIGMA, evaluate
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.rest import still_sigma
from vtank.diagnose.selection import prepare
from vtank.plant.parameters import slot, vector

MEMORY_S = 2.0


def found(sigma_m_s2: float, idle_s: float, p: np.ndarray = NOMINAL) -> float:
    """What two runs of a vehicle tell that wait before they set out."""
    drive = np.concatenate([np.zeros(round(10 * idle_s)), sine(0.5, 10.0, 60.0)])
    waters = (turbulent(sigma_m_s2, MEMORY_S, seed) for seed in (3, 4))
    runs = [record(f"run_{k}", drive, p, NOISE_M, k, water) for k, water in enumerate(waters)]
    return still_sigma(evaluate(prepare(runs, p).with_noise(NOISE), Hypothesis()))


@pytest.mark.parametrize("sigma_m_s2", [5e-3, 1e-2])
def test_rest_tells_how_rough_the_water_is(sigma_m_s2: float) -> None:
    assert found(sigma_m_s2, 60.0) == pytest.approx(sigma_m_s2, rel=0.5)


def test_still_water_is_what_is_usual() -> None:
    assert found(2e-4, 60.0) == STILL_SIGMA


def test_without_rest_nothing_is_said() -> None:
    assert found(1e-2, 0.0) == STILL_SIGMA


def test_a_vehicle_stirs_the_water_by_a_hundredth_of_its_thrust() -> None:
    """Ten times the thrust and the drag of the Phoenix: a light vehicle, which the same wake moves ten times as far."""
    light = vector(
        {"thrust_lag.tau": 0.05, "alpha": 10.0 * NOMINAL[slot("alpha")], "beta": 10.0 * NOMINAL[slot("beta")]}, NOMINAL
    )
    drive = sine(0.5, 10.0, 60.0)
    thrust = light[slot("beta")] * drive * np.abs(drive)
    assert found(1e-3, 0.0, light) == pytest.approx(0.01 * np.sqrt(np.mean(thrust**2)), rel=0.05)
