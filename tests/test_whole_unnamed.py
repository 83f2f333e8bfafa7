"""What has no name in a whole vehicle: found where it is, in what it goes with, and when."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_rigid_motion import multisine
from test_whole_causes import FEW, REMUS, ROV, flown_with

import vtank as vt
from vtank.diagnose.freeform.functions import dragged
from vtank.diagnose.freeform.motion import faded
from vtank.diagnose.whole.model import blank, refit
from vtank.diagnose.whole.own import own_unknowns
from vtank.diagnose.whole.score import based
from vtank.diagnose.whole.settling import settled
from vtank.diagnose.whole.sizes import sizes_of
from vtank.experiment.whole import fly_vehicle
from vtank.rigid.fit import Fit
from vtank.rigid.noise import first_noise
from vtank.rigid.places import catalogue
from vtank.rigid.recordings import record

SECONDS = 60.0
EASY = ("linear_drag", "sensor_latency", "sensor_scale")  # effects that might be named instead


def without_noise(vehicle: vt.Vehicle) -> vt.Vehicle:
    """The vehicle with instruments that err by nothing."""
    return replace(vehicle, sensors=tuple(replace(s, noise=tuple(0.0 for _ in s.noise)) for s in vehicle.sensors))


def known(vehicle: vt.Vehicle, inputs: dict[str, np.ndarray], column: str) -> Callable[[np.ndarray], np.ndarray]:
    """What a column of a flight would read, at any time."""
    run = fly_vehicle(without_noise(vehicle), inputs, SECONDS, 1)
    there = np.isfinite(run.columns[column])
    return lambda t: np.interp(t, run.time_s[there], run.columns[column][there])


def found_in(run: vt.Run, vehicle: vt.Vehicle, **columns: np.ndarray) -> vt.WholeDiagnosis:
    """The diagnosis of the run with other columns, whose dots are written __."""
    other = run.columns | {name.replace("__", "."): values for name, values in columns.items()}
    return vt.diagnose([replace(run, columns=other)], nominal=vehicle, effects=EASY)


def turned_otherwise(asked: dict[str, np.ndarray], rudder_rad: np.ndarray) -> vt.WholeDiagnosis:
    """The diagnosis, which blames the rudder, of a flight whose rudder stood otherwise than was recorded."""
    run = fly_vehicle(REMUS, {**asked, "rudder_rad": rudder_rad}, SECONDS, 3)
    there = np.isfinite(run.columns["rudder_rad"])
    recorded = np.full(run.time_s.size, np.nan)
    at = np.searchsorted(asked["time_s"], run.time_s[there] + 1e-9, side="right") - 1
    recorded[there] = asked["rudder_rad"][at]
    diagnosis = found_in(run, REMUS, rudder_rad=recorded)
    assert (diagnosis.verdict.kind, diagnosis.verdict.places) == ("unknown", ("rudder",))
    return diagnosis


@pytest.mark.slow
def test_a_level_that_takes_acceleration_for_tilt_goes_with_the_surge() -> None:
    inputs = multisine(FEW, SECONDS, 4)
    surge = known(FEW, inputs, "dvl.surge_m_s")
    run = fly_vehicle(FEW, inputs, SECONDS, 1)
    rate = np.gradient(surge(run.time_s), run.time_s)
    diagnosis = found_in(run, FEW, ahrs__pitch_rad=run.columns["ahrs.pitch_rad"] + 0.1 * faded(run.time_s, rate, 1.0))
    assert (diagnosis.verdict.kind, diagnosis.verdict.places) == ("unknown", ("ahrs",))
    [block] = [block for block in diagnosis.selection.blocks if block.place == "ahrs" and block.repeats]
    assert diagnosis.document["unexplained"]["blocks"]["ahrs"] == block.gain, "the strongest of its columns"
    assert any("surge" in name for name in block.goes_with)


def drawn(run: vt.Run, inputs: dict[str, np.ndarray]) -> np.ndarray:
    """The current that thrusters draw, at the rows of a run, as it goes with their thrust."""
    asked = np.array([np.interp(run.time_s, inputs["time_s"], inputs[t.column]) for t in FEW.thrusters])
    return np.asarray(np.mean(np.abs(asked) ** 1.5, axis=0))


@pytest.mark.slow
def test_a_compass_beside_cables_goes_with_the_load() -> None:
    inputs = multisine(FEW, SECONDS, 4)
    run = fly_vehicle(FEW, inputs, SECONDS, 1)
    heading = run.columns["ahrs.heading_rad"] + 0.5 * drawn(run, inputs)
    diagnosis = found_in(run, FEW, ahrs__heading_rad=heading)
    assert (diagnosis.verdict.kind, diagnosis.verdict.places) == ("unknown", ("ahrs",))
    assert "load" in diagnosis.selection.blocks[0].goes_with[0]


@pytest.mark.slow
def test_an_effect_keeps_its_name_beside_what_has_none_somewhere_else() -> None:
    """A thruster that pushes less astern than it is said to, and a compass beside cables."""
    run = flown_with(FEW, SECONDS, thrust_asymmetry__thruster_1={"e": 0.016})
    heading = run.columns["ahrs.heading_rad"] + drawn(run, multisine(FEW, SECONDS, 3))
    beside = replace(run, columns=run.columns | {"ahrs.heading_rad": heading})
    verdict = vt.diagnose([beside], nominal=FEW, effects=(*EASY, "thrust_asymmetry")).verdict
    assert (verdict.effects, verdict.places) == (("thrust_asymmetry",), ("thruster_1",))
    assert "ahrs" in verdict.unexplained


@pytest.mark.slow
def test_what_all_thrusters_lose_together_is_no_fault_of_one() -> None:
    """Air that is drawn near the surface: less thrust, the less deep."""
    inputs = multisine(FEW, SECONDS, 4)
    depth = known(FEW, inputs, "depth.depth_m")
    run = fly_vehicle(FEW, inputs, SECONDS, 1)
    told = depth(run.time_s)
    share = (told - told.min()) / np.ptp(told)
    asked = {name: values * (1.0 + 0.3 * (share < 0.5)) for name, values in run.columns.items() if "command" in name}
    diagnosis = found_in(run, FEW, **asked)
    assert (diagnosis.verdict.kind, diagnosis.verdict.places) == ("unknown", ("thrusters",))
    assert diagnosis.verdict.channel == "actuator"


@pytest.mark.slow
def test_a_fin_that_stands_still_for_a_while_is_found_with_its_time() -> None:
    asked = multisine(REMUS, SECONDS, 2) | {"propeller_rev_s": np.full(int(SECONDS * 5), 20.0)}
    stuck = (asked["time_s"] > 30.0) & (asked["time_s"] < 38.0)
    diagnosis = turned_otherwise(asked, np.where(stuck, 0.1, asked["rudder_rad"]))
    assert diagnosis.selection.blocks[0].goes_with[0] == "a while in run 1"


@pytest.mark.slow
def test_a_disturbance_that_stands_for_a_late_thruster_does_not_hide_it() -> None:
    """At the disturbance that is likeliest without it nothing of it is seen; at far less of one it is, and stays."""
    selection = importlib.import_module("vtank.diagnose.whole.selection")
    run = flown_with(FEW, SECONDS, command_delay__thruster_3={"d_s": 0.2})
    layout, seen, _ = record([run], FEW)
    own, noise = own_unknowns(layout, seen), first_noise(seen)
    quiet, found = settled(blank(Fit(seen, noise), layout, (), own), noise.variance)
    some = tuple(c for c in catalogue(layout, seen[0].moves, sizes_of(quiet, found)) if c.effect == "command_delay")
    loud = replace(
        quiet, fit=replace(quiet.fit, noise=replace(quiet.fit.noise, sigma=np.full(6, 3.0), memory_s=np.full(6, 0.3)))
    )
    there = loud.fit.filter(loud.vector())
    loud = refit(loud, there, loud.theta)
    assert selection._promising(loud, there, layout, some)[0][0].gain < 5.0
    named, strong = selection._as_quiet(SimpleNamespace(best=loud, layout=layout, own=loud), some, noise.variance)  # type: ignore[arg-type]
    assert "command_delay@thruster_3" in strong
    assert named is not None and named.names == ("command_delay@thruster_3",)


def test_what_goes_with_an_error_knows_nothing_of_the_reading() -> None:
    """Filter and pilot answer to a reading at once; what came of that would explain the reading's noise."""
    unnamed = importlib.import_module("vtank.diagnose.whole.unnamed")
    layout, [seen], _ = record([fly_vehicle(FEW, multisine(FEW, 20.0, 4), 20.0, 1)], FEW)
    mine = np.flatnonzero(seen.column == layout.columns.index("ahrs.pitch_rad"))
    m = mine[mine.size // 2]
    other = replace(seen, value=seen.value + 0.05 * (np.arange(seen.value.size) == m))
    felt = []
    for run in (seen, other):
        fit = Fit((run,), first_noise([seen]))
        [path] = fit.paths(layout.null, fit.filter(layout.null))
        felt.append(unnamed._felt(path))
    known = seen.time_s <= seen.time_s[m]
    assert np.array_equal(felt[0][known], felt[1][known])
    assert not np.array_equal(felt[0][~known], felt[1][~known])


def test_a_model_is_judged_by_its_own_filter() -> None:
    """Not by that of one whose force goes with a place, of which speeds then seem to tell before anything else does."""
    selection = importlib.import_module("vtank.diagnose.whole.selection")
    vehicle = replace(ROV, sensors=tuple(s for s in ROV.sensors if s.name in ("imu", "dvl", "mocap")))
    run = fly_vehicle(vehicle, multisine(vehicle, 20.0, 4), 20.0, 1)
    late = {name: np.where(run.time_s < 2.0, np.nan, values) for name, values in run.columns.items() if "mocap" in name}
    layout, seen, _ = record([replace(run, columns=run.columns | late)], vehicle)
    own = blank(Fit(seen, first_noise(seen)), layout, (), own_unknowns(layout, seen))
    there = own.fit.filter(own.vector())
    [tether] = [c for c in catalogue(layout, seen[0].moves, sizes_of(own, there)) if c.name == "tether@sway"]
    tied = blank(own.fit, layout, (tether,), own.unknowns)
    tied = replace(tied, theta=np.append(own.theta, 5.0))
    by_another = tied.fit.filter(tied.vector())
    right, wrong = (refit(own, found, own.theta).log_evidence for found in (there, by_another))
    judged = selection.by_itself(refit(own, by_another, own.theta), by_another)
    assert wrong < right - 10.0
    assert judged.log_evidence == pytest.approx(right, abs=1.0)


@pytest.mark.slow
def test_play_of_a_linkage_is_found_by_which_way_the_rudder_went() -> None:
    """Noise that stands for it at first lets go of it."""
    asked = multisine(REMUS, SECONDS, 2) | {"propeller_rev_s": np.full(int(SECONDS * 5), 20.0)}
    diagnosis = turned_otherwise(asked, dragged(asked["rudder_rad"], 0.015))
    assert diagnosis.selection.blocks[0].goes_with[0] == "which way the input went last"


def test_what_is_known_beside_the_model_pushes_a_run_as_it_says() -> None:
    """A steady acceleration of yaw is a moment of the mass that turns; errors of readings are taken off them."""
    layout, [run], _ = record([fly_vehicle(FEW, multisine(FEW, 20.0, 4), 20.0, 1)], FEW)
    p, course = layout.null, np.zeros((run.steps.now.size, 6))
    course[:, 5] = 0.02
    hull, pushed = run.hull(p), run.beside(p, course)
    more = pushed.drive(p).thrust - run.drive(p).thrust
    assert np.allclose(more, (hull.body + hull.water) @ course[0]) and more[:, 5].min() > 0.0
    cut = pushed.until(10.0)
    assert np.allclose(cut.drive(p).thrust - run.until(10.0).drive(p).thrust, more[: cut.steps.now.size])
    error = np.linspace(0.0, 1.0, run.time_s.size)
    assert np.array_equal(run.beside(p, error).value, run.value - error)


def test_a_screw_that_turns_the_hull_goes_with_its_thrust() -> None:
    """By the torque that drives it, which acts about another axis than its thrust."""
    unnamed = importlib.import_module("vtank.diagnose.whole.unnamed")
    layout, [run], _ = record([fly_vehicle(REMUS, multisine(REMUS, SECONDS, 2), SECONDS, 1)], REMUS)
    roll = np.zeros((run.steps.now.size, 6))
    roll[:, 3] = -0.02 * run.drive(layout.null).thrust[:, 0]  # that the recording lacks
    noise = first_noise([run])
    own, found = settled(
        blank(Fit((run.beside(layout.null, roll),), noise), layout, (), own_unknowns(layout, [run])), noise.variance
    )
    sizes = sizes_of(own, found)
    [block] = unnamed.at_place(based(own, found), sizes, "roll")
    assert block.repeats and block.goes_with[0].endswith("thrust")
