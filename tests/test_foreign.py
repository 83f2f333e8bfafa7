"""Vehicles without a nominal simulator: thinning, units of the input, and what is found in others' recordings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vtank.diagnose.diagnosis import diagnose
from vtank.diagnose.hypothesis import candidates, stretch
from vtank.diagnose.shrink import shrink
from vtank.diagnose.thinning import straightened, thin, thinned
from vtank.effects.catalogue import BY_NAME
from vtank.estimate.observed import POSITION, SPEED, Observed, observe
from vtank.plant.parameters import null_vector
from vtank.record import read_dataset


def fast(input_name: str = "thrust_N", rate_hz: float = 100.0, top: float = 150.0) -> Observed:
    """Twenty seconds of a smooth input and its integral."""
    time = np.arange(0.0, 20.0, 1.0 / rate_hz)
    return Observed(
        "fast", input_name, time, top * np.sin(time), time, -top * np.cos(time), np.full(time.size, POSITION)
    )


def test_a_smooth_force_keeps_its_impulse() -> None:
    run, slow = fast(), thin(straightened(fast()), 0.05, levels=1)
    assert slow.input.size == pytest.approx(400, abs=1)
    np.testing.assert_allclose(np.diff(slow.input_time_s), 0.05)
    impulse = 150.0 * (1.0 - np.cos(slow.input_time_s[1:]))
    np.testing.assert_allclose(0.05 * np.cumsum(slow.input)[:-1], impulse, atol=0.01)
    np.testing.assert_allclose(slow.value, np.interp(slow.time_s, run.time_s, run.value), atol=1e-9)
    assert np.all(np.diff(slow.time_s) > 0.04)


def test_slow_recordings_stay_as_they_are() -> None:
    run = fast(rate_hz=10.0)
    assert thinned([run])[0] is run
    assert thinned([fast()])[0].time_s.size == pytest.approx(1000, abs=2)


def test_numbers_in_rev_s_follow_the_unit_of_the_input() -> None:
    bias = BY_NAME["tachometer_bias"].parameters[0]
    assert stretch(bias, [fast(top=150.0)]) == pytest.approx(10.0, rel=1e-3)
    assert stretch(bias, [fast("n_rev_s", top=20.0)]) == 1.0
    assert stretch(BY_NAME["linear_drag"].parameters[0], [fast()]) == 1.0


def test_a_measured_thrust_has_no_propeller_effects() -> None:
    names = {effect.name for effect in candidates(null_vector(), [fast()])}
    assert {"coulomb_friction", "linear_drag", "command_delay"} <= names
    assert "tachometer_bias" not in names  # the offset of a measured force belongs to every hypothesis
    assert not names & {"thrust_deadband", "thrust_saturation", "thrust_loss", "thrust_asymmetry", "supply_sag"}
    assert {"thrust_deadband", "thrust_saturation"} <= {e.name for e in candidates(null_vector(), [fast("command")])}


@pytest.mark.slow
def test_dry_friction_of_an_electromechanical_drive_is_found(recordings: Path) -> None:
    """EMPS: M = 95.1 kg, dry friction 20.4 N, viscous 203 N s/m (Janot, Gautier, Brunot 2019)."""
    runs = [observe(run) for run in read_dataset(recordings / "emps_estimation")]
    found = diagnose(runs, None)
    assert found.verdict.kind == "effects"
    assert set(found.verdict.effects) == {"coulomb_friction", "linear_drag"}
    best = found.verdict.fit.log_evidence
    assert found.selection.refit.log_evidence < best - 100.0 and found.probabilities["parameters"] < 0.01  # drag alone
    assert found.verdict.fit.values["force_offset"] == pytest.approx(-3.16, rel=0.1)  # N, their offset
    values = found.verdict.fit.values
    mass = 1.0 / values["beta"]
    assert mass == pytest.approx(95.1, rel=0.06)
    assert mass * values["coulomb_friction.f"] == pytest.approx(20.39, rel=0.03)
    assert mass * values["linear_drag.c"] == pytest.approx(203.0, rel=0.25)
    assert (
        abs(values["alpha"]) * 0.08 < values["linear_drag.c"]
    )  # at its mean speed, quadratic drag is the smaller part
    gap = shrink(found.selection, found.verdict)
    assert gap["unit"] == "m" and gap["diagnosed"] < 0.6 * gap["refit"]


@pytest.mark.slow
def test_saturated_thrusters_of_a_catamaran_win_over_lag(recordings: Path) -> None:
    """Kingfisher: bollard thrust is flat above command 0.7; runs left out are predicted to under 0.08 m/s."""
    runs = [observe(run) for run in read_dataset(recordings / "kingfisher_2017")]
    names = ("thrust_saturation", "thrust_lag", "thrust_deadband", "command_delay", "linear_drag", "thrust_loss")
    found = diagnose(runs, None, names=names)
    assert "thrust_saturation" in found.verdict.effects and "thrust_lag" not in found.verdict.effects
    assert found.verdict.channel == "actuator"
    assert found.verdict.fit.values["thrust_saturation.n_max"] == pytest.approx(0.7, abs=0.1)
    gap = shrink(found.selection, found.verdict)
    assert gap["unit"] == "m/s"
    assert gap["diagnosed"] < 0.08 and gap["diagnosed"] < 0.65 * gap["refit"]
    assert np.all([SPEED in run.first for run in runs])
