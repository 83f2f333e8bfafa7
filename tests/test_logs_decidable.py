"""What can be decided from a recording: refusals with their reason, and what remains open."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from vtank.experiment import fly_vehicle
from vtank.logs import decidable, import_log
from vtank.record import Run

TIME_S = np.arange(0.0, 60.0, 0.05)
MOTION = {"surge_m_s": (TIME_S, np.sin(TIME_S)), "battery_V": (TIME_S[::20], 15.0 + 0.0 * TIME_S[::20])}


def driven(input_hz: float, values: Callable[[np.ndarray], np.ndarray], name: str = "bow_command") -> Run:
    """Motion at 20 Hz under an input sampled at a rate of its own."""
    at = np.arange(0.0, 60.0, 1.0 / input_hz)
    return Run.from_channels("run", MOTION | {name: (at, values(at))})


def slow(t: np.ndarray) -> np.ndarray:
    """An input that a few samples a second follow, with rest at its end."""
    return np.where(t < 50.0, 0.5 * np.sin(0.3 * t), 0.0)


def stick(t: np.ndarray) -> np.ndarray:
    """A stick that is moved at will for 12 s."""
    return np.where((t > 20.0) & (t < 32.0), np.random.default_rng(1).uniform(-0.6, 0.6, t.size), 0.0)


def test_a_sound_recording_is_not_refused() -> None:
    found = decidable(driven(20.0, slow))
    assert not found.refusal and found.input_hz == pytest.approx(20.0) and 45.0 < found.driven_s < 51.0
    assert [what for what, _ in found.undecidable] == ["propeller apart from motor"]
    assert not decidable(driven(20.0, lambda t: 10.0 * slow(t), "bow_rev_s")).undecidable


@pytest.mark.parametrize(
    "run, armed, reason",
    [
        (Run.from_channels("run", MOTION), None, "no actuator channel"),
        (
            driven(10.0, lambda t: 0.02 * np.sin(t)),
            None,
            "motors at stop throughout: 1 inputs, none further than 0.02 of",
        ),
        (driven(10.0, lambda t: 0.0 * t), 0.0, "never armed"),
        (driven(10.0, lambda t: 0.0 * t + 0.4), None, "the inputs never change"),
        (driven(2.0, stick), None, "inputs at 2 Hz and .* s of excitation: too coarse to identify a lag or an inertia"),
        (Run("run", TIME_S, {"bow_command": slow(TIME_S)}), None, "no channel of motion"),
    ],
)
def test_what_can_tell_nothing_is_refused_with_the_reason(run: Run, armed: float | None, reason: str) -> None:
    assert re.match(reason, decidable(run, armed).refusal)


def test_slow_inputs_leave_a_lag_open() -> None:
    open_ = dict(decidable(driven(2.0, slow)).undecidable)
    assert "0.5 s apart" in open_["thrust lag, delays"] and "inertia, added mass" not in open_


def test_commands_that_stand_at_their_changes_are_not_taken_for_a_slow_clock() -> None:
    table = {"time_s": np.arange(0.0, 60.0, 3.0)}
    rng = np.random.default_rng(2)
    for side in ("port", "starboard"):
        table[f"{side}_command"] = rng.uniform(0.2, 1.0, 20)
    found = decidable(fly_vehicle("kingfisher", table, 60.0, seed=1))
    assert not found.refusal and found.input_hz == 0.0
    assert "thrust lag, delays" not in dict(found.undecidable)


def test_a_rudder_beside_a_steady_propeller_is_excitation() -> None:
    run = driven(10.0, lambda t: 0.0 * t + 10.0, "propeller_rev_s")
    rudder = Run.from_channels("run", {name: run.samples(name) for name in run.columns} | {
        "rudder_rad": (TIME_S, 0.2 * np.sign(np.sin(0.2 * TIME_S)))})  # fmt: skip
    assert "never change" in decidable(run).refusal and not decidable(rudder).refusal


SAMPLES = {  # file -> why it is refused, what else it must say
    "ardusub_armed.tlog": (
        "inputs at 2 Hz and 14 s of excitation: too coarse to identify a lag or an inertia",
        "no parameter tells what outputs drive: those from 1 to 8",
    ),
    "ardusub_disarmed.tlog": ("never armed", "4 could not be decoded"),
    "ardusub.BIN": ("motors at stop throughout: 6 inputs, none further than 0.02", "1492 to 1500 us"),
    "ground_robot.bag": ("no actuator channel", "imu_data.heading_rad"),
    "ground_robot.mcap": ("no actuator channel", "imu_data.heading_rad"),
    "px4.ulg": ("never armed, and the motors at stop", "900 to 900 us"),
}


@pytest.mark.parametrize("file", SAMPLES)
def test_sample_logs_are_answered(file: str, recordings: Path, tmp_path: Path) -> None:
    found = import_log(recordings / "logs" / file)
    reason, also = SAMPLES[file]
    assert found.decidable.refusal.startswith(reason) and also in str(found)
    found.write(tmp_path / "run.csv")


def test_a_bag_and_its_conversion_give_the_same_run(recordings: Path) -> None:
    bag, mcap = (import_log(recordings / "logs" / f"ground_robot.{end}").run for end in ("bag", "mcap"))
    assert list(bag.columns) == list(mcap.columns) and np.array_equal(bag.time_s, mcap.time_s)
    assert all(np.array_equal(bag.columns[name], mcap.columns[name], equal_nan=True) for name in bag.columns)


def test_recordings_that_were_identified_are_not_refused(recordings: Path) -> None:
    from vtank.library import load

    for folder in ("kingfisher_2017", "kvlcc2", "haizhe_normal", "emps_estimation"):
        assert not [decidable(run).refusal for run in load(recordings / folder) if decidable(run).refusal]
