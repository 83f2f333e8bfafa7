"""Files as they are read: regular ones, whole, text in UTF-8."""

from __future__ import annotations

import stat
from pathlib import Path

from ..errors import InputError


def read_bytes(path: Path) -> bytes:
    """The whole file; InputError for a folder, for what has no end (pipe, device, socket), for what cannot be read."""
    try:
        mode = path.stat().st_mode
        if stat.S_ISREG(mode):
            return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except ValueError as error:  # a NUL in the name
        raise InputError(f"{str(path)!r}: not a path ({error})") from None
    found = "a folder" if stat.S_ISDIR(mode) else "a pipe, a device or a socket"
    raise InputError(f"{path}: is {found}, expected a file")


def read_text(path: Path) -> str:
    """As `read_bytes`, decoded, without the mark some editors put first; InputError names the line of the fault."""
    data = read_bytes(path)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(f"{path}, line {line}: not UTF-8 text (byte 0x{data[error.start]:02x})") from None
