"""`vtank import` and what a vehicle file says of a recording."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import logfiles
import numpy as np
import pytest

from vtank.cli import main
from vtank.errors import InputError
from vtank.experiment import fly_vehicle
from vtank.plant.recorded import check_recorded
from vtank.plant.vehicle import load_vehicle
from vtank.record import Run, read_dataset, read_run
from vtank.rigid.recordings import record


def test_import_writes_a_run_and_prints_the_preview(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = logfiles.dataflash(tmp_path / "dive.BIN")
    assert main(["import", str(log), "--out", str(tmp_path / "dive.csv"), "--vehicle", "kingfisher"]) == 0
    logfiles.check(read_run(tmp_path / "dive.csv"), ("depth_m", "heading_rad"), 2e-4)
    assert "port_command" in capsys.readouterr().out


def test_preview_writes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = logfiles.ulog(tmp_path / "dive.ulg")
    assert main(["import", str(log), "--preview"]) == 0
    assert "thruster_1_command" in capsys.readouterr().out and list(tmp_path.iterdir()) == [log]


def test_the_log_itself_is_never_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "dive.csv"
    log.write_text("t;depth_m\n" + "".join(f"{k};{k}\n" for k in range(20)))
    before = log.read_bytes()
    assert main(["import", str(log), "--out", str(log)]) == 2
    assert "dive.csv: is or holds the input" in capsys.readouterr().err and log.read_bytes() == before


def test_logs_are_runs_of_their_own_in_a_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, off in (("one", 0), ("two", 5)):
        lines = ["ms;Propeller (rpm);Distance to wall (cm)", *(f"{100 * k};{60 * k};{300 + off}" for k in range(40))]
        Path(f"{name}.csv").write_text("\n".join(lines))
    assert main(["import", "one.csv", "two.csv", "--out", "dives"]) == 0
    said = capsys.readouterr().out
    assert "one: table in text" in said and "two: table in text" in said
    assert [run.name for run in read_dataset(Path("dives"))] == ["one", "two"]
    assert list(read_dataset(Path("dives")))[1].columns["range_m"][0] == 3.05
    assert main(["import", "one.csv", "./one.csv", "--out", "dives"]) == 2
    assert "named twice" in capsys.readouterr().err
    assert main(["import", "one.csv", "two.csv", "--out", "both.csv"]) == 0  # parts of one recording


def test_a_log_without_a_vehicles_channel_names_what_there_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "log.csv").write_text("t;temperature [degC]\n" + "".join(f"{k};{k}\n" for k in range(20)))
    assert main(["import", str(tmp_path / "log.csv"), "--preview"]) == 2
    assert "no channel of a vehicle found" in capsys.readouterr().err


def test_a_recording_of_another_vehicle_is_refused_with_the_nearest(tmp_path: Path) -> None:
    t = np.arange(20.0)
    vehicle = load_vehicle("kingfisher")
    check_recorded(fly_vehicle(vehicle, {"time_s": [0.0], "port_command": [0.5]}, 5.0), vehicle)
    check_recorded(Run("run", t, {"port_A": t, "surge_m_s": t, "starboard_command": t}), vehicle)
    for column, said in {
        "dvl.surge_m_s": "has no sensor 'dvl'; there are: gps, compass, imu",
        "gps.heave_m_s": "sensor.gps of .*kingfisher.toml has no channel 'heave_m_s'",
        "prt_command": "has no thruster or fin 'prt'; did you mean 'port'",
        "port_rev_s": ".*knows its force from port_command, by gain or curve; found port_rev_s alone",
    }.items():
        with pytest.raises(InputError, match=f"run run, column {column}: .*{said}"):
            check_recorded(Run("run", t, {column: t}), vehicle)


def test_check_data_holds_runs_against_a_vehicle(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "run.csv").write_text("time_s,dvl.surge_m_s\n" + "".join(f"{k},1\n" for k in range(20)))
    assert main(["check-data", str(tmp_path / "run.csv")]) == 0
    assert "no actuator channel" in capsys.readouterr().out
    assert main(["check-data", str(tmp_path / "run.csv"), "--vehicle", "kingfisher"]) == 2
    assert "no sensor 'dvl'" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="Linux tells the peak of a program by itself")
def test_an_hour_at_50_hz_with_30_channels_stays_below_1_gb(tmp_path: Path) -> None:
    rows = 50 * 3600
    names = ["time_s", *(f"thruster_{k}_command" for k in range(1, 9)), *(f"s{k}.depth_m" for k in range(1, 23))]
    with (tmp_path / "hour.csv").open("w") as file:
        file.write(",".join(names) + "\n")
        values = ",".join(["0.123456"] * 30)
        file.writelines(f"{0.02 * k:.2f},{values}\n" for k in range(rows))
    code = (
        "import sys; from vtank.cli import main; main(sys.argv[1:]); "
        "print(open('/proc/self/status').read().partition('VmHWM:')[2].split()[0])"
    )
    for command in (["import", "hour.csv", "--out", "run.csv"], ["check-data", "run.csv"]):
        done = subprocess.run(
            [sys.executable, "-c", code, *command], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        peak_kB = int(done.stdout.split()[-1])  # getrusage's would be the parent's, too
        assert peak_kB < 1e6, command


def test_a_diagnosis_refuses_a_misspelt_thruster_and_tells_of_a_strange_sensor() -> None:
    """A thruster whose column is misspelt would else be called dead."""
    vehicle = load_vehicle("kingfisher")
    run = fly_vehicle(vehicle, {"time_s": [0.0], "port_command": [0.5], "starboard_command": [0.4]}, 5.0)
    columns = dict(run.columns)
    _, _, notes = record([run], vehicle)
    assert not any("sensor" in note for note in notes)
    renamed = {name.replace("gps.", "gsp."): values for name, values in columns.items()}
    _, _, notes = record([Run("run", run.time_s, renamed)], vehicle)
    assert any("has no sensor 'gsp'; did you mean 'gps'" in note for note in notes)
    columns["prt_command"] = columns.pop("port_command")
    with pytest.raises(InputError, match="column prt_command: .*no thruster or fin 'prt'; did you mean 'port'"):
        record([Run("run", run.time_s, columns)], vehicle)


def test_where_one_of_several_is_no_run_nothing_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, rows in (("good", 40), ("short", 5)):
        lines = ["time_s,n_rev_s,range_m", *(f"{0.1 * k:.1f},{k % 7},3.0" for k in range(rows))]
        (tmp_path / f"{name}.csv").write_text("\n".join(lines) + "\n")
    logs = [str(tmp_path / f"{name}.csv") for name in ("good", "short")]
    assert main(["import", *logs, "--out", str(tmp_path / "dives")]) == 2
    assert "run short: 5 samples of range_m" in capsys.readouterr().err and not (tmp_path / "dives").exists()
