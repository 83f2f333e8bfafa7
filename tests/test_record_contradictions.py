"""Recordings whose channels cannot all be as their names say: a sound one is left in peace, each fault is told."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from vtank.logs.frames import angles
from vtank.record import DataSetWarning, Run, read_run, write_run
from vtank.record.contradictions import contradictions

Channels = dict[str, tuple[np.ndarray, np.ndarray]]
TIME_S = np.arange(0.0, 120.0, 0.1)


def sound() -> Channels:
    """A vehicle that turns, pitches and dives without rest: attitude twice, gyro, accelerometer, DVL, depth cell."""
    rng, t = np.random.default_rng(1), TIME_S

    def wander(size: float) -> np.ndarray:
        waves = sum(np.sin(f * t + rng.uniform(0.0, 6.3)) for f in rng.uniform(0.2, 1.5, 8))
        return np.asarray(size * waves / 3.0)

    roll, pitch, turn = wander(0.05), wander(0.1), wander(0.3)
    heading = 0.5 + np.cumsum(turn) * 0.1
    heave, surge = wander(0.2), wander(0.4)
    depth = 3.0 + np.cumsum(np.cos(pitch) * np.cos(roll) * heave - np.sin(pitch) * surge) * 0.1
    true = {
        "ahrs.roll_rad": roll, "ahrs.pitch_rad": pitch, "ahrs.heading_rad": (heading + np.pi) % (2.0 * np.pi) - np.pi,
        "mocap.heading_rad": (heading + np.pi) % (2.0 * np.pi) - np.pi, "yaw_rate_rad_s": turn,
        "pitch_rate_rad_s": np.gradient(pitch, t), "depth_m": depth, "heave_m_s": heave, "surge_m_s": surge,
        "sway_m_s": 0.0 * t, "accel_x_m_s2": 9.81 * np.sin(pitch), "accel_y_m_s2": -9.81 * np.cos(pitch) * np.sin(roll),
        "accel_z_m_s2": -9.81 * np.cos(pitch) * np.cos(roll), "bow_N": 0.0 * t,
    }  # fmt: skip
    return {name: (t, values + 1e-3 * rng.standard_normal(t.size)) for name, values in true.items()}


def told(change: Callable[[Channels], None]) -> str:
    """What is said of the recording after a change."""
    channels = sound()
    change(channels)
    return "\n".join(contradictions(Run.from_channels("run", channels)))


def scaled(name: str, by: float, turn: float = 0.0) -> Callable[[Channels], None]:
    """Multiply a channel, and lay it into one turn."""

    def change(channels: Channels) -> None:
        time_s, values = channels[name]
        channels[name] = time_s, (by * values) % turn if turn else by * values

    return change


def timed(name: str, late_s: float, faster: float = 0.0) -> Callable[[Channels], None]:
    """Stamp a channel late, and by a clock that is faster."""

    def change(channels: Channels) -> None:
        time_s, values = channels[name]
        channels[name] = np.round(time_s * (1.0 + faster) + late_s, 6), values

    return change


def in_g(channels: Channels) -> None:
    """Record acceleration in multiples of gravity."""
    for name in ("accel_x_m_s2", "accel_y_m_s2", "accel_z_m_s2"):
        channels[name] = channels[name][0], channels[name][1] / 9.81


@pytest.mark.parametrize(
    "change, said",
    [
        (scaled("ahrs.heading_rad", np.degrees(1.0), 360.0), "column ahrs.heading_rad: turns .* is it in degrees"),
        (scaled("yaw_rate_rad_s", np.degrees(1.0)), "column yaw_rate_rad_s: is .* times as fast .* is it in degrees"),
        (scaled("pitch_rate_rad_s", -1.0), "ahrs.pitch_rad and pitch_rate_rad_s: they turn against each other"),
        (scaled("depth_m", -1.0), "column depth_m: .* above the surface; is it height, z axis up"),
        (scaled("mocap.heading_rad", np.degrees(1.0), 360.0), "mocap.heading_rad and ahrs.heading_rad: .* 57.3 times"),
        (in_g, "columns accel_.: typically .* m.s2, where gravity is 9.81; are they in g, or without gravity"),
        (scaled("heave_m_s", -1.0), "depth_m and heave_m_s: depth grows while heave says up"),
        (scaled("accel_z_m_s2", -1.0), "gravity is upside down against ahrs.roll_rad; does the z axis point up"),
        (
            timed("mocap.heading_rad", 2.0),
            "ahrs.heading_rad and mocap.heading_rad: mocap.heading_rad is (1.9|2) s late",
        ),
        (timed("yaw_rate_rad_s", 1.5), "yaw_rate_rad_s is 1.5 s late; are they from two clocks"),
        (timed("mocap.heading_rad", 0.0, 0.02), "mocap.heading_rad: .* s apart in the first half, .* different speeds"),
        (timed("yaw_rate_rad_s", 0.0, 0.02), "yaw_rate_rad_s: .* s apart in the first half, .* different speeds"),
    ],
)
def test_a_fault_is_told_with_its_columns_and_cause(change: Callable[[Channels], None], said: str) -> None:
    assert re.search(said, told(change))


@pytest.mark.parametrize(("rate", "warned"), [(True, False), (False, True)])
def test_a_vehicle_that_rolls_over_and_over_is_believed_where_a_gyro_says_so_too(rate: bool, warned: bool) -> None:
    time_s = np.linspace(0.0, 40.0, 401)
    channels = {"roll_rad": (time_s, 0.3 * time_s), "depth_m": (time_s, 3.0 + 0.0 * time_s)}
    channels |= {"roll_rate_rad_s": (time_s, 0.3 + 0.01 * np.sin(time_s))} if rate else {}
    said = contradictions(Run.from_channels("run", channels))
    assert any("roll_rad: reaches 12 rad" in sentence for sentence in said) is warned


def test_a_sound_recording_is_left_in_peace() -> None:
    assert told(lambda channels: None) == ""
    assert told(timed("mocap.heading_rad", 0.1)) == ""  # the delay of a sensor


def test_a_heading_that_begins_beyond_a_turn_is_told_without_any_other_channel() -> None:
    run = Run("run", TIME_S, {"heading_rad": 213.0 + 0.0 * TIME_S, "bow_N": 0.0 * TIME_S})
    assert "begins at 213 rad, 33.9 turns; are these degrees?" in contradictions(run)[0]


def test_quaternions_in_another_order_disagree_with_gravity() -> None:
    channels = sound()
    heading = 2.0
    x, y, z, w = 0.0, 0.0, np.sin(0.5 * heading), np.cos(0.5 * heading)
    wrong = angles(np.outer([x, y, z, w], np.ones(TIME_S.size)), "NED-FRD")  # x, y, z, w taken for w, x, y, z
    for name, values in zip(("roll_rad", "pitch_rad", "heading_rad"), wrong, strict=True):
        channels[f"imu.{name}"] = TIME_S, values
    said = contradictions(Run.from_channels("run", channels))
    assert any("imu.roll_rad, imu.pitch_rad" in each and "order of quaternions" in each for each in said)


def test_columns_that_a_run_along_one_axis_does_not_read_are_not_judged() -> None:
    channels = sound()
    scaled("depth_m", -1.0)(channels)
    channels["n_rev_s"] = channels["bow_N"]
    assert not contradictions(Run.from_channels("run", channels))


def test_the_reader_warns_with_the_file(tmp_path: Path) -> None:
    channels = sound()
    scaled("depth_m", -1.0)(channels)
    write_run(tmp_path / "run.csv", Run.from_channels("run", channels))
    with pytest.warns(DataSetWarning, match="run.csv: column depth_m"):
        read_run(tmp_path / "run.csv")


def test_a_delay_that_cannot_be_told_is_none() -> None:
    """Two depth cells of a vehicle that hardly moves: their noise decides where they are most alike."""
    for seed in range(30):
        rng = np.random.default_rng(seed)
        slow = np.convolve(rng.standard_normal(TIME_S.size + 100), np.hanning(101), "valid")
        depth = 0.9 + 3e-3 * slow / slow.std()
        channels = {
            f"{name}.depth_m": (TIME_S, depth + noise * rng.standard_normal(TIME_S.size))
            for name, noise in (("cell", 5e-3), ("mocap", 1e-3))
        }
        assert contradictions(Run.from_channels("run", channels)) == [], seed


def test_a_spin_that_leans_does_not_part_clocks() -> None:
    """Euler angles of a vehicle that spins and leans turn as its three rates together say, none as its own alone."""
    t = np.arange(0.0, 120.0, 0.02)
    roll, pitch, heading = 0.5 * np.sin(0.9 * t), 0.6 * np.sin(0.7 * t + 1.0), 2.5 * t + np.sin(0.3 * t)
    d_roll, d_pitch, d_heading = 0.45 * np.cos(0.9 * t), 0.42 * np.cos(0.7 * t + 1.0), 2.5 + 0.3 * np.cos(0.3 * t)
    across = d_heading * np.cos(pitch)
    channels = {
        "ahrs.roll_rad": (t, roll), "ahrs.pitch_rad": (t, pitch), "ahrs.heading_rad": (t, heading),
        "imu.roll_rate_rad_s": (t, d_roll - d_heading * np.sin(pitch)),
        "imu.pitch_rate_rad_s": (t, d_pitch * np.cos(roll) + across * np.sin(roll)),
        "imu.yaw_rate_rad_s": (t, across * np.cos(roll) - d_pitch * np.sin(roll)),
    }  # fmt: skip
    assert contradictions(Run.from_channels("run", channels)) == []
    late = channels | {"ahrs.pitch_rad": (t + 1.0, pitch)}
    assert "ahrs.pitch_rad is 1 s late" in "\n".join(contradictions(Run.from_channels("run", late)))


def test_a_half_that_tells_no_delay_does_not_part_clocks() -> None:
    """Pitch that drifts for a minute, then swings: noise decides the delay of the first half, whatever the other's."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        pitch = np.where(TIME_S < 60.0, 0.004 * np.cos(0.1 * TIME_S), 0.1 * np.sin(0.8 * TIME_S))
        channels = {
            name: (TIME_S, pitch + 5e-3 * rng.standard_normal(TIME_S.size))
            for name in ("ahrs.pitch_rad", "mocap.pitch_rad")
        }
        assert not contradictions(Run.from_channels("run", channels))


@pytest.mark.parametrize(("heaves_m_s", "warned"), [(0.4, True), (0.02, False)])
def test_what_a_hull_that_dives_by_its_pitch_heaves_tells_nothing_of_signs(heaves_m_s: float, warned: bool) -> None:
    """It is little beside what an instrument that is late makes of surge and pitch."""
    time_s = np.arange(0.0, 60.0, 0.1)
    pitch, heave = 0.2 * np.sin(0.3 * time_s), heaves_m_s * np.sin(0.3 * time_s)
    sinks = np.cos(pitch) * -heave - np.sin(pitch)
    depth = 10.0 + np.cumsum(sinks) * 0.1
    columns = {"depth_m": depth, "ahrs.pitch_rad": pitch, "surge_m_s": np.ones(time_s.size), "heave_m_s": heave}
    warnings = contradictions(Run("dive", time_s, {"thruster_1_command": np.sin(time_s), **columns}))
    assert any("heave says up" in warning for warning in warnings) == warned
