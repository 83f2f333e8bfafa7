"""Logs made to fill the memory, to have no end, or to be no number where one is expected: read or refused at once."""

from __future__ import annotations

import bz2
import os
import sqlite3
import struct
from collections.abc import Iterable
from pathlib import Path

import logfiles
import lz4.frame
import numpy as np
import pytest
import zstandard

from vtank.errors import InputError
from vtank.logs import import_log, importing, records

BOTH = """
[[channel]]
message = "/t"
field = "rpm"
column = "n_rev_s"

[[channel]]
message = "/t"
field = "r"
column = "range_m"
"""
FLOAT = '[[channel]]\nmessage = "/t"\nfield = "data"\ncolumn = "depth_m"\n'
TABLES = (
    "create table topics(id, name, type, serialization_format); create table messages(topic_id, timestamp, data);"
    "insert into topics values(1, '/t', 'std_msgs/msg/Float64', 'cdr');"
)
ENDLESS = "with recursive c(x) as (select 1 union all select x + 1 from c) select"


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


# MCAP


def record(kind: int, data: bytes) -> bytes:
    return bytes([kind]) + struct.pack("<Q", len(data)) + data


def text(data: str | bytes) -> bytes:
    data = data.encode() if isinstance(data, str) else data
    return struct.pack("<I", len(data)) + data


def channel(encoding: str = "json") -> bytes:
    return record(4, struct.pack("<HH", 1, 0) + text("/t") + text(encoding) + text(""))


def message(k: int, data: str) -> bytes:
    return record(5, struct.pack("<HIQQ", 1, 0, *[int(1.7e18) + k * 10**8] * 2) + data.encode())


def chunk(data: bytes, method: str = "") -> bytes:
    return record(6, struct.pack("<QQQI", 0, 0, len(data), 0) + text(method) + text(b"")[:4] + bytes(4) + data)


GOOD = channel() + b"".join(message(k, f'{{"rpm": {k}, "r": 3.{k}}}') for k in range(50))


def mcap(folder: Path, *parts: bytes) -> tuple[Path, Path]:
    """A log and its mapping file."""
    (folder / "dive.mcap").write_bytes(b"\x89MCAP0\r\n" + b"".join(parts))
    (folder / "map.toml").write_text(BOTH)
    return folder / "dive.mcap", folder / "map.toml"


@pytest.mark.parametrize("kind, data", [(4, b"\x01"), (5, b"\x01\x00")])
def test_records_that_are_too_short_are_counted(kind: int, data: bytes, tmp_path: Path) -> None:
    path, mapping = mcap(tmp_path, record(kind, data), GOOD, chunk(record(kind, data)))
    found = import_log(path, mapping=mapping)
    assert "2 could not be decoded: 2 of record (too short)" in str(found) and found.run.time_s.size == 50


def test_a_chunk_within_a_chunk_is_counted(tmp_path: Path) -> None:
    inner = GOOD
    for _ in range(3000):
        inner = chunk(inner)
    path, mapping = mcap(tmp_path, GOOD, inner)
    assert "1 of chunk (within a chunk)" in str(import_log(path, mapping=mapping))


def test_a_number_beyond_all_is_none(tmp_path: Path) -> None:
    path, mapping = mcap(tmp_path, GOOD, message(99, '{"rpm": 1' + "0" * 400 + ', "r": 1}'))
    run = import_log(path, mapping=mapping).run
    assert run.samples("n_rev_s")[0].size == 50 and run.samples("range_m")[0].size == 51
    path, mapping = mcap(tmp_path, channel(), *[message(k, '{"rpm": 1' + "0" * 400 + ', "r": 1}') for k in range(9)])
    with pytest.raises(InputError, match=r"map.toml: '/t' has no number in rpm in any of its 9 messages"):
        import_log(path, mapping=mapping)


def packed(data: bytes, method: str) -> bytes:
    return {"bz2": bz2.compress, "lz4": lz4.frame.compress, "zstd": zstandard.compress}[method](data)


@pytest.mark.parametrize("method", ["bz2", "lz4", "zstd"])
def test_a_chunk_holds_no_more_than_is_stated(method: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One alone, and all together: later ones are not opened any more."""
    large = chunk(packed(GOOD + bytes(10**6), method), method)
    path, mapping = mcap(tmp_path, GOOD, chunk(packed(GOOD, method), method), large)
    monkeypatch.setattr(records, "CHUNK_BYTES", 10**5)
    monkeypatch.setattr(records, "TIMES", 0)
    found = import_log(path, mapping=mapping)
    assert "1 of chunk (holds too much" in str(found) and found.log.streams["/t"].count == 100
    path, mapping = mcap(tmp_path, GOOD, *[chunk(packed(GOOD, method), method)] * 40)
    found = import_log(path, mapping=mapping)
    opened = 10**5 // len(GOOD)
    assert found.log.undecoded["chunk"] == 40 - opened and found.log.streams["/t"].count == 50 * (opened + 1)


def test_a_record_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    path, mapping = mcap(tmp_path, GOOD, bytes([5]) + struct.pack("<Q", 2**30))
    with path.open("r+b") as file:
        file.truncate(2**30 + 10**4)
    said = "cut off: a record of 1024 MB, expected 256 MB at most"
    assert said in str(import_log(path, mapping=mapping))


@pytest.mark.parametrize("spoilt, why", [("protobuf", "encoding 'protobuf' is not known"), ("json", "not json as exp")])
def test_messages_that_could_not_be_decoded_are_told_and_why(spoilt: str, why: str, tmp_path: Path) -> None:
    path, mapping = mcap(tmp_path, channel(spoilt), *[message(k, "{") for k in range(9)])
    with pytest.raises(InputError, match=rf"map.toml: no message '/t' could be decoded, 9 in all \({why}"):
        import_log(path, mapping=mapping)
    path, _ = mcap(tmp_path, chunk(GOOD, "own"))
    said = "1 could not be decoded: 1 of chunk .compression 'own' is not known"
    with pytest.raises(InputError, match=f"no channel of a vehicle .*; {said}"):
        import_log(path)


def test_a_stamp_that_is_no_time_gives_way_to_that_of_receipt(tmp_path: Path) -> None:
    """By a definition of the log's own, whose stamp is a text."""
    definition = "Head header\nfloat64 rpm\nfloat64 r\n" + "=" * 80 + "\nMSG: a/Head\nstring stamp\n"
    schema = record(3, struct.pack("<H", 1) + text("a/msg/B") + text("ros2msg") + text(definition))
    topic = record(4, struct.pack("<HH", 1, 1) + text("/t") + text("cdr") + text(""))
    sent = [struct.pack("<HIQQ", 1, 0, *[int(1.7e18) + k * 10**8] * 2) + b"\0\1\0\0" for k in range(50)]
    body = [struct.pack("<I4sdd", 3, b"ab\0", k, 3.0) for k in range(50)]
    path, mapping = mcap(tmp_path, schema, topic, *[record(5, a + b) for a, b in zip(sent, body, strict=True)])
    time_s, values = import_log(path, mapping=mapping).run.samples("n_rev_s")
    assert np.allclose(time_s, 0.1 * np.arange(50), atol=1e-5) and np.array_equal(values, np.arange(50))


# ROS 2 in SQLite


def base(path: Path, script: str = TABLES, rows: Iterable[tuple[object, ...]] = ()) -> Path:
    """A database of a bag, and good messages in it."""
    with sqlite3.connect(path) as made:
        made.executescript(script)
        if rows:
            made.executemany("insert into messages values(?, ?, ?)", rows)
    made.close()
    return path


def good() -> list[tuple[object, ...]]:
    return [(1, int(1.7e18) + k * 10**8, b"\0\1\0\0" + struct.pack("<d", k / 10)) for k in range(50)]


@pytest.fixture()
def depths(tmp_path: Path) -> Path:
    """A mapping file of the messages of `good`."""
    (tmp_path / "map.toml").write_text(FLOAT)
    return tmp_path / "map.toml"


@pytest.mark.parametrize("time", ["abc", None, 1.5])
def test_times_of_a_base_that_are_no_whole_numbers_are_counted(time: object, depths: Path, tmp_path: Path) -> None:
    path = base(tmp_path / "dive.db3", TABLES, [*good(), (1, time, b"")])
    assert "1 of /t (its time is no whole number)" in str(import_log(path, mapping=depths))


@pytest.mark.parametrize("name", ["null", "x'ff00'", "5"])
def test_topics_without_a_name_are_counted(name: str, depths: Path, tmp_path: Path) -> None:
    script = TABLES + f"insert into topics values(2, {name}, 'b', 'cdr');"
    script += "create table message_definitions(topic_type, encoding, encoded_message_definition);"
    script += "insert into message_definitions values(null, 5, x'00');"
    path = base(tmp_path / "dive.db3", script, [*good(), (2, 5, b"")])
    assert "1 of topic 2 (its name, type or format is no text)" in str(import_log(path, mapping=depths))


@pytest.mark.parametrize(
    "script",
    [
        f"create table messages(topic_id, timestamp, data); create view topics as {ENDLESS} x as id, '/t' as name, "
        "'a' as type, 'cdr' as serialization_format from c;",
        "create table topics(id, name, type, serialization_format); "
        f"create view messages as {ENDLESS} 1 as topic_id, x as timestamp, x'00' as data from c;",
        "create table topics(id, name, type, serialization_format); "
        "create virtual table messages using fts5(topic_id, timestamp, data);",
    ],
)
def test_only_tables_are_read(script: str, depths: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="dive.db3: a ROS 2 bag without a table '(topics|messages)', expected"):
        import_log(base(tmp_path / "dive.db3", script), mapping=depths)


def test_pages_that_are_read_many_times_have_an_end(depths: Path, tmp_path: Path) -> None:
    """The root of the messages leads to one page only, which leads to one page only: 400,000 rows of 2,000."""
    depths.write_text(FLOAT.replace("data", "pose.position.z"))
    tables = TABLES.replace("std_msgs/msg/Float64", "geometry_msgs/msg/PoseWithCovariance")
    path = base(tmp_path / "dive.db3", tables, [(1, k, b"\0\1\0\0" + bytes(43 * 8)) for k in range(2000)])
    with sqlite3.connect(path) as made:
        (root,) = made.execute("select rootpage from sqlite_master where name = 'messages'").fetchone()
        (size,) = made.execute("pragma page_size").fetchone()
    made.close()
    data = bytearray(path.read_bytes())
    page = data[(root - 1) * size : root * size]
    (cells,) = struct.unpack(">H", page[3:5])
    assert page[0] == 5 and cells > 100  # within the tree, without rows of its own
    places = [8, *struct.unpack(f">{cells}H", page[12 : 12 + 2 * cells])]
    one, two = (struct.unpack(">I", page[place : place + 4])[0] for place in places[1:3])
    for number, leads_to in ((root, one), (one, two)):
        for place in places:
            page[place : place + 4] = struct.pack(">I", leads_to)
        data[(number - 1) * size : number * size] = page
    path.write_bytes(data)
    assert "more messages than its file can hold" in str(import_log(path, mapping=depths))


@pytest.mark.parametrize("name", ["dive#1.db3", "dive?1.db3", "dive%41.db3", "d ä\n.db3"])
def test_a_base_may_have_any_name_and_nothing_is_written(name: str, depths: Path, tmp_path: Path) -> None:
    path = base(tmp_path / "bag.db3", TABLES, good()).rename(tmp_path / name)
    before = sorted(tmp_path.iterdir())
    assert import_log(path, mapping=depths).run.time_s.size == 50
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("name", ["x.db3", "x.mcap"])
def test_only_regular_files_of_a_bag_are_read(name: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / name)
    with pytest.raises(InputError, match=f"{name}: is a pipe"):
        import_log(tmp_path)


# PX4


def ulog(path: Path, forms: Iterable[str], times: int = 1) -> Path:
    """A log that says that it has the first message, and how it is made."""

    def part(kind: bytes, content: bytes) -> bytes:
        return struct.pack("<HB", len(content), kind[0]) + content

    parts = [b"ULog\x01\x12\x35\x01" + bytes(8), *[part(b"F", form.encode()) for form in forms]]
    parts += [part(b"A", struct.pack("<BH", 0, k) + b"vehicle_attitude") for k in range(times)]
    path.write_bytes(b"".join(parts))
    return path


@pytest.mark.parametrize(
    "types",
    [
        ["m0[1000] q;", "m0:m1[1000] a;", "m1:m2[1000] a;", "m2:float a;"],
        ["m0[1000] q;", "m0:m1[1000] a;", "m1:m2[1000] a;", "m2:"],
        ["m0[1000] q;", "m0:m1[1000] a;", "m1:float[60000] a;", "m1:float a;"],
        ["m0[60000x q;", "m0:m1[60000x a;", "m1:float a;"],
    ],
)
def test_types_within_types_are_counted_before_they_are_taken_apart(types: list[str], tmp_path: Path) -> None:
    forms = [f"vehicle_attitude:uint64_t timestamp;{types[0]}", *types[1:]]
    with pytest.raises(InputError, match=r"dive.ulg: .*\(its messages have more than 262,144 fields\)"):
        import_log(ulog(tmp_path / "dive.ulg", forms))


def test_messages_are_counted_together(tmp_path: Path) -> None:
    path = ulog(tmp_path / "dive.ulg", ["vehicle_attitude:uint64_t timestamp;float[60000] q;"], 200)
    with pytest.raises(InputError, match="more than 262,144 fields"):
        import_log(path)


def test_damage_that_looks_like_messages_of_no_type_counts_for_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vtank.logs.ulog.MOST_FIELDS", 50)
    path = logfiles.ulog(tmp_path / "dive.ulg")
    path.write_bytes(path.read_bytes() + (struct.pack("<HBBH", 4, ord("A"), 0, 9) + b"x") * 100)
    logfiles.check(import_log(path).run)


def test_a_parameter_of_a_log_that_is_no_number_is_left_out_and_told(tmp_path: Path) -> None:
    path = logfiles.ulog(tmp_path / "dive.ulg")
    named = b"float PWM_MAIN_FUNC1"
    told = struct.pack("<HB", len(named) + 5, ord("P")) + bytes([len(named)]) + named + struct.pack("<f", np.nan)
    path.write_bytes(path.read_bytes()[:16] + told + path.read_bytes()[16:])
    found = import_log(path)
    assert "1 of parameter PWM_MAIN_FUNC1 (no number)" in str(found)
    logfiles.check(found.run)


# Sizes of files


@pytest.mark.parametrize("head", [b"\xa3\x95\x80", b"ULog\x01\x12\x35", bytes(8) + b"\xfd" + bytes(9), b"t,depth_m\n"])
def test_a_log_that_is_too_long_is_refused_at_once(head: bytes, tmp_path: Path) -> None:
    (tmp_path / "dive.log").write_bytes(head)
    os.truncate(tmp_path / "dive.log", importing.LOG_BYTES + 2**20)
    with pytest.raises(InputError, match=r"dive.log: holds 4,097 MB, expected 4,096 MB at most; split it"):
        import_log(tmp_path / "dive.log")
