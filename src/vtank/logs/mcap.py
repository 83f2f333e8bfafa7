"""MCAP logs, read from the front without their summary, which a log that was cut off has not."""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from itertools import takewhile
from pathlib import Path
from typing import BinaryIO

from .log import Log
from .records import Chunks, CutOff, read_up_to
from .ros import Messages, type_name

HEAD = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 3, 4, 5, 6, 15  # what a record is
CHUNK_HEAD = struct.Struct("<QQQI")  # first and last time, size, checksum
MESSAGE_HEAD = struct.Struct("<HIQQ")  # channel, number, time of the log and of publishing [ns]


def read(path: Path, log: Log) -> None:
    """Read an MCAP log whose messages are encoded as cdr (ROS 2), ros1 or json. InputError without rosbags."""
    log.kind = "MCAP log"
    found = Found(Messages(log, f"{path}: an MCAP log"), Chunks(path))
    with path.open("rb") as file:
        file.seek(len(HEAD))
        try:
            for kind, data in until_end(file):
                found.take(kind, data)
        except CutOff as error:
            log.cut(str(error))


class Found:
    """What a log has told so far, and where its messages go."""

    def __init__(self, taken: Messages, chunks: Chunks) -> None:
        """Nothing yet."""
        self.taken, self.chunks = taken, chunks
        self.schemas: dict[int, tuple[str, str, str]] = {}
        self.channels: dict[int, tuple[str, str, str]] = {}

    def take(self, kind: int, data: bytes) -> None:
        """A record of the file itself; one that is too short to be what it says is counted."""
        try:
            if kind == CHUNK:
                self._chunk(data)
            else:
                self._record(kind, data)
        except struct.error:
            self.taken.log.lose("record", "too short")

    def _chunk(self, data: bytes) -> None:
        """The records of a chunk; of one that is cut off, as many as it holds. A chunk within a chunk is none."""
        (method,) = _texts(data[CHUNK_HEAD.size :], 1)
        start = CHUNK_HEAD.size + 4 + len(method) + 8
        try:
            inside = self.chunks.opened(data[start:], method)
        except ValueError as error:
            self.taken.log.lose("chunk", str(error))
            return
        for kind, inner in until_end(io.BytesIO(inside)):
            if kind == CHUNK:
                self.taken.log.lose("chunk", "within a chunk")
            else:
                self.take(kind, inner)

    def _record(self, kind: int, data: bytes) -> None:
        if kind == SCHEMA:
            name, language, text = _texts(data[2:], 3)
            self.schemas[int.from_bytes(data[:2], "little")] = type_name(name), language, text
        elif kind == CHANNEL:
            topic, encoding = _texts(data[4:], 2)
            number, schema = struct.unpack("<HH", data[:4])
            name, language, text = self.schemas.get(schema, ("", "", ""))
            self.channels[number] = topic, name, encoding
            self.taken.define(encoding, name, text, language)
        elif kind == MESSAGE:
            number, _, time_ns, _ = MESSAGE_HEAD.unpack_from(data)
            if number in self.channels:
                self.taken.take(*self.channels[number], time_ns * 1e-9, data[MESSAGE_HEAD.size :])


def until_end(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """The records up to that which says that the data end."""
    return takewhile(lambda record: record[0] != DATA_END, records(file))


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
