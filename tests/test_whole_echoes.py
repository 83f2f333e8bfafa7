"""Echoes that a sonar of a whole vehicle hears: heard again once all else is found, where they are any."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_whole_wall import flown

from vtank.diagnose.whole.echoes import Echoes, heard, still_heard
from vtank.plant.vehicle import load_vehicle
from vtank.record import Run
from vtank.rigid.fit import Fit, walled
from vtank.rigid.noise import first_noise
from vtank.rigid.places import Sizes, catalogue
from vtank.rigid.recordings import record

RANGE = "ping.range_m"


@pytest.fixture(scope="module")
def flight() -> Run:
    return flown()


def asked(run: Run, late_m: float) -> tuple[Echoes | None, Echoes | None]:
    """Echoes where a quarter of the ranges is late, as a lacking cause may make them; and once it is not lacking.

    It is taken to be found by leaving the ranges as they are in what is asked again.
    """
    rng, columns = np.random.default_rng(4), dict(run.columns)
    stray = rng.random(run.time_s.size) < 0.25
    columns[RANGE] = columns[RANGE] + late_m * stray
    layout, (full,), _ = record([run], load_vehicle("bluerov2"))
    _, (late,), _ = record([Run(run.name, run.time_s, columns)], load_vehicle("bluerov2"))
    fit = Fit((late,), first_noise([full]))
    fit = walled(fit, fit.filter(layout.null))
    candidates = catalogue(layout, full.moves, Sizes.unit(layout))
    echoes = heard(fit.runs, fit.filter(layout.null), candidates)
    if echoes is None:
        return None, None
    found = replace(echoes, before=(full,))
    return still_heard(echoes, fit, layout.null, candidates), still_heard(found, fit, layout.null, candidates)


def test_echoes_stay_where_all_ranges_tell_of_them_and_go_where_they_were_feigned(flight: Run) -> None:
    real, feigned = asked(flight, 0.3)
    assert real is not None and real.gain > 20.0
    assert real.placed.parameters[1].starts[0] == pytest.approx(0.3, abs=0.05)
    assert feigned is None


def test_no_echoes_are_heard_of_a_wall_that_has_none(flight: Run) -> None:
    assert asked(flight, 0.0) == (None, None)
