"""When own parameters are said to be others than the file has."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from vtank.diagnose.whole.own import Unknown
from vtank.diagnose.whole.selection import AGREE, SURELY_OFF, differ

SCALE = 2.0


def unknown(stated: bool) -> Unknown:
    return Unknown("lag", np.array([0]), np.zeros(1), SCALE, -np.inf, np.inf, 1e-3, stated=stated)


@pytest.mark.parametrize(
    ("off", "sd", "stated", "found"),
    [
        (0.0, 0.001, True, False),
        (AGREE * SCALE, 0.0, True, False),  # as numbers are that agree
        (-1.0, 0.1, True, True),
        (1.0, 0.4, True, False),  # not surely
        (1.0, 0.1, False, False),  # no file states it
    ],
)
def test_a_number_differs_that_is_surely_farther_off_than_those_that_agree(off, sd, stated, found):
    """Others may be exact beside it: all of them wide alike, own parameters pay for what no rival pays."""
    own = [unknown(True), unknown(stated)]
    model = SimpleNamespace(theta=np.array([0.0, off, 9.0]), sd=np.array([sd, sd, 0.1]))
    assert SURELY_OFF * 0.4 > 1.0 - AGREE * SCALE
    assert differ(model, own) == found
