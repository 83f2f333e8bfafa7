"""Logs made to fill the memory, to have no end, or to be no number where one is expected: read or refused at once."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from vtank.errors import InputError
from vtank.logs import import_log, importing

# Dataflash: messages by their description


def dataflash(path: Path, forms: Iterable[tuple[str, str, str, str]], lines: Iterable[tuple[object, ...]]) -> Path:
    """`forms`: name, letters, columns and struct; `lines`: number of the form from 1 on, and values."""
    packers, parts = {}, []
    for number, (name, letters, columns, packed) in enumerate(forms, 1):
        packers[number] = struct.Struct("<" + packed)
        head = number, packers[number].size + 3, name.encode(), letters.encode(), columns.encode()
        parts.append(b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", *head))
    parts += [b"\xa3\x95" + bytes([line[0]]) + packers[line[0]].pack(*line[1:]) for line in lines]  # type: ignore[index]
    path.write_bytes(b"".join(parts))
    return path


def attitude(number: int) -> list[tuple[object, ...]]:
    return [(number, 100_000 * k + 5, 1, 2, 3 * k) for k in range(50)]


ATT = ("ATT", "Qccc", "TimeUS,Roll,Pitch,Yaw", "Qhhh")


@pytest.mark.parametrize(
    "letters, packed, value, said",
    [
        ("QNN", "Q16s16s", b"xyz", "1 of parameter SERVO1_FUNCTION (no number)"),
        ("QNf", "Q16sf", float("nan"), "1 of parameter SERVO1_FUNCTION (no number)"),
        ("QNf", "Q16sf", float("inf"), "1 of parameter SERVO1_FUNCTION (no number)"),
    ],
)
def test_a_parameter_that_is_no_number_is_left_out_and_told(
    letters: str, packed: str, value: object, said: str, tmp_path: Path
) -> None:
    forms = [("PARM", letters, "TimeUS,Name,Value", packed), ATT, ("RCOU", "QHH", "TimeUS,C1,C2", "QHH")]
    outputs = [(3, 100_000 * k + 5, 1500 + k, 1500 - k) for k in range(50)]
    path = dataflash(tmp_path / "dive.BIN", forms, [(1, 5, b"SERVO1_FUNCTION", value), *attitude(2), *outputs])
    found = import_log(path)
    assert said in str(found) and "thruster_1_command" in found.run.columns


@pytest.mark.parametrize("field", ["TimeUS", "TimeMS"])
@pytest.mark.parametrize("letters, packed, time", [("Nc", "16sh", b"A"), ("ac", "64sh", b"A"), ("dc", "dh", np.nan)])
def test_a_time_that_is_no_number_is_counted(
    field: str, letters: str, packed: str, time: object, tmp_path: Path
) -> None:
    forms = [ATT, ("BAT", letters, f"{field},Volt", packed)]
    found = import_log(dataflash(tmp_path / "dive.BIN", forms, [*attitude(1), (2, time, 5)]))
    assert "1 could not be decoded: 1 of BAT (its time is no number)" in str(found)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_parameter_of_telemetry_that_is_no_number_is_left_out_and_told(value: float, tmp_path: Path) -> None:
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    vehicle = dialect.MAVLink(None, 1, 1)
    told = [dialect.MAVLink_param_value_message(b"SERVO1_FUNCTION", value, 9, 1, 0)]
    for k in range(50):
        told.append(dialect.MAVLink_attitude_message(500_000 + 100 * k, 0.1, 0.0, 0.01 * k, 0.0, 0.0, 0.0))
        pulses = [1500 + k, 1500 - k, *[1500] * 14]
        told.append(dialect.MAVLink_servo_output_raw_message(1000 * (500_000 + 100 * k), 0, *pulses))
    stamped = [struct.pack(">Q", 10**9 + 50_000 * k) + each.pack(vehicle) for k, each in enumerate(told)]
    (tmp_path / "dive.tlog").write_bytes(b"".join(stamped))
    found = import_log(tmp_path / "dive.tlog")
    assert "parameter SERVO1_FUNCTION (no number)" in str(found) and "thruster_1_command" in found.run.columns


# Sizes of files


@pytest.mark.parametrize("head", [b"\xa3\x95\x80", b"ULog\x01\x12\x35", bytes(8) + b"\xfd" + bytes(9), b"t,depth_m\n"])
def test_a_log_that_is_too_long_is_refused_at_once(head: bytes, tmp_path: Path) -> None:
    (tmp_path / "dive.log").write_bytes(head)
    os.truncate(tmp_path / "dive.log", importing.LOG_BYTES + 2**20)
    with pytest.raises(InputError, match=r"dive.log: holds 4,097 MB, expected 4,096 MB at most; split it"):
        import_log(tmp_path / "dive.log")
