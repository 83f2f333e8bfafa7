"""A wall whose place nobody knows: it stands where all ranges have it, and tells of no offset of the sonar."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_whole_likeness import converged, still
from test_whole_places import placed

from vtank.diagnose.whole.score import based, promises
from vtank.diagnose.whole.selection import extended
from vtank.diagnose.whole.sizes import sizes_of
from vtank.experiment import fly_vehicle
from vtank.plant.vehicle import load_vehicle
from vtank.record import Run
from vtank.resources import models_dir
from vtank.rigid.fit import Fit, log_likelihood, walled
from vtank.rigid.noise import first_noise
from vtank.rigid.places import catalogue
from vtank.rigid.recorded import Kept
from vtank.rigid.recordings import record
from vtank.tank import forces, load_whole


def flown(effects: dict[str, dict[str, float]] | None = None) -> Run:
    """A BlueROV that goes to and fro before the wall of the basin, within sight of motion capture."""
    vehicle = load_vehicle("bluerov2")
    time_s = np.arange(0.0, 20.0, 0.1)
    ahead = 0.15 * np.sin(0.8 * time_s)
    signs = {1: 1.0, 2: 1.0, 3: -1.0, 4: -1.0}
    commands = {"time_s": time_s, **{f"thruster_{k}_command": sign * ahead for k, sign in signs.items()}}
    return fly_vehicle(vehicle, commands, 20.0, 1, walls=models_dir() / "basin.xml", effects=effects or {})


@pytest.fixture(scope="module")
def flight() -> Run:
    return flown()


def test_a_wall_is_moved_to_where_all_ranges_have_it(flight: Run) -> None:
    layout, (run,), _ = record([flight], load_vehicle("bluerov2"))
    fit = Fit((run, replace(run, wall=run.wall + 0.05, _kept=Kept())), first_noise([run]))
    here, there = walled(fit, fit.filter(layout.null)).runs
    assert there.wall == pytest.approx(here.wall, abs=0.001)
    again = Fit((here, there), fit.noise)
    for run, then in zip(walled(again, again.filter(layout.null)).runs, again.runs, strict=True):
        assert run.wall == pytest.approx(then.wall, abs=1e-5)


def test_a_few_millimetres_are_no_gap(flight: Run) -> None:
    """The first five ranges have the wall within 4 mm, which all of them would take for an offset of the sonar."""
    layout, (run,), _ = record([flight], load_vehicle("bluerov2"))
    fit = Fit((run,), first_noise([run]))
    (moved,) = walled(fit, fit.filter(layout.null)).runs
    assert 0.001 < abs(moved.wall - run.wall) < 0.02


def test_where_the_wall_is_tells_nothing_of_a_model(flight: Run) -> None:
    """However far it is taken to be, residuals and their slopes are the same, but for gains that barely change."""
    layout, (run,), _ = record([flight], load_vehicle("bluerov2"))
    heavier = layout.null.copy()
    heavier[layout.at(["quadratic_drag@surge"])] *= 1.2
    found = []
    for wall in (run.wall, run.wall + 0.3):
        fit = Fit((replace(run, wall=wall, _kept=Kept()),), first_noise([run]))
        there = fit.filter(layout.null)
        e = fit.residuals([layout.null, heavier], there)
        answer = fit.answers(fit.paths(layout.null, there), [heavier])[:, 0]
        assert np.linalg.norm(e[:, 1] - e[:, 0] - answer) < 0.1 * np.linalg.norm(answer)
        found.append([float(np.sum(e[:, 0] ** 2)), float(np.sum(e[:, 1] ** 2)), log_likelihood(there[0])])
    np.testing.assert_allclose(found[1], found[0], rtol=2e-3)


def test_a_wall_that_slows_the_hull_is_found_by_its_drag_and_its_mass(flight: Run) -> None:
    vehicle, truth = load_vehicle("bluerov2"), {"drag": 1.5, "mass": 0.4}
    (calm, _), (model, found) = still(flight, vehicle), still(flown({"wall_proximity@surge": truth}), vehicle)
    layout, base = model.fit.runs[0].layout, based(model, found)
    sought = [
        c for c in catalogue(layout, model.fit.runs[0].moves, sizes_of(model, found)) if c.effect == "wall_proximity"
    ]
    (promise,) = promises(model, base, layout, sought)
    fitted = converged(extended(model, base.J, found, layout, promise.placed, promise.begin))
    assert fitted.cost < calm.cost + 0.02 * found[0].z.size < model.cost
    for name, (value, sd) in fitted.values(promise.placed).items():
        assert value == pytest.approx(truth[name], abs=4.0 * sd + 0.03 * truth[name])


def test_the_added_mass_of_a_model_is_its_own_after_a_flight() -> None:
    vehicle = load_vehicle("bluerov2")
    whole = load_whole(
        vehicle,
        walls=models_dir() / "basin.xml",
        effects=placed(vehicle, wall_proximity__surge={"drag": 0.0, "mass": 0.9}),
    )
    before = whole.model.body_user.copy()
    with forces():
        whole.flight(5).advance(np.zeros((5, whole.model.nu)))
    np.testing.assert_array_equal(whole.model.body_user, before)
