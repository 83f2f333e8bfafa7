"""A vector whose components are as likely nothing as not: its evidence is the mean over all such models."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from vtank.diagnose.whole.model import sparing


def log_evidence(A: np.ndarray, y: np.ndarray, scale: np.ndarray) -> float:
    """Of y = A x + noise of deviation 1, x normal with deviations `scale`, in closed form."""
    C = np.eye(y.size) + (A * scale**2) @ A.T
    return -0.5 * float(y @ np.linalg.solve(C, y)) - 0.5 * float(np.linalg.slogdet(2.0 * np.pi * C)[1])


@pytest.mark.parametrize("needed", [True, False])
def test_it_is_the_mean_of_the_evidence_of_every_set_of_components(needed: bool) -> None:
    rng, scale = np.random.default_rng(3), np.array([2.0, 0.5, 1.0])
    A = rng.normal(size=(40, 3))
    y = A @ [0.0, 0.4, 0.1] + rng.normal(size=40)
    covariance = np.linalg.inv(A.T @ A + np.diag(scale**-2))
    sets = [list(kept) for n in range(int(needed), 4) for kept in itertools.combinations(range(3), n)]
    mean = np.logaddexp.reduce([log_evidence(A[:, kept], y, scale[kept]) for kept in sets]) - np.log(len(sets))
    gain = sparing(covariance @ A.T @ y, covariance, scale, needed)
    assert gain == pytest.approx(mean - log_evidence(A, y, scale), abs=1e-9)
    assert gain > 0.5  # of three numbers one is something


def test_one_component_alone_gains_nothing() -> None:
    assert sparing(np.array([1.0]), np.eye(1), np.ones(1), True) == 0.0
