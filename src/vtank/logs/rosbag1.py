"""Bags of ROS 1 (*.bag), read from the front without their index, which a bag that was cut off has not."""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from .log import Log
from .records import Chunks, CutOff, read_up_to
from .ros import Messages, type_name

HEAD = b"#ROSBAG V2.0\n"
MESSAGE, CHUNK, CONNECTION = b"\x02", b"\x05", b"\x07"  # what a record is, in its field `op`


def read(path: Path, log: Log) -> None:
    """Read a bag; messages of one topic come in the order in which they were recorded. InputError without rosbags."""
    log.kind = "ROS 1 bag"
    taken = Messages(log, f"{path}: a ROS bag")
    topics: dict[bytes, tuple[str, str]] = {}
    chunks = Chunks(path)
    with path.open("rb") as file:
        file.seek(len(HEAD))
        try:
            for fields, data in records(file):
                for each, payload in _records_of(fields, data, chunks, log):
                    _record(each, payload, topics, taken)
        except CutOff as error:
            log.cut(str(error))


def _records_of(
    fields: dict[bytes, bytes], data: bytes, chunks: Chunks, log: Log
) -> Iterator[tuple[dict[bytes, bytes], bytes]]:
    """The records of a chunk, of one that is cut off as many as it holds; a record that is none, by itself."""
    if fields.get(b"op") != CHUNK:
        yield fields, data
        return
    try:
        inside = chunks.opened(data, fields.get(b"compression", b"none").decode())
    except ValueError as error:
        log.lose("chunk", str(error))
        return
    yield from records(io.BytesIO(inside))


def _record(fields: dict[bytes, bytes], data: bytes, topics: dict[bytes, tuple[str, str]], taken: Messages) -> None:
    """Learn a topic, or take a message of one; a record whose head is damaged is counted."""
    try:
        _learn_or_take(fields, data, topics, taken)
    except (KeyError, ValueError, struct.error, CutOff):
        taken.log.lose("record", "its head is damaged")


def _learn_or_take(
    fields: dict[bytes, bytes], data: bytes, topics: dict[bytes, tuple[str, str]], taken: Messages
) -> None:
    kind, connection = fields.get(b"op"), fields.get(b"conn", b"")
    if kind == CONNECTION and connection not in topics:
        about = dict(_fields(data))
        topics[connection] = fields[b"topic"].decode(), type_name(about[b"type"].decode())
        taken.define("ros1", topics[connection][1], about[b"message_definition"].decode(errors="replace"))
    elif kind == MESSAGE and connection in topics:
        seconds, nanoseconds = struct.unpack("<II", fields[b"time"])
        taken.take(*topics[connection], "ros1", seconds + nanoseconds * 1e-9, data)


def records(file: BinaryIO) -> Iterator[tuple[dict[bytes, bytes], bytes]]:
    """Header fields and data of each record; a chunk that is cut off is handed on as it is, then CutOff."""
    while length := file.read(4):
        head = read_up_to(file, _size(length))
        size = file.read(4)
        if len(size) < 4:
            raise CutOff
        fields = dict(_fields(head))
        if b"op" not in fields:
            raise CutOff
        data = read_up_to(file, _size(size))
        whole = len(data) == _size(size)
        if whole or fields.get(b"op") == CHUNK:
            yield fields, data
        if not whole:
            raise CutOff


def _size(data: bytes) -> int:
    if len(data) < 4:
        raise CutOff
    return int.from_bytes(data, "little")


def _fields(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """The fields `name=value` of a header."""
    while data:
        size = _size(data[:4])
        name, _, value = data[4 : 4 + size].partition(b"=")
        yield name, value
        data = data[4 + size :]
