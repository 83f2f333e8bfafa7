"""Least squares in narrow and bent valleys."""

from __future__ import annotations

import importlib

import numpy as np
import pytest
from scipy.optimize import least_squares

from vtank.diagnose.whole.descent import descend

NOISE = 1e-3


def readings(theta: np.ndarray) -> np.ndarray:
    """Of a gain of which a share is lost: their product alone is seen, and that very well."""
    gain, share = theta
    return ((1.0 + gain) * (1.0 - share) - 0.4) / NOISE * np.ones(3)


def slopes(theta: np.ndarray, _: np.ndarray) -> np.ndarray:
    gain, share = theta
    return np.outer(np.ones(3), [(1.0 - share) / NOISE, -(1.0 + gain) / NOISE])


SCALE, BOUNDS = np.array([0.05, 0.5]), (np.array([-0.9, 0.0]), np.array([20.0, 1.0]))


def cost(theta: np.ndarray) -> float:
    return 0.5 * float(np.sum(readings(theta) ** 2) + np.sum((theta / SCALE) ** 2))


def test_a_bent_valley_is_followed_in_a_few_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """From far along the valley, where a straight step of any use ends on its wall."""
    best = least_squares(
        lambda theta: np.append(readings(theta), theta / SCALE), [0.0, 0.6], bounds=BOUNDS, xtol=1e-15, ftol=1e-15
    ).x
    begin = np.array([-0.55, 0.0])
    found, e, J = descend(readings, slopes, begin, SCALE, BOUNDS, steps=8, held=True)
    assert cost(found) == pytest.approx(cost(best), abs=0.05)
    np.testing.assert_allclose(e, readings(found))
    np.testing.assert_allclose(J, slopes(found, e))
    monkeypatch.setattr(importlib.import_module("vtank.diagnose.whole.descent"), "BACK", 0)
    assert cost(descend(readings, slopes, begin, SCALE, BOUNDS, steps=8, held=True)[0]) > cost(best) + 1.0


def test_bounds_and_priors_hold() -> None:
    found, _, _ = descend(readings, slopes, np.zeros(2), SCALE, (BOUNDS[0], np.array([20.0, 0.3])), 30, held=True)
    assert found[1] == 0.3 and (1.0 + found[0]) * 0.7 == pytest.approx(0.4, abs=1e-3)
    nothing, _, _ = descend(lambda t: np.zeros(1), lambda t, e: np.zeros((1, 2)), np.ones(2), SCALE, BOUNDS, 8, True)
    np.testing.assert_allclose(nothing, 0.0, atol=0.02)
