"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import InputError


def write_bytes(path: Path | str, data: bytes) -> None:
    """Write a file so that a failure leaves what was there before; InputError where it cannot be written."""
    path = Path(path).resolve()
    with cannot_write(path), room(path) as beside:
        if path.exists() and not path.is_file():  # a device or a pipe is written to, never replaced
            path.write_bytes(data)
            return
        (beside / path.name).write_bytes(data)
        os.replace(beside / path.name, path)


def write_text(path: Path | str, text: str) -> None:
    """As `write_bytes`, in UTF-8."""
    write_bytes(path, text.encode())


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
    """A temporary folder beside `path`, on the same file system; parents made for it go again after a failure."""
    missing = [parent for parent in path.parents if not parent.exists()]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=path.parent) as name:
            yield Path(name)
    except BaseException:
        for parent in missing:
            with suppress(OSError):
                parent.rmdir()
        raise
