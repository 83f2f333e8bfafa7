"""MCAP logs, read from the front without their summary, which a log that was cut off has not."""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from .log import Log
from .records import decompressed, read_up_to
from .ros import Messages, type_name
from .rosbag1 import CutOff

HEAD = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 3, 4, 5, 6, 15  # what a record is
CHUNK_HEAD = struct.Struct("<QQQI")  # first and last time, size, checksum
MESSAGE_HEAD = struct.Struct("<HIQQ")  # channel, number, time of the log and of publishing [ns]


def read(path: Path, log: Log) -> None:
    """Read an MCAP log whose messages are encoded as cdr (ROS 2), ros1 or json. InputError without rosbags."""
    log.kind = "MCAP log"
    taken = Messages(log, f"{path}: an MCAP log")
    schemas: dict[int, tuple[str, str, str]] = {}
    channels: dict[int, tuple[str, str, str]] = {}
    with path.open("rb") as file:
        file.seek(len(HEAD))
        try:
            _read(file, schemas, channels, taken)
        except CutOff:
            log.cut("it ends within a record")


def _read(
    file: BinaryIO, schemas: dict[int, tuple[str, str, str]], channels: dict[int, tuple[str, str, str]], taken: Messages
) -> None:
    for kind, data in records(file):
        if kind == SCHEMA:
            name, language, text = _texts(data[2:], 3)
            schemas[int.from_bytes(data[:2], "little")] = type_name(name), language, text
        elif kind == CHANNEL:
            topic, encoding = _texts(data[4:], 2)
            number, schema = struct.unpack("<HH", data[:4])
            name, language, text = schemas.get(schema, ("", "", ""))
            channels[number] = topic, name, encoding
            taken.define(encoding, name, text, language)
        elif kind == MESSAGE:
            number, _, time_ns, _ = MESSAGE_HEAD.unpack_from(data)
            if number in channels:
                taken.take(*channels[number], time_ns * 1e-9, data[MESSAGE_HEAD.size :])
        elif kind == CHUNK:
            _chunk(data, schemas, channels, taken)
        elif kind == DATA_END:
            return


def _chunk(
    data: bytes, schemas: dict[int, tuple[str, str, str]], channels: dict[int, tuple[str, str, str]], taken: Messages
) -> None:
    """The records of a chunk; of one that is cut off, as many as it holds."""
    (method,) = _texts(data[CHUNK_HEAD.size :], 1)
    start = CHUNK_HEAD.size + 4 + len(method) + 8
    try:
        inside = decompressed(data[start:], method)
    except ValueError as error:
        taken.log.undecoded[f"chunk ({error})"] += 1
        return
    _read(io.BytesIO(inside), schemas, channels, taken)


def records(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Kind and content of each record; a chunk that is cut off is handed on as it is, then CutOff."""
    while head := file.read(9):
        if len(head) < 9 or not head[0]:
            raise CutOff
        size = int.from_bytes(head[1:], "little")
        data = read_up_to(file, size)
        whole = len(data) == size
        if whole or (head[0] == CHUNK and len(data) > CHUNK_HEAD.size + 16):
            yield head[0], data
        if not whole:
            raise CutOff


def _texts(data: bytes, count: int) -> list[str]:
    """The first texts of a record, each behind its length."""
    found = []
    for _ in range(count):
        size = int.from_bytes(data[:4], "little")
        found.append(data[4 : 4 + size].decode(errors="replace"))
        data = data[4 + size :]
    return found
