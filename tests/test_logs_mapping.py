"""Mapping files: what they may say, what is refused, and that the presets are sound."""

from __future__ import annotations

from pathlib import Path

import logfiles
import numpy as np
import pytest

from vtank.errors import InputError
from vtank.logs import import_log, read_mapping
from vtank.logs.map_file import KEYS
from vtank.logs.mapping import PRESETS
from vtank.logs.units import UNITS
from vtank.record.columns import FIXED, NAMED

PULSES = '[[channel]]\nmessage = "RCOU"\nfield = "C{{n}}"\ncolumn = "thruster_{{n}}_command"\nunit = "us"\n{}\n'
CHANNEL = '[[channel]]\nmessage = "ATTITUDE"\nfield = "yaw"\ncolumn = "heading_rad"\n'


@pytest.mark.parametrize("preset", sorted(PRESETS.glob("*.toml")), ids=lambda path: path.stem)
def test_presets_are_sound(preset: Path) -> None:
    assert read_mapping(preset).preset


@pytest.mark.parametrize(
    "text, said",
    [
        ("", "expected at least one"),
        ('[[channel]]\nmessage = "A"\nfield = "x"\ncolumn = "headin_rad"\n', "did you mean 'heading_rad'"),
        (CHANNEL + 'unit = "knots"\n', "'knots' is no unit of 'heading_rad'.*deg"),
        (CHANNEL + 'colour = "red"\n', "unknown key.*colour|colour.*unknown key"),
        (CHANNEL + 'frame = "NWU"\n', "expected one of NED, ENU, FRD, FLU"),
        (CHANNEL + 'frame = "NED"\n', "expected 3 fields and 3 columns with frame 'NED', found 1 and 1"),
        (CHANNEL + 'unit = "us"\n', "pulse lengths .us. become NAME_command"),
        ('[[channel]]\nfield = "x"\ncolumn = "depth_m"\n', "message"),
        (CHANNEL + "sign = 2\n", "expected 1 or -1, found 2"),
        (CHANNEL + CHANNEL, "column 'heading_rad' is given twice"),
        (PULSES.format("outputs = 1000000000"), "outputs: expected a whole number of at least 0 and up to 64"),
        (PULSES.format("stop_us = 1500.0\nfull_us = 1500.0"), "full_us: expected another length than stop_us, 1500"),
        ('preset = "rso"\n' + CHANNEL, "preset: expected one of ardusub-bin, .*, ros, header; found 'rso'"),
        ('several = 1\n' + CHANNEL, "several: expected true or false"),
        ('time = { field = "t", unit = "h" }\n' + CHANNEL, "'h' is no unit of time"),
    ],
)  # fmt: skip
def test_faults_of_a_mapping_name_file_and_key(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text(text)
    with pytest.raises(InputError, match=f"map.toml.*({said})"):
        read_mapping(tmp_path / "map.toml")


@pytest.mark.parametrize(
    "old, new, said",
    [
        ("ATTITUDE", "ATITUDE", "the log has no message 'ATITUDE'; did you mean 'ATTITUDE'"),
        ('"yaw"', '"yav"', "'ATTITUDE' has no number yav; did you mean 'yaw'.*rollspeed"),
    ],
)
def test_what_the_log_has_not_is_refused_with_the_nearest(old: str, new: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text(CHANNEL.replace(old, new))
    with pytest.raises(InputError, match=f"map.toml: {said}"):
        import_log(logfiles.tlog(tmp_path / "dive.tlog"), mapping=tmp_path / "map.toml")


def test_unit_scale_and_offset(tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text(CHANNEL + 'unit = "deg"\nsign = -1\noffset = 0.5\n')
    run = import_log(logfiles.tlog(tmp_path / "dive.tlog"), mapping=tmp_path / "map.toml").run
    assert np.allclose(run.columns["heading_rad"], 0.5 - np.radians(logfiles.HEADING_RAD), atol=1e-6)


def test_quaternions_that_are_none_are_left_out_and_told(tmp_path: Path) -> None:
    path = logfiles.ulog(tmp_path / "dive.ulg")
    mapping = (PRESETS / "px4.toml").read_text().replace('"q[3]"]', '"q[2]"]')
    parts = mapping.split("\n\n")
    (tmp_path / "map.toml").write_text(next(part for part in parts if "q[0]" in part))
    assert "are not of length 1" in str(import_log(path, mapping=tmp_path / "map.toml"))


def test_thrusters_are_called_as_in_the_vehicle_file(tmp_path: Path) -> None:
    run = import_log(logfiles.tlog(tmp_path / "dive.tlog"), vehicle="kingfisher").run
    assert np.allclose(run.samples("port_command")[1], logfiles.COMMAND, atol=1e-6)
    other = import_log(tmp_path / "dive.tlog", vehicle="phoenix")
    assert "knows its force from tunnel_bow_vertical_rev_s, by gain or curve" in str(other)
    with pytest.raises(InputError, match=r"remus100.toml: has 1 thrusters, the log has motor 2"):
        import_log(tmp_path / "dive.tlog", vehicle="remus100")


def test_every_unit_of_a_column_is_known() -> None:
    assert {column.unit for column in (*FIXED.values(), *NAMED.values())} <= UNITS.keys()


def test_latitude_and_longitude_become_metres(tmp_path: Path) -> None:
    lines = ["time_s,lat,lon", *(f"{0.1 * k:.1f},{59.0 + 1e-5 * k:.7f},{10.0 + 2e-5 * k:.7f}" for k in range(20))]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "map.toml").write_text(
        '[[channel]]\nmessage = "table"\nfields = ["lat", "lon"]\ncolumns = ["north_m", "east_m"]\nframe = "WGS84"\n'
    )
    run = import_log(tmp_path / "log.csv", mapping=tmp_path / "map.toml").run
    arc_second = 30.94  # [m] of latitude at 59 deg north, from tables of the ellipsoid
    assert run.columns["north_m"][-1] == pytest.approx(3600 * 1e-5 * 19 * arc_second, rel=1e-3)
    assert run.columns["east_m"][-1] == pytest.approx(2e-5 * 19 * 57_476.0, rel=1e-3)  # 57.476 km a degree at 59 deg


def test_the_howto_names_every_key_of_a_channel() -> None:
    text = (Path(__file__).parents[1] / "models" / "HOWTO.md").read_text(encoding="utf-8")
    rare = {"one_way", "parameters", "motor_function", "instance"}  # of autopilots, whose presets show them
    assert not [key for key in set(KEYS) - rare if f"`{key}`" not in text]


def test_the_header_of_a_table_gives_what_the_channels_do_not(tmp_path: Path) -> None:
    lines = ["Time [s];Heading;Depth [ft];drive", *(f"{k / 10};{k};10;{60 * k}" for k in range(20))]
    (tmp_path / "log.csv").write_text("\n".join(lines))
    own = '[[channel]]\nmessage = "table"\nfield = "drive"\ncolumn = "port_rev_s"\nunit = "rpm"\n'
    (tmp_path / "map.toml").write_text('preset = "header"\n' + own)
    run = import_log(tmp_path / "log.csv", mapping=tmp_path / "map.toml").run
    assert set(run.columns) == {"port_rev_s", "heading_rad", "depth_m"}
    assert np.allclose(run.samples("depth_m")[1], 3.048) and np.allclose(run.samples("port_rev_s")[1], np.arange(20))
    assert np.allclose(run.samples("heading_rad")[1], np.radians(np.arange(20)))  # taken for degrees, as without a map
    logfiles.dataflash(tmp_path / "dive.BIN")
    with pytest.raises(InputError, match=r"map.toml: preset: 'header' is that of tables in text, and .*\(dataflash\)"):
        import_log(tmp_path / "dive.BIN", mapping=tmp_path / "map.toml")
