"""Dataflash logs of ArduPilot (*.BIN): each message begins A3 95 and its number; FMT messages say how they are made."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .log import Log, library, number
from .records import next_mark

MARK = b"\xa3\x95"
MARKS = re.compile(MARK)
FORMAT = 0x80  # number of the message that describes the others
FORMAT_LENGTH = 89
PADDING = 528  # bytes at the end of a log that may be blank: two pages of the memory that it is written to


def read(path: Path, log: Log) -> None:
    """Read a dataflash log; times count from the start of the vehicle. InputError without pymavlink."""
    reader = library("pymavlink.DFReader", "pymavlink", f"{path}: an ArduPilot log")
    log.kind = "ArduPilot dataflash log"
    formats: dict[int, Any] = {}
    for kind, body in messages(path, log, formats):
        if kind == FORMAT:
            described, length, name, letters, columns = struct.unpack("<BB4s16s64s", body)
            texts = [text.split(b"\0")[0].decode(errors="replace") for text in (name, letters, columns)]
            if length > len(MARK) and set(texts[1]) <= reader.FORMAT_TO_STRUCT.keys():
                formats[described] = reader.DFFormat(described, texts[0], length, *texts[1:])
            continue
        form = formats[kind]
        if struct.calcsize(form.msg_struct) != len(body):
            log.lose(form.name, "not as long as its description says")
            continue
        _take(log, form, struct.unpack(form.msg_struct, body))


def _take(log: Log, form: Any, raw: tuple[Any, ...]) -> None:
    scaled = (value if scale is None else value * scale for value, scale in zip(raw, form.msg_mults, strict=True))
    message = dict(zip(form.columns, scaled, strict=False))
    if form.name == "PARM" and isinstance(message.get("Name"), bytes):
        log.learn(message["Name"].split(b"\0")[0].decode(errors="replace"), number(message, "Value"))
    time_s = _time_s(message)
    if math.isnan(time_s):
        log.lose(form.name, "its time is no number")
    if not time_s or math.isnan(time_s):
        return
    stream = log.stream(form.name)
    stream.tick(time_s)
    if stream.values:
        stream.keep(time_s, message)


def _time_s(message: dict[str, Any]) -> float:
    """Time of a message since the start of the vehicle; 0 where it tells none, NaN where it is no number."""
    if "TimeUS" in message:
        return number(message, "TimeUS") * 1e-6
    return number(message, "TimeMS") * 1000.0 * 1e-6 if "TimeMS" in message else 0.0


def messages(path: Path, log: Log, formats: dict[int, Any]) -> Iterator[tuple[int, bytes]]:
    """Number and body of each message; what is no message is skipped and told."""
    size, lost = path.stat().st_size, 0
    with path.open("rb") as file:
        while head := file.read(3):
            number = head[2] if len(head) == 3 else 0
            if head[:2] != MARK or (number != FORMAT and number not in formats):
                here = file.tell() - len(head)
                found = next_mark(file, MARKS, here + 1)
                if found is None:
                    lost += size - here if size - here > PADDING else 0
                    break
                file.seek(found)
                lost += found - here
                continue
            length = (FORMAT_LENGTH if number == FORMAT else formats[number].len) - 3
            body = file.read(length)
            if len(body) < length:
                log.cut("it ends within a message")
                break
            yield number, body
    if lost:
        log.remarks.append(f"{lost} bytes between messages are no message and were skipped")
