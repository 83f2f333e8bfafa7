"""What bounds take of a posterior, against integrals over it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from vtank.diagnose.bounds import within

SD = 0.3  # of the prior


def evidence(best: float, curvature: float, low: float, high: float) -> tuple[float, float]:
    """Log of prior times likelihood, whose cost is least at `best`, over bounds: by `within`, and by integration."""

    def cost(x: float) -> float:
        return 0.5 * curvature * (x - best) ** 2 + 0.5 * (x / SD) ** 2

    H = curvature + SD**-2.0
    free = curvature * best / H
    theta = float(np.clip(free, low, high))
    gradient = curvature * (theta - best) + theta / SD**2
    cut = within(*(np.array(a) for a in ([theta], [gradient], [[1.0 / H]], [low], [high])), 0.0, np.array([SD]))
    laplace = -cost(theta) - np.log(SD) - 0.5 * np.log(H) + cut
    ends = [max(low, free - 12.0 / np.sqrt(H)), min(high, free + 12.0 / np.sqrt(H))]
    if ends[0] >= ends[1]:  # far beyond a bound: what falls off from there
        ends = sorted([theta, theta + np.sign(gradient) * min(30.0 / abs(gradient), 5.0 * SD)])
    posterior, _ = quad(lambda x: np.exp(cost(theta) - cost(x)), *ends, epsabs=0.0)
    prior, _ = quad(lambda x: np.exp(-0.5 * (x / SD) ** 2), max(low, -4.0), min(high, 4.0), points=[0.0])
    return laplace, float(np.log(posterior) - cost(theta) - np.log(prior))


@pytest.mark.parametrize("best", [-1.0, -0.1, -0.01, 0.0, 0.01, 0.1, 1.0])
@pytest.mark.parametrize("curvature", [0.1, 10.0, 1e4])
@pytest.mark.parametrize(("low", "high"), [(0.0, np.inf), (-np.inf, 0.0), (0.0, 5.0), (-3.0, 3.0)])
def test_what_is_cut_off_is_that_of_the_integral(best: float, curvature: float, low: float, high: float) -> None:
    laplace, exact = evidence(best, curvature, low, high)
    assert laplace == pytest.approx(exact, abs=1e-6)


def test_an_unknown_that_touches_its_bound_is_no_likelier_than_one_beside_it() -> None:
    """A number that is as good as nothing costs what its prior was wide, however the fit ends."""
    at, beside = (evidence(best, 1e4, 0.0, np.inf)[0] for best in (-1e-9, 1e-9))
    assert at == pytest.approx(beside, abs=1e-4)
    assert at < -np.log(SD * 100.0) + 0.01  # a deviation of 0.01 out of 0.3


def test_bounds_where_no_one_is_take_nothing_and_lost_digits_say_so() -> None:
    none, some = np.array([-np.inf]), np.array([0.0])
    assert within(some, some, np.eye(1), none, -none, 0.0, np.ones(1)) == 0.0
    assert within(some, some, -np.eye(1), some, -none, 0.0, np.ones(1)) == -np.inf
