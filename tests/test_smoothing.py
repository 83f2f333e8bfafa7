"""The filters that are written out are those of scipy."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter, savgol_filter

from vtank.diagnose.smoothing import first_order, local_polynomial


def test_a_first_order_filter_is_scipys() -> None:
    x = np.random.default_rng(1).normal(size=200)
    np.testing.assert_allclose(first_order(x, -0.75, 1.0, 0.75), lfilter([-0.75, 1.0], [1.0, -0.75], x), atol=1e-13)


def test_local_polynomials_are_scipys_at_the_ends_too() -> None:
    x = np.random.default_rng(2).normal(size=(60, 3)).cumsum(axis=0)
    np.testing.assert_allclose(local_polynomial(x, 15, 3), savgol_filter(x, 15, 3, axis=0), atol=1e-12)
    np.testing.assert_allclose(local_polynomial(x[:15, 0], 15, 3), savgol_filter(x[:15, 0], 15, 3), atol=1e-12)
