"""Every kind of log is read into the same run: values, times, axes, units, names."""

from __future__ import annotations

from pathlib import Path

import logfiles
import numpy as np
import pytest
from logfiles import TIME_S, check

from vtank.errors import InputError
from vtank.logs import import_log

EARTH = ("north_m", "east_m", "depth_m")
ODOMETRY = ("roll_rad", "pitch_rad", "heading_rad", *EARTH, "surge_m_s", "sway_m_s", "heave_m_s")


@pytest.mark.parametrize("make, to", [("tlog", 2e-3), ("dataflash", 2e-4), ("ulog", 1e-4)])
def test_logs_of_autopilots_hold_the_dive(make: str, to: float, tmp_path: Path) -> None:
    found = import_log(getattr(logfiles, make)(tmp_path / "dive.log"))
    check(found.run, to=to)
    assert found.run.time_s[0] == 0.0 and not found.decidable.refusal
    assert "cut off" not in str(found) and "thruster_3_command" not in found.run.columns


def test_revolutions_go_to_their_motor_with_the_sign_of_its_command(tmp_path: Path) -> None:
    found = import_log(logfiles.dataflash(tmp_path / "dive.BIN"))
    for thruster, sign in (("thruster_1", 1.0), ("thruster_2", -1.0)):
        assert np.allclose(found.run.samples(f"{thruster}_rev_s")[1], sign * 10.0 * logfiles.COMMAND, atol=1e-5)
    assert "counted without a sign" in str(found)
    assert "propeller apart from motor" not in dict(found.decidable.undecidable)


def test_telemetry_that_comes_late_keeps_the_vehicles_clock(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    run = import_log(logfiles.tlog(tmp_path / "late.tlog", lambda k: rng.exponential(0.2))).run
    assert np.allclose(run.samples("heading_rad")[0], TIME_S, atol=2e-3)


def test_a_vehicle_that_starts_anew_ends_the_recording(tmp_path: Path) -> None:
    path, again = logfiles.tlog(tmp_path / "a.tlog"), logfiles.tlog(tmp_path / "b.tlog", lambda k: 60.0)
    path.write_bytes(path.read_bytes() + again.read_bytes())
    found = import_log(path)
    assert found.run.duration_s == pytest.approx(TIME_S[-1], abs=0.01) and "started anew" in str(found)


@pytest.mark.parametrize("make", ["bag", "bz2", "lz4", "bag2", "mcap"])
def test_bags_hold_the_dive(make: str, tmp_path: Path) -> None:
    if make in ("bag2", "mcap"):
        path = logfiles.bag2(tmp_path / "dive", make == "mcap")
    else:
        path = logfiles.bag(tmp_path / "dive.bag", {"bag": "", "bz2": "BZ2", "lz4": "LZ4"}[make])
    found = import_log(path)
    check(found.run, ODOMETRY)
    assert found.run.samples("north_m")[0][1] == pytest.approx(0.1, abs=1e-6)
    assert found.decidable.refusal.startswith("no actuator channel")
    (tmp_path / "map.toml").write_text(logfiles.THRUST_MAP)
    check(import_log(path, mapping=tmp_path / "map.toml").run, ("thruster_1_command", "thruster_2_command", *EARTH))


def test_a_topic_whose_frame_has_z_down_is_read_so(tmp_path: Path) -> None:
    found = import_log(logfiles.bag2(tmp_path / "dive", frame="world_ned"))
    check(found.run, ODOMETRY)
    assert "pose.pose.position (NED)" in str(found) and "(FRD)" in str(found)


@pytest.mark.parametrize("make", ["bag2", "mcap"])
def test_one_file_of_a_ros_2_bag_is_a_log(make: str, tmp_path: Path) -> None:
    folder = logfiles.bag2(tmp_path / "dive", make == "mcap")
    (file,) = [each for each in folder.iterdir() if each.suffix in (".db3", ".mcap")]
    check(import_log(file).run, ODOMETRY)


@pytest.mark.parametrize("make", ["tlog", "dataflash", "ulog", "bag", "lz4", "mcap"])
@pytest.mark.parametrize("share", [0.3, 0.503, 0.9])
def test_a_log_that_is_cut_off_is_read_as_far_as_it_goes(make: str, share: float, tmp_path: Path) -> None:
    path = tmp_path / "dive.log"
    if make == "mcap":
        path = next(logfiles.bag2(tmp_path / "dive", True).glob("*.mcap"))
    elif make in ("bag", "lz4"):
        logfiles.bag(path, {"bag": "", "lz4": "LZ4"}[make])
    else:
        getattr(logfiles, make)(path)
    whole = import_log(path).run
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    found = import_log(path)
    assert "cut off" in str(found)
    seconds = found.run.samples("heading_rad")[0][-1]
    assert seconds > (share - 0.25) * TIME_S[-1]
    time_s, values = found.run.samples("north_m")
    assert np.array_equal(values, whole.samples("north_m")[1][: time_s.size])


def test_bytes_that_are_no_message_are_skipped_and_told(tmp_path: Path) -> None:
    for make in (logfiles.tlog, logfiles.dataflash):
        path = make(tmp_path / "dive.log")
        data = path.read_bytes()
        middle = len(data) // 2
        if make is logfiles.dataflash:  # which has no checksum
            middle = data.index(b"\xa3\x95", middle)
        path.write_bytes(data[:middle] + bytes(100) + data[middle:])
        found = import_log(path)
        assert "no message" in str(found) or "could not be decoded" in str(found)
        check(found.run, ("depth_m",))


def test_messages_that_cannot_be_decoded_are_counted(tmp_path: Path) -> None:
    path = logfiles.tlog(tmp_path / "dive.tlog")
    data = bytearray(path.read_bytes())
    data[-1] ^= 0xFF  # of the checksum
    path.write_bytes(data)
    assert sum(import_log(path).log.undecoded.values()) == 1


def test_parts_of_one_recording_become_one_run(tmp_path: Path) -> None:
    path = logfiles.tlog(tmp_path / "dive.tlog")
    data = path.read_bytes()
    split = data.index(b"\xfd", len(data) // 2) - 8
    (tmp_path / "a.tlog").write_bytes(data[:split])
    (tmp_path / "b.tlog").write_bytes(data[split:])
    run = import_log(tmp_path / "a.tlog", tmp_path / "b.tlog").run
    assert run.duration_s == pytest.approx(TIME_S[-1], abs=0.1)


@pytest.mark.parametrize("content", [b"", b"\x00\x01\x02\x03" * 20, b"hello\nworld\n", b"ULog\x01\x12\x35"])
def test_what_is_no_log_is_refused_with_the_file(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "strange.bin"
    path.write_bytes(content)
    with pytest.raises(InputError, match="strange.bin"):
        import_log(path)


def test_a_folder_without_a_bag_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no ROS 2 bag here"):
        import_log(tmp_path)
    with pytest.raises(InputError, match="cannot be read"):
        import_log(tmp_path / "absent.BIN")


def test_without_its_library_a_log_is_refused_with_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = logfiles.ulog(tmp_path / "dive.ulg")
    monkeypatch.setitem(__import__("sys").modules, "pyulog", None)
    with pytest.raises(InputError, match=r"pyulog.*pip install 'vtank\[logs\]'"):
        import_log(path)


@pytest.mark.parametrize("make", ["tlog", "dataflash", "ulog", "bag", "lz4", "mcap", "db3"])
def test_a_damaged_log_is_read_or_refused_and_never_a_traceback(make: str, tmp_path: Path) -> None:
    path = tmp_path / "dive.log"
    if make in ("mcap", "db3"):
        path = next(logfiles.bag2(tmp_path / "dive", make == "mcap").glob(f"*.{make}"))
    elif make in ("bag", "lz4"):
        logfiles.bag(path, {"bag": "", "lz4": "LZ4"}[make])
    else:
        getattr(logfiles, make)(path)
    whole, rng = path.read_bytes(), np.random.default_rng(5)
    for _ in range(15):
        data = bytearray(whole)
        for place in rng.integers(len(data), size=10).tolist() + rng.integers(400, size=3).tolist():
            data[place : place + int(rng.integers(0, 5))] = rng.bytes(int(rng.integers(0, 5)))
        path.write_bytes(data)
        try:
            str(import_log(path))
        except InputError as error:
            assert str(path) in str(error)


@pytest.mark.parametrize("make", ["tlog", "dataflash", "ulog", "bag", "mcap", "table"])
def test_blank_gigabytes_at_the_end_are_passed_over(make: str, tmp_path: Path) -> None:
    path = tmp_path / "dive.log"
    if make == "mcap":
        path = next(logfiles.bag2(tmp_path / "dive", True).glob("*.mcap"))
    elif make == "table":
        path.write_text(
            "t,depth_m\n" + "".join(f"{t:.1f},{d:.6f}\n" for t, d in zip(TIME_S, logfiles.DEPTH_M, strict=True))
        )
    else:
        getattr(logfiles, make)(path)
    with path.open("r+b") as file:
        file.truncate(2**28)
    check(import_log(path).run, ("depth_m",))


def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    import os

    os.mkfifo(tmp_path / "pipe.BIN")
    for name in ("pipe.BIN", "no\0path"):
        with pytest.raises(InputError, match="pipe.BIN: is a pipe|not a path"):
            import_log(tmp_path / name)


def test_a_head_that_leads_back_to_itself_ends(tmp_path: Path) -> None:
    path = tmp_path / "dive.ulg"
    path.write_bytes(b"ULog\x01\x12\x35\x01" + bytes(8) + b"\x03\x00\x00\x01\x02")
    with pytest.raises(InputError, match="dive.ulg"):
        import_log(path)
