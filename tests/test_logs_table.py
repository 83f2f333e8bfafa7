"""Tables in text: any separator, decimal commas, marks, units in the header, times of any kind."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from vtank.errors import InputError
from vtank.logs import import_log
from vtank.logs.header import channel, parse
from vtank.record import write_run

HEADER = ("Time [ms]", "Heading (deg)", "port rpm", "Depth [ft]", "surge_m_s", "Remarks")
ROWS = 40


def rows(comma: str = ".") -> list[list[str]]:
    """Cells of a log: 20 Hz, heading 10 deg and on, 600 rpm and more, 10 ft, speed in every other row."""
    made = []
    for k in range(ROWS):
        numbers = (f"{50 * k}", f"{10 + 0.5 * k:.2f}", f"{600 + k}", "10.0", f"{0.01 * k:.3f}" if k % 2 else "")
        made.append([each.replace(".", comma) for each in numbers] + ["ok" if k % 3 else ""])
    return made


def text(separator: str, comma: str = ".", header: tuple[str, ...] = HEADER, end: str = "\n") -> str:
    """The log as a table."""
    return end.join(separator.join(line) for line in [list(header), *rows(comma)]) + end


def check(path: Path) -> None:
    run = import_log(path).run
    assert set(run.columns) == {"heading_rad", "port_rev_s", "depth_m", "surge_m_s"}
    time_s, heading = run.samples("heading_rad")
    assert np.allclose(time_s, 0.05 * np.arange(ROWS)) and np.allclose(heading, np.radians(10 + 0.5 * np.arange(ROWS)))
    assert np.allclose(run.samples("port_rev_s")[1], (600 + np.arange(ROWS)) / 60.0)
    assert np.allclose(run.samples("depth_m")[1], 3.048)
    assert np.allclose(run.samples("surge_m_s")[0], 0.05 * np.arange(1, ROWS, 2))


@pytest.mark.parametrize("separator, comma", [(",", "."), (";", "."), (";", ","), ("\t", ","), ("|", ".")])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_every_dialect_is_the_same_run(separator: str, comma: str, encoding: str, tmp_path: Path) -> None:
    header = (*HEADER[:5], "Höhe über Grund")
    (tmp_path / "log.csv").write_bytes(text(separator, comma, header, "\r\n").encode(encoding))
    check(tmp_path / "log.csv")


def test_comments_above_and_a_row_of_units_below_the_header_are_understood(tmp_path: Path) -> None:
    lines = text(";").splitlines()
    lines[0] = "# Time;Heading;port;Depth;surge_m_s;Remarks"
    lines.insert(1, "[ms];[deg];[rpm];[ft];[m/s];")
    (tmp_path / "log.csv").write_text("% written by a logger\n\n" + "\n".join(lines))
    check(tmp_path / "log.csv")


@pytest.mark.parametrize(
    "name, cell",
    [
        ("t", lambda k: f"{0.05 * k:.2f}"),
        ("timestamp", lambda k: str(1_700_000_000_000 + 50 * k)),
        ("timestamp", lambda k: str(1_700_000_000_000_000_000 + 50_000_000 * k)),
        ("time", lambda k: str(50 * k)),
        ("time_us", lambda k: str(50_000 * k)),
        ("Time", lambda k: f"2024-05-01 10:00:{0.05 * k:06.3f}"),
        ("Time", lambda k: f"23:59:{30 + 0.05 * k:06.3f}"),
    ],
)
def test_times_of_any_kind(name: str, cell: object, tmp_path: Path) -> None:
    lines = [f"{name},depth_m", *(f"{cell(k)},{k}" for k in range(ROWS))]  # type: ignore[operator]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    assert np.allclose(import_log(tmp_path / "log.csv").run.time_s, 0.05 * np.arange(ROWS), atol=1e-5)


@pytest.mark.parametrize(
    "header, column, factor",
    [
        ("yaw_rate [°/s]", "yaw_rate_rad_s", np.radians(1.0)),
        ("yaw (deg/s)", "yaw_rate_rad_s", np.radians(1.0)),
        ("Roll [deg]", "roll_rad", np.radians(1.0)),
        ("Thruster 1 [%]", "thruster_1_command", 0.01),
        ("bow_thruster_N", "bow_thruster_N", 1.0),
        ("stern thrust [kgf]", "stern_N", 9.80665),
        ("port current (mA)", "port_A", 1e-3),
        ("rudder [deg]", "rudder_rad", np.radians(1.0)),
        ("surge speed (kn)", "surge_m_s", 1852.0 / 3600.0),
        ("Battery [mV]", "battery_V", 1e-3),
        ("az [g]", "accel_z_m_s2", 9.80665),
        ("dvl.surge_m_s", "dvl.surge_m_s", 1.0),
        ("Motor RPM", "motor_rev_s", 1.0 / 60.0),
        ("rpm", "n_rev_s", 1.0 / 60.0),
        ("surge [N]", "surge_N", 1.0),
        ("depth", "depth_m", 1.0),
        ("Surge", "surge_m_s", 1.0),
        ("Distance to wall (cm)", "range_m", 0.01),
        ("sonar range [ft]", "range_m", 0.3048),
        ("Depth below surface (m)", "depth_m", 1.0),
        ("Compass heading [deg]", "heading_rad", np.radians(1.0)),
        ("roll angle (deg)", "roll_rad", np.radians(1.0)),
        ("Propeller speed (rpm)", "propeller_rev_s", 1.0 / 60.0),
    ],
)
def test_headers_are_understood(header: str, column: str, factor: float) -> None:
    found = channel(header, "table")
    assert found is not None and found.columns == (column,) and found.factor(0) == pytest.approx(factor)


@pytest.mark.parametrize(
    "header",
    [
        "Remarks",
        "battery [%]",
        "temperature [degC]",
        "latitude",
        "x [kg]",
        "time_s",
        "Distance travelled (m)",
        "of the",
    ],
)
def test_what_is_not_understood_is_left(header: str) -> None:
    assert channel(header, "table") is None


def test_the_only_propeller_of_a_table_is_the_input_of_its_axis(tmp_path: Path) -> None:
    for other, column in (
        ("Distance to wall (cm)", "n_rev_s"),
        ("heading (deg)", "propeller_rev_s"),
        ("port rpm", "propeller_rev_s"),
    ):
        lines = [f"t,Propeller (rpm),{other}", *(f"{0.1 * k:.1f},{60 * k},{k}" for k in range(20))]
        (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
        assert column in import_log(tmp_path / "log.csv").run.columns
    named = ["t,Propeller (rpm),Distance to wall (cm)", *(f"{0.1 * k:.1f},{60 * k},{k}" for k in range(20))]
    (tmp_path / "log.csv").write_text("\n".join(named) + "\n")
    assert "propeller_rev_s" in import_log(tmp_path / "log.csv", vehicle="remus100").run.columns


def test_columns_of_a_table_that_are_not_taken_are_told(tmp_path: Path) -> None:
    lines = ["t,rpm,sonar (m),distance (m),Kurs", *(f"{0.1 * k:.1f},{k},{k},{k},{k}" for k in range(20))]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    said = "not taken: 'distance (m)', 'Kurs'; a mapping file tells what they are (--map)"
    assert said in str(import_log(tmp_path / "log.csv"))  # the second range, and a word that is not known


def test_pulse_lengths_in_a_table_become_commands(tmp_path: Path) -> None:
    lines = ["time_s,motor1_pwm,depth_m", *(f"{0.1 * k:.1f},{1500 + 10 * k},{k}" for k in range(20))]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    assert np.allclose(import_log(tmp_path / "log.csv").run.samples("motor1_command")[1], np.arange(20) / 40.0)


def test_rows_out_of_order_and_cells_that_are_no_numbers_are_told(tmp_path: Path) -> None:
    lines = ["time_s,depth_m,port_rev_s", *(f"{0.1 * k:.1f},{k},{k}" for k in range(20))]
    lines[3], lines[7] = lines[7], lines[3]
    lines[5] = "0.4,overflow,4"
    lines[9] = "0.8,8"
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n1.9,19")
    found = import_log(tmp_path / "log.csv")
    assert np.array_equal(found.run.samples("port_rev_s")[0], np.delete(np.round(0.1 * np.arange(20), 6), 8))
    assert found.log.undecoded == {"cells of 'depth_m'": 1}
    assert "1 rows are incomplete" in str(found) and "the last line is not whole" in str(found)


def test_a_clock_that_goes_back_is_told(tmp_path: Path) -> None:
    """Two recordings in one file, whose second begins at nothing again."""
    one = text(",").splitlines()
    (tmp_path / "log.csv").write_text("\n".join([*one, *one[1:]]) + "\n")
    assert any(
        "its clock goes back 1 time, by up to 1.95 s: several" in said
        for said in import_log(tmp_path / "log.csv").columns.remarks
    )


def test_a_written_run_comes_back(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(text(","))
    run = import_log(tmp_path / "log.csv").run
    write_run(tmp_path / "again.csv", run)
    again = import_log(tmp_path / "again.csv").run
    assert list(again.columns) == list(run.columns) and np.allclose(again.time_s, run.time_s)


def test_a_table_without_times_or_header_is_refused(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("depth_m,port_rev_s\n" + "1,2\n" * 5)
    with pytest.raises(InputError, match=r"log.csv: no column of times.*depth_m, port_rev_s"):
        import_log(tmp_path / "log.csv")
    (tmp_path / "log.csv").write_text("1,2,3\n" * 5)
    with pytest.raises(InputError, match="expected a header"):
        import_log(tmp_path / "log.csv")


def test_a_map_names_the_column_of_times(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("\n".join(["tick;z", *(f"{k};{-k}" for k in range(20))]) + "\n")
    (tmp_path / "map.toml").write_text(
        'time = { field = "tick", unit = "ms" }\n'
        '[[channel]]\nmessage = "table"\nfield = "z"\ncolumn = "depth_m"\nscale = -1.0\n'
    )
    run = import_log(tmp_path / "log.csv", mapping=tmp_path / "map.toml").run
    assert np.allclose(run.time_s, 1e-3 * np.arange(20)) and np.allclose(run.samples("depth_m")[1], np.arange(20))


def test_parse() -> None:
    assert parse("Heading (deg)") == ("heading", "deg")
    assert parse("Thruster 1 rpm") == ("thruster_1", "rpm")
    assert parse("surge_ft_s") == ("surge", "ft/s")
    assert parse("Depth") == ("depth", "")


def test_angles_without_a_unit_are_degrees_where_one_exceeds_a_turn(tmp_path: Path) -> None:
    for heading, word, factor in ((200.0, "degrees", np.radians(1.0)), (2.0, "radians", 1.0)):
        lines = ["t,Roll,yaw,gyro_z", *(f"{0.1 * k:.1f},{0.1 * k:.1f},{heading},{0.2 * k:.1f}" for k in range(20))]
        (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
        found = import_log(tmp_path / "log.csv")
        assert f"Roll, yaw, gyro_z: no unit, taken for {word}" in str(found)
        assert np.allclose(found.run.columns["roll_rad"], factor * 0.1 * np.arange(20))
        assert np.allclose(found.run.columns["yaw_rate_rad_s"], factor * 0.2 * np.arange(20))


@pytest.mark.parametrize("clock", [True, False])
def test_a_clock_that_passes_midnight_goes_on(clock: bool, tmp_path: Path) -> None:
    """As a time of day, and as the seconds of it."""
    seconds = [(86397.5 + 0.5 * k) % 86400.0 for k in range(20)]
    cells = [f"{int(s // 3600)}:{int(s % 3600 // 60):02d}:{s % 60:04.1f}" if clock else f"{s}" for s in seconds]
    (tmp_path / "log.csv").write_text("time;heading_rad\n" + "".join(f"{c};{k}\n" for k, c in enumerate(cells)))
    found = import_log(tmp_path / "log.csv")
    time_s, heading = found.run.samples("heading_rad")
    assert np.allclose(time_s, 0.5 * np.arange(20)) and np.allclose(heading, np.arange(20))
    assert "its clock goes back by a day 1 time: past midnight it goes on" in str(found)
    assert "several recordings in one" not in str(found)


@pytest.mark.parametrize("cell", ["1_000", "٣", "inf", "-Infinity", "1e400", "-nan"])
def test_a_cell_that_no_run_may_hold_is_no_number_and_told(cell: str, tmp_path: Path) -> None:
    lines = ["time_s,depth_m,port_rev_s", *(f"{0.1 * k:.1f},{k},{k}" for k in range(20)), f"2.0,{cell},20"]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    found = import_log(tmp_path / "log.csv")
    assert "1 could not be decoded: 1 of cells of 'depth_m'" in str(found)
    assert found.run.samples("depth_m")[0].size == 20 and found.run.samples("port_rev_s")[0].size == 21


@pytest.mark.parametrize("time", ["2_0.0", "٢.٠", "inf", "9" * 400 + ":00:00", "9" * 5000 + ":00:00", "٠:٠٠:٠٢"])
def test_a_time_that_is_none_is_told_or_refused(time: str, tmp_path: Path) -> None:
    lines = ["time,depth_m", *(f"{0.1 * k:.1f},{k}" for k in range(20)), f"{time},20"]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    assert "1 rows are incomplete or have no time: left out" in str(import_log(tmp_path / "log.csv"))
    (tmp_path / "log.csv").write_text("time,depth_m,a\n" + f"{time},1,2\n" * 20, encoding="utf-8")
    with pytest.raises(InputError, match=r"log.csv: no row is complete and has a time in column 'time'; expected"):
        import_log(tmp_path / "log.csv")


@pytest.mark.parametrize("zone", ["America/New_York", "Asia/Tokyo", "UTC"])
def test_dates_without_a_zone_are_of_utc_wherever_they_are_read(
    zone: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Over the end of summer time in New York, and in the first year of all."""
    monkeypatch.setenv("TZ", zone)
    time.tzset()
    for dates in ("2024-11-03T01:59:", "0001-01-01T00:00:"):
        lines = ["time,depth_m", *(f"{dates}{k:02d},{k}" for k in range(60)), f"{dates.replace('1:59', '2:00')}30,60"]
        (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
        found = import_log(tmp_path / "log.csv").run
        assert found.duration_s == (90.0 if "59" in dates else 59.0)
    monkeypatch.undo()
    time.tzset()


@pytest.mark.parametrize("name", ["a" + " " * 100_000 + "b", "a [" + " " * 100_000 + "b", "[" * 100_000, "a" * 100_000])
def test_a_long_header_takes_no_time(name: str) -> None:
    start = time.perf_counter()
    channel(name, "table")
    assert time.perf_counter() - start < 5.0  # minutes, where the search begins anew at each blank


def test_parse_takes_the_last_brackets() -> None:
    assert parse("a (b) [ deg ]") == ("a_b", "deg")
    assert parse("a [b] c") == ("a_b_c", "")
    assert parse("a [b)") == ("a", "b")
    assert parse("]") == ("", "")


def test_a_cell_too_long_for_csv_is_no_number(tmp_path: Path) -> None:
    long = '"' + "x" * 140_000 + '"'
    lines = ["t,depth_m,a", *(f"{k},{k},{k}" for k in range(20)), f"20,{long},20", f'21,"21","{"x" * 9}"']
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    found = import_log(tmp_path / "log.csv")
    assert "1 of cells of 'depth_m'" in str(found) and found.run.columns["depth_m"][-1] == 21.0
