"""Lumped surge parameters against masses and coefficients, feet against SI."""

from __future__ import annotations

import numpy as np
import pytest

from vtank.plant.lumped import from_feet, lump, propeller_forces, to_feet
from vtank.plant.truth import load_truth, truth_names
from vtank.units import FOOT_M, G_M_S2, LBF_N, RPM_REV_S, SLUG_KG

MASS_KG, DRAG, THRUST, LOSS, TAU_S = 212.853, 19.27, 0.0852, 0.629, 0.3  # M, D, T, L, tau


def test_units_agree_with_the_sources() -> None:
    assert G_M_S2 / FOOT_M == pytest.approx(32.174, rel=2e-6)  # S1's g [ft/s2]
    assert 435.0 * LBF_N == pytest.approx(1935.0, rel=1e-4)  # S1's weight
    assert 13.52 * SLUG_KG == pytest.approx(197.3, rel=1e-4)  # S1's mass
    assert 700.0 * RPM_REV_S == pytest.approx(11.67, abs=0.005)


def test_feet_come_back() -> None:
    printed = (-0.7791, 0.0016, -0.1720, 0.7074)
    assert to_feet(from_feet(*printed)) == pytest.approx(printed, rel=1e-12)


def test_the_lumped_equation_is_the_surge_balance_in_feet_as_in_metres() -> None:
    u, n = 0.37, 14.0
    force = -DRAG * u * abs(u) + THRUST * n * abs(n) - LOSS * abs(n) * u
    a, b, gamma, tau = to_feet(lump(MASS_KG, DRAG, THRUST, LOSS, TAU_S))
    feet = u / FOOT_M
    acceleration = a * feet * abs(feet) + b * n * abs(n) + gamma * abs(n) * feet
    assert acceleration * FOOT_M == pytest.approx(force / MASS_KG, rel=1e-12) and tau == TAU_S


def test_thrust_falls_along_the_propeller_curve() -> None:
    count, diameter, kt0, kt1, density, n, u = 2, 0.1016, 0.40, 0.30, 1000.0, 11.67, 0.6
    thrust, loss = propeller_forces(count, diameter, kt0, kt1, density)
    coefficient = kt0 - kt1 * u / (n * diameter)
    assert thrust * n**2 - loss * n * u == pytest.approx(count * density * n**2 * diameter**4 * coefficient, rel=1e-12)


def test_physical_truth_is_the_published_one() -> None:
    a, b, gamma, tau = to_feet(load_truth("physical").lumped)
    assert a == pytest.approx(-0.0276, abs=5e-5)
    assert b == pytest.approx(0.00131, abs=5e-6)
    assert gamma == pytest.approx(-0.0029, abs=1e-4)
    assert tau == 0.1


def test_700_rpm_drive_the_physical_truth_at_2_feet_per_second() -> None:
    """S1's calibration, which neither the KT curve nor the drag states by itself."""
    truth, n = load_truth("physical"), 700.0 * RPM_REV_S
    steady = np.roots([truth.alpha_per_m, truth.gamma_per_rev * n, truth.beta_m_per_rev2 * n**2]).max()
    assert steady / FOOT_M == pytest.approx(2.0, abs=0.01)


@pytest.mark.parametrize(
    ("name", "printed"),
    [("paper-ii", (-0.7791, 0.0016, 0.0, 0.7074)), ("paper-iii", (-1.2359, 0.0131, -0.1720, 3.1413))],
)
def test_paper_truths_are_the_printed_ones(name: str, printed: tuple[float, ...]) -> None:
    assert to_feet(load_truth(name).lumped) == pytest.approx(printed, rel=1e-12)


@pytest.mark.parametrize("name", truth_names())
def test_a_truth_is_a_vehicle_that_drag_slows_and_thrust_drives(name: str) -> None:
    truth = load_truth(name)
    assert truth.alpha_per_m < 0.0 and truth.beta_m_per_rev2 > 0.0 and truth.gamma_per_rev <= 0.0
    assert truth.name == name
