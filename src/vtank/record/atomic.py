"""Files that appear whole or not at all."""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

from ..errors import InputError
from .files import resolved
from .lock import Held, locked

NEW, OLD = "new", "old"  # folders within a room
AT_FDCWD, EXCHANGE = -100, 2  # of Linux' renameat2: names from the current folder, both names kept


def write_bytes(path: Path | str, data: bytes) -> None:
    """Write a file so that a failure leaves what was there before; InputError where it cannot be written."""
    write_files({Path(path): data})


def write_text(path: Path | str, text: str) -> None:
    """As `write_bytes`, in UTF-8."""
    write_bytes(path, utf8(text))


def utf8(text: str) -> bytes:
    """Text as UTF-8; what has no place in it, from names of files that are no text, as \\udc.., as JSON has it."""
    return text.encode(errors="backslashreplace")


def write_files(contents: Mapping[Path, bytes]) -> None:
    """Write files as a set: all are on the disk before the first of them takes its name. Errors as of `write_bytes`."""
    with ExitStack() as stack:
        ready = []
        for path, data in ((resolved(path), data) for path, data in contents.items()):
            stack.enter_context(cannot_write(path))
            beside = stack.enter_context(room(path))
            if path.exists() and not path.is_file():  # a device or a pipe is written to, never replaced
                path.write_bytes(data)
                continue
            (beside / path.name).write_bytes(data)
            ready.append((beside / path.name, path))
        for new, path in ready:
            with cannot_write(path):
                os.replace(new, path)


@contextmanager
def cannot_write(path: Path) -> Iterator[None]:
    """What the system refuses to write is told as InputError."""
    try:
        yield
    except BrokenPipeError:
        raise  # somebody stopped reading stdout: not a matter of this path
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error})") from error


@contextmanager
def room(path: Path) -> Iterator[Path]:
    """A temporary folder beside `path`, on the same file system; parents made for it go again after a failure.

    What is left of rooms for the same path, whose processes were killed, is cleared away.
    """
    missing = [parent for parent in path.parents if not parent.exists()]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with ExitStack() as stack:
            with locked(path.parent, wait=True):  # or a new room could be taken for a left one
                clear_rooms(path)
                name = stack.enter_context(tempfile.TemporaryDirectory(prefix=_prefix(path), dir=path.parent))
                stack.enter_context(locked(Path(name)))
            yield Path(name)
    except BaseException:
        for parent in missing:
            with suppress(OSError):
                parent.rmdir()
        raise


def clear_rooms(path: Path) -> None:
    """Remove the rooms for a path that no process holds any more."""
    for left in left_rooms(path):
        shutil.rmtree(left, ignore_errors=True)


def left_rooms(path: Path) -> Iterator[Path]:
    """Rooms for a path that no process holds any more, each one held while it is looked at."""
    for left in [entry for entry in path.parent.glob("*") if entry.name.startswith(_prefix(path)) and entry.is_dir()]:
        with suppress(Held, OSError), locked(left) as sure:
            if not sure:
                continue
            if (left / OLD).exists() and not path.exists():  # killed between two renamings
                (left / OLD).rename(path)
            yield left


def _prefix(path: Path) -> str:
    return f".{path.name}.vtank-"


def put_in_place(beside: Path, path: Path) -> None:
    """Give the folder `new` of a room the name `path`; the folder that has it becomes part of the room.

    In one step where the system can exchange two names (Linux), else in two, the first of which the next to write
    there takes back.
    """
    if not path.exists():
        (beside / NEW).rename(path)
    elif not exchanged(beside / NEW, path):
        path.rename(beside / OLD)
        try:
            (beside / NEW).rename(path)
        except BaseException:
            (beside / OLD).rename(path)
            raise


def exchanged(one: Path, other: Path) -> bool:
    """Exchange the names of two folders in one step; False where system or file system cannot."""
    function = _renameat2()
    if function is None:
        return False
    if function(AT_FDCWD, os.fsencode(one), AT_FDCWD, os.fsencode(other), EXCHANGE) == 0:
        return True
    number = ctypes.get_errno()
    if number in (errno.ENOSYS, errno.EINVAL, errno.EOPNOTSUPP):
        return False
    raise OSError(number, os.strerror(number), str(other))


@cache
def _renameat2() -> Any:
    if not sys.platform.startswith("linux"):
        return None
    return getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
