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
SOME = 12  # of the messages that are not read, those that are named; a choice


class Watched(io.FileIO):
    """A file that remembers whether its end came in the middle of what was asked for, and lets nobody wait there."""

    cut, furthest, stuck = False, -1, 0

    def __init__(self, path: Path) -> None:
        """The file up to its last byte that is not zero, since what a crash left blank would be searched for long."""
        super().__init__(path)
        self.end = self.seek(0, 2)
        blank = True
        while blank and self.end > 0:
            self.end = max(self.end - BLANK, 0)
            self.seek(self.end)
            blank = not any(super().read(BLANK) or b"")
        self.end = min(self.end + 2 * BLANK, self.seek(0, 2))
        self.seek(0)

    def read(self, size: int | None = -1, /) -> bytes:
        """As of a file that ends there."""
        left = max(self.end - self.tell(), 0)
        data = super().read(left if size is None or size < 0 else min(size, left)) or b""
        if size == HEAD:
            self.stuck = 0 if self.tell() > self.furthest else self.stuck + 1
            self.furthest = max(self.furthest, self.tell())
        if self.stuck > ENOUGH:
            return b""
        self.cut = 0 < len(data) < (size or 0) or (not data and (size or 0) > HEAD)
        return data


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
            log.undecoded[data.name] += 1
            continue
        stream = log.stream(data.name + (f".{data.multi_id}" if data.multi_id else ""))
        time_s = data.data["timestamp"] * 1e-6
        stream.count, stream.first_s, stream.last_s = time_s.size, float(time_s.min()), float(time_s.max())
        stream.sample = data.data
        stream.time_s = array("d", time_s.tobytes())
        for name in stream.values:
            values = data.data.get(name, np.full(time_s.size, np.nan)).astype(float)
            stream.values[name] = array("d", values.tobytes())
    log.parameters |= {
        key: float(value) for key, value in found.initial_parameters.items() if isinstance(value, int | float)
    }
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
