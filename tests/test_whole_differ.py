"""When own parameters are said to be others than the file has."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_rigid_motion import flown

from vtank.diagnose.whole.model import blank, refit
from vtank.diagnose.whole.own import Unknown, own_unknowns
from vtank.diagnose.whole.selection import AGREE, SURELY_OFF, begun_at, differ
from vtank.rigid.fit import Fit, log_likelihood
from vtank.rigid.noise import first_noise

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


def test_own_parameters_are_fitted_from_those_that_agree_with_the_file():
    """They hold these, whatever begin has led their own fit astray."""
    run = flown("kingfisher", 30.0)
    layout, fit = run.layout, Fit((run,), first_noise((run,)))
    wide = own_unknowns(layout, fit.runs)
    close = blank(fit, layout, (), [replace(u, scale=AGREE * u.scale) if u.stated else u for u in wide])
    none = refit(close, fit.filter(close.vector()), np.zeros(len(wide)))
    found = begun_at(none, wide)
    assert [u.name for u in found.unknowns] == [u.name for u in wide] and not found.effects
    likely = [sum(map(log_likelihood, fit.filter(model.vector()))) for model in (none, found)]
    assert likely[1] > likely[0]
