"""Logs of PX4 (*.ulg), read with pyulog; of several instances of a message the second is called NAME.1."""

from __future__ import annotations

import contextlib
import io
from array import array
from pathlib import Path

import numpy as np

from ..errors import InputError
from .log import Log, library

HEAD = 3  # bytes before each message: its length and kind
ENOUGH = (
    100_000  # heads read that lie no further, more than the bytes of a message: a damaged file ends there; a choice
)
BLANK = 2**12  # bytes of zeros at the end of a file, of which no more are read; a choice
BLOCK = 2**20  # bytes that are searched for these at once; a choice
MOST_FIELDS = 2**18  # of all messages, those of types within types one by one; a flight's have some 10,000; a choice
ROOM = 2**16  # bytes of a message at most
SOME = 12  # of the messages that are not read, those that are named; a choice


class Watched(io.FileIO):
    """A file that remembers whether its end came in the middle of what was asked for, and lets nobody wait there."""

    cut, furthest, stuck = False, -1, 0

    def __init__(self, path: Path) -> None:
        """The file up to its last byte that is not zero, since what a crash left blank would be searched for long."""
        super().__init__(path)
        self.formats, self.kind = Formats(), b""
        size = self.end = self.seek(0, 2)
        filled = 0
        while not filled and self.end > 0:
            start = max(self.end - BLOCK, 0)
            self.seek(start)
            block = super().read(self.end - start) or b""
            self.end = start
            filled = 0 if block == bytes(len(block)) else len(block.rstrip(b"\0"))
        self.end = min(self.end + filled + BLANK, size)
        self.seek(0)

    def read(self, size: int | None = -1, /) -> bytes:
        """As of a file that ends there."""
        left = max(self.end - self.tell(), 0)
        data = super().read(left if size is None or size < 0 else min(size, left)) or b""
        if size == HEAD:
            self.kind = data[2:]
            self.stuck = 0 if self.tell() > self.furthest else self.stuck + 1
            self.furthest = max(self.furthest, self.tell())
        else:
            self.formats.see(self.kind, data)
            self.kind = b""
        if self.stuck > ENOUGH:
            return b""
        self.cut = 0 < len(data) < (size or 0) or (not data and (size or 0) > HEAD)
        return data


class Formats:
    """How the messages are made, counted before pyulog takes them apart: types within types may have no end."""

    def __init__(self) -> None:
        """None seen yet."""
        self.types: dict[str, list[tuple[str, int]]] = {}  # of all definitions of a name
        self.fields = 0

    def see(self, kind: bytes, data: bytes) -> None:
        """The content of a message; RuntimeError where messages have more than MOST_FIELDS."""
        if kind == b"F":
            name, _, fields = data.decode(errors="replace").partition(":")
            self.types.setdefault(name, []).extend(_field(each) for each in fields.split(";") if each)
        elif kind == b"A":
            name = data[3:].decode(errors="replace")
            self.fields += self.count(name, {}) if name in self.types else 0  # one of no type is damaged, and left out
            if self.fields > MOST_FIELDS:
                raise RuntimeError(f"its messages have more than {MOST_FIELDS:,} fields")

    def count(self, name: str, known: dict[str, int]) -> int:
        """Fields of a type, those of the types within it one by one; 1 for a number."""
        if name not in known:
            known[name] = 1 + sum(many * self.count(kind, known) for kind, many in self.types.get(name, ()))
        return known[name]


def _field(text: str) -> tuple[str, int]:
    """Type of a field and how many it has; what cannot be read has as many as a message has room for."""
    kind, bracket, size = text.split(" ")[0].partition("[")
    try:
        return kind, max(int(size.partition("]")[0]), 1) if bracket else 1
    except ValueError:
        return kind, ROOM


class Names:
    """The messages of a log, of which pyulog is to keep those that are wanted."""

    def __init__(self, log: Log) -> None:
        """None seen yet."""
        self.log = log
        self.left: set[str] = set()

    def __contains__(self, name: str) -> bool:
        """Whether a message is wanted."""
        wanted = bool(self.log.wanted(name, "")) or bool(self.log.wanted(f"{name}.1", ""))
        if not wanted:
            self.left.add(name)
        return wanted


def read(path: Path, log: Log) -> None:
    """Read a PX4 log; times count from the start of the vehicle. InputError without pyulog, and where it fails."""
    ulog = library("pyulog", "pyulog", f"{path}: a PX4 log")
    log.kind = "PX4 log"
    names, file = Names(log), Watched(path)
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # pyulog prints what it thinks of a file
            found = ulog.ULog(file, names)
    except Exception as error:  # of many kinds, for a head that is broken
        raise InputError(f"{path}: a PX4 log that cannot be read ({error})") from None
    for data in found.data_list:
        if "timestamp" not in data.data:  # its definition is damaged
            log.lose(data.name, "no field 'timestamp'")
            continue
        stream = log.stream(data.name + (f".{data.multi_id}" if data.multi_id else ""))
        time_s = data.data["timestamp"] * 1e-6
        stream.count, stream.first_s, stream.last_s = time_s.size, float(time_s.min()), float(time_s.max())
        stream.sample = data.data
        stream.time_s = array("d", time_s.tobytes())
        for name in stream.values:
            values = data.data.get(name, np.full(time_s.size, np.nan)).astype(float)
            stream.values[name] = array("d", values.tobytes())
    for key, value in found.initial_parameters.items():
        if isinstance(value, int | float):
            log.learn(key, float(value))
    if file.cut:
        log.cut("it ends within a message")
    if found.file_corruption:
        log.remarks.append("parts of the log are damaged and were skipped")
    lost_s = sum(drop.duration for drop in found.dropouts) * 1e-3
    if lost_s:
        log.remarks.append(f"the logger lost {lost_s:.2g} s in {len(found.dropouts)} gaps, as it says itself")
    if names.left:
        some = ", ".join(sorted(names.left)[:SOME]) + ", ..." * (len(names.left) > SOME)
        log.remarks.append(f"{len(names.left)} other messages are not read: {some}")
