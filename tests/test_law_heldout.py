"""What a formula is worth on stretches that did not choose its numbers."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from vtank.diagnose.laws.heldout import Left


@dataclass
class Linear:
    """A linear problem of three runs, all unknowns shared."""

    J: np.ndarray
    y: np.ndarray
    runs: tuple[int, ...] = (0, 1, 2)

    def linearise(self, theta: np.ndarray, filtered: object) -> tuple[np.ndarray, np.ndarray]:
        return self.J @ theta - self.y, self.J

    def own_slice(self, k: int) -> slice:
        return slice(0, 0)


def test_the_density_of_a_left_out_run_knows_how_sure_the_others_are():
    rng, prior = np.random.default_rng(5), np.array([2.0, 3.0]) ** -2.0
    J = np.vstack([rng.standard_normal((4, 2)), rng.standard_normal((5, 2)) * (1.0, 1e-3), rng.standard_normal((3, 2))])
    y = J @ (0.5, 2.0) + rng.standard_normal(12)
    theta = np.linalg.solve(J.T @ J + np.diag(prior), J.T @ y)
    far = np.full(2, np.inf)
    fit = SimpleNamespace(
        problem=Linear(J, y), optimum=SimpleNamespace(theta=theta),
        prior=SimpleNamespace(weight=prior, mean=np.zeros(2), low=-far, high=far),
        filtered=[SimpleNamespace(innovation=np.zeros(count)) for count in (4, 5, 3)],
    )  # fmt: skip
    expected = 0.0
    for rows in (slice(0, 4), slice(4, 9), slice(9, 12)):
        rest = np.ones(12, bool)
        rest[rows] = False
        known = J[rest].T @ J[rest] + np.diag(prior)
        mean, spread = J[rows] @ np.linalg.solve(known, J[rest].T @ y[rest]), np.linalg.inv(known)
        covariance = np.eye(mean.size) + J[rows] @ spread @ J[rows].T
        expected -= multivariate_normal(mean, covariance).logpdf(y[rows]) - 0.5 * mean.size * np.log(1.0 / (2 * np.pi))
    assert Left(fit).cost == pytest.approx(expected)  # type: ignore[arg-type]
