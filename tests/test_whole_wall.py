"""A wall whose place nobody knows: it stands where all ranges have it, and tells of no offset of the sonar."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vtank.experiment import fly_vehicle
from vtank.plant.vehicle import load_vehicle
from vtank.record import Run
from vtank.resources import models_dir
from vtank.rigid.fit import Fit, begun, log_likelihood
from vtank.rigid.noise import first_noise
from vtank.rigid.recorded import record


@pytest.fixture(scope="module")
def flight() -> Run:
    """A BlueROV before the wall of the basin, within sight of motion capture."""
    vehicle = load_vehicle("bluerov2")
    time_s = np.arange(0.0, 20.0, 0.1)
    ahead = 0.15 * np.sin(0.8 * time_s)
    signs = {1: 1.0, 2: 1.0, 3: -1.0, 4: -1.0}
    commands = {"time_s": time_s, **{f"thruster_{k}_command": sign * ahead for k, sign in signs.items()}}
    return fly_vehicle(vehicle, commands, 20.0, 1, walls=models_dir() / "basin.xml")


def test_a_wall_is_moved_to_where_all_ranges_have_it(flight: Run) -> None:
    vehicle = load_vehicle("bluerov2")
    layout, (run,), _ = record([flight], vehicle)
    astray = replace(run, wall=run.wall + 0.01, _drives={})
    p, noise = layout.null, first_noise([run])
    (here,), (there,) = (begun(Fit((one,), noise), p).runs for one in (run, astray))
    assert there.wall == pytest.approx(here.wall, abs=0.001)
    (again,) = begun(Fit((there,), noise), p).runs
    assert again is there


def test_a_few_millimetres_are_no_gap(flight: Run) -> None:
    """The first five ranges have the wall within 4 mm, which all of them would take for an offset of the sonar."""
    vehicle = load_vehicle("bluerov2")
    layout, (run,), _ = record([flight], vehicle)
    noise = first_noise([run])
    (moved,) = begun(Fit((run,), noise), layout.null).runs
    before, after = map(log_likelihood, Fit((run, moved), noise).filter(layout.null))
    assert 0.001 < abs(moved.wall - run.wall) < 0.02 and after > before + 3.0
