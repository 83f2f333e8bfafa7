"""Inputs that turn between the rows that tell of them: nobody knows when, and filters must not believe they do."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import vtank as vt
from vtank.diagnose.whole.diagnosis import _unlogged
from vtank.diagnose.whole.model import blank
from vtank.diagnose.whole.own import own_unknowns
from vtank.diagnose.whole.settling import settled
from vtank.experiment import fly_vehicle
from vtank.plant.sixdof import at
from vtank.rigid.fit import Fit, phased
from vtank.rigid.layout import GAIN, HULL, SEAT, Layout
from vtank.rigid.motion import fin_force, gears, triple
from vtank.rigid.noise import against, first_noise
from vtank.rigid.readings import CHANNELS
from vtank.rigid.recorded import Recorded
from vtank.rigid.recordings import record
from vtank.rigid.trials import tried

ROW_S, FINE_S, DURATION_S = 0.2, 0.02, 60.0
NAMES = [f"thruster_{k}_command" for k in range(1, 9)]


def stepped(at_s: np.ndarray, seed: int) -> vt.Run:
    """A flight of steps at these times, (S,), to the next FINE_S; its log has the commands every ROW_S."""
    vehicle, random = vt.load_vehicle("bluerov2"), np.random.default_rng(seed)
    fine = FINE_S * np.arange(round(DURATION_S / FINE_S))
    level = random.uniform(-0.4, 0.4, (at_s.size + 1, len(NAMES)))
    asked = level[np.searchsorted(at_s, fine + 1e-9, side="right")]
    told = {"time_s": fine, **{name: asked[:, k] for k, name in enumerate(NAMES)}}
    run = fly_vehicle(vehicle, told, DURATION_S, seed, depth_m=5.0)
    logged = np.isclose(np.round(run.time_s / ROW_S) * ROW_S, run.time_s, atol=1e-6)
    columns = {
        name: np.where(logged, values, np.nan) if name in NAMES else values for name, values in run.columns.items()
    }
    return replace(run, columns=columns)


def flown(at_s: np.ndarray, seed: int) -> tuple[Layout, Recorded]:
    """The same for a filter."""
    layout, (seen,), _ = record([stepped(at_s, seed)], vt.load_vehicle("bluerov2"))
    return layout, seen


def timing(at_s: np.ndarray) -> float:
    layout, run = flown(at_s, 3)
    noise = first_noise([run])
    model = blank(Fit((run,), noise), layout, (), own_unknowns(layout, [run]))
    return settled(model, noise.variance)[0].fit.noise.timing


def test_steps_between_rows_are_told_from_such_as_fall_on_rows() -> None:
    at_s = np.arange(1.0, 59.0, 2.0)
    assert 0.05 < timing(at_s + np.random.default_rng(7).uniform(0.0, ROW_S, at_s.size)) < 0.5
    assert timing(at_s) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("within_s", [0.0, ROW_S])
def test_a_log_that_hides_when_inputs_turn_is_told_of(within_s: float) -> None:
    at_s = np.arange(1.0, 59.0, 2.0)
    run = stepped(at_s + np.random.default_rng(7).uniform(0.0, within_s, at_s.size), 3)
    found = vt.diagnose([run], nominal="bluerov2", effects=["linear_drag"])
    assert any(note.startswith("inputs turn between the rows") for note in found.notes) == (within_s > 0.0)
    assert (found.document["disturbance"]["inputs_off"] > 0.05) == (within_s > 0.0)


def test_a_step_is_off_by_itself_over_the_time_between_rows() -> None:
    """Half third differences of a step of 1 are 1/2 and 1 and, were there rows after it, 1/2: squared, 5/4."""
    layout, run = flown(np.array([30.0]), 1)
    p, change = layout.null, np.diff(run.inputs[[0, -1]], axis=0)[0]
    force = np.array([
        np.interp(run.inputs[[0, -1], k], np.linspace(-run.reach[k], run.reach[k], run.tables[k].size), run.tables[k])
        for k in range(change.size)
    ])  # fmt: skip
    force = np.diff(force, axis=1)[:, 0] * p[HULL + GAIN]
    jump = run.hull(p).inverse @ (force @ gears(p, change.size))
    whole = (run.rough * run.steps.length[:, None]).sum(axis=0)
    np.testing.assert_allclose(whole, 1.25 * (ROW_S * jump) ** 2, rtol=1e-3)


def test_a_fin_is_off_by_its_lift_in_the_flow_ahead() -> None:
    """A step of the plane by 0.1 rad, as of a thruster; the rest of the wrench is as it was."""
    vehicle, time_s = vt.load_vehicle("remus100"), ROW_S * np.arange(round(DURATION_S / ROW_S))
    plane = np.where(time_s < 30.0, 0.0, 0.1)
    told = {
        "time_s": time_s,
        "propeller_rev_s": np.full(time_s.size, 20.0),
        "plane_rad": plane,
        "rudder_rad": 0.0 * plane,
    }
    layout, (run,), _ = record([fly_vehicle(vehicle, told, DURATION_S, 4, depth_m=5.0)], vehicle)
    p, first = layout.null, layout.starts[1]
    ahead_m_s = np.median(run.value[(run.kind == CHANNELS.index("surge_m_s")) & (np.abs(run.time_s - 30.0) < 2.0)])
    wrench = np.array(at(fin_force(p, first, 0.1, (ahead_m_s, 0.0, 0.0)), triple(p, first + SEAT)))
    wrench -= at(fin_force(p, first, 0.0, (ahead_m_s, 0.0, 0.0)), triple(p, first + SEAT))
    jump = run.hull(p).inverse @ wrench
    whole = (run.rough * run.steps.length[:, None]).sum(axis=0)
    np.testing.assert_allclose(whole[[2, 4]], 1.25 * (ROW_S * jump[[2, 4]]) ** 2, rtol=0.05)


def test_filters_side_by_side_know_the_timing() -> None:
    _, run = flown(np.arange(1.0, 59.0, 2.0), 2)
    p, noise = run.layout.null, replace(first_noise([run]), timing=0.3)
    exact = Fit((run,), noise).filter(p)[0]
    (beside,) = tried(run, exact, [noise])
    np.testing.assert_allclose(beside.variance, exact.variance, rtol=1e-5)
    off = (beside.innovation - exact.innovation) / np.sqrt(exact.variance)
    np.testing.assert_allclose(off, 0.0, rtol=0.0, atol=1e-6)
    less = tried(run, exact, [replace(noise, timing=0.0)])[0].variance
    assert np.all(less <= beside.variance * (1.0 + 1e-9)) and np.any(less < 0.5 * beside.variance)


def test_rows_of_a_run_that_come_late_are_put_back() -> None:
    """By 15 ms; the prior of 20 ms draws the phase back by less than the 2 ms that it is known within."""
    layout, run = flown(np.arange(1.0, 59.0, 2.0), 3)
    fit = Fit((run, replace(run.shifted(0.015), phase_s=0.0)), first_noise([run]))
    for _ in range(2):
        fit = phased(fit, layout.null)
    there, back = (r.phase_s for r in fit.runs)
    assert back - there == pytest.approx(-0.015, abs=0.002)
    assert against(fit) == pytest.approx(0.5 * ((there / 0.02) ** 2 + (back / 0.02) ** 2))
    np.testing.assert_allclose(fit.runs[1].stamps - run.stamps, 0.015 + back, rtol=0.0, atol=1e-12)


def test_rows_that_come_late_are_told_of() -> None:
    runs = [SimpleNamespace(name=name, phase_s=s, tick_s=0.2) for name, s in (("run_1", 0.009), ("run_2", -0.029))]
    (note,) = _unlogged(SimpleNamespace(noise=SimpleNamespace(timing=0.0), runs=runs))
    assert "29 ms early in run_2:" in note and "run_1" not in note
