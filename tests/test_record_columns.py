"""Recordings of whole vehicles: which columns are known, in which unit, and what is said of a slip."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vtank.cli import main
from vtank.errors import InputError
from vtank.record import Run, column, read_run, write_run

TIME = np.arange(20) * 0.1


def recorded(tmp_path: Path, **columns: float) -> Path:
    path = tmp_path / "dive.csv"
    lines = [",".join(["time_s", *columns])]
    lines += [",".join(f"{cell:g}" for cell in (t, *columns.values())) for t in TIME]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("name", "unit", "role"),
    [
        ("bow_port_rev_s", "rev/s", "input"),
        ("bow_port_command", "-", "input"),
        ("bow_port_N", "N", "input"),
        ("rudder_rad", "rad", "input"),
        ("yaw_Nm", "N m", "input"),
        ("heading_rad", "rad", "output"),
        ("dvl.surge_m_s", "m/s", "output"),
        ("accel_z_m_s2", "m/s2", "output"),
        ("battery_V", "V", "state"),
        ("bow_port_A", "A", "state"),
    ],
)
def test_columns_have_unit_and_role(name: str, unit: str, role: str) -> None:
    found = column(name)
    assert found and (found.unit, found.role) == (unit, role)


def test_a_whole_vehicle_is_read_and_written_and_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns = {"bow_port_command": 0.5, "rudder_rad": 0.1, "dvl.surge_m_s": 0.4, "heading_rad": 8.0}
    run = read_run(recorded(tmp_path, **columns))
    assert list(run.columns) == list(columns) and run.outputs == ()
    write_run(tmp_path / "again.csv", run)
    assert main(["check-data", str(tmp_path / "again.csv")]) == 0
    told = capsys.readouterr().out
    assert all(name in told for name in columns) and "input" in told and "output" in told


def test_motion_alone_is_a_recording(tmp_path: Path) -> None:
    assert read_run(recorded(tmp_path, roll_rad=0.1, pitch_rad=0.0)).time_s.size == 20


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"bow_port_command": 0.0, "headng_rad": 0.0}, "column 'headng_rad'; did you mean 'heading_rad'?"),
        ({"bow_port_comand": 0.0, "heading_rad": 0.0}, "column 'bow_port_comand'; did you mean 'bow_port_command'?"),
        ({"bow_port_N": 0.0, "dvl.surge_ms": 0.0}, "column 'dvl.surge_ms'; did you mean 'dvl.surge_m_s'?"),
        ({"bow_port_command": 1.5, "surge_m_s": 0.0}, "line 2: column bow_port_command: found 1.5, expected a number"),
        ({"bow_port_N": 1.5, "pitch_rad": 12.0}, "line 2: column pitch_rad: found 12, .*are these degrees"),
        ({"bow_port_N": 1.5, "ping.range_m": -1.0}, "line 2: column ping.range_m: found -1, expected a distance"),
    ],
)
def test_a_slip_is_told_with_what_was_meant(tmp_path: Path, columns: dict[str, float], said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_run(recorded(tmp_path, **columns))


def test_in_a_single_axis_run_other_columns_are_still_passed_over(tmp_path: Path) -> None:
    run = read_run(recorded(tmp_path, n_rev_s=1.0, range_m=3.0, headng_rad=0.0, roll_rad=99.0, rpm=3.0))
    assert run.input == "n_rev_s" and run.outputs == ("range_m",)


def test_what_fits_a_surge_model_is_refused_a_whole_vehicle_kindly() -> None:
    with pytest.raises(InputError, match="no input column, expected one of n_rev_s.*bow_port_N is of a whole vehicle"):
        _ = Run("dive", TIME, {"bow_port_N": TIME}).input
