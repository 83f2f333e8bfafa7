"""Locks on files and folders: one process at a time, and free again when the process ends, however it ends."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class Held(Exception):
    """Another process holds the lock."""


@contextmanager
def locked(path: Path, wait: bool = False) -> Iterator[bool]:
    """Hold the lock of what stands at `path`; where another process does, Held, or `wait` until it is free.

    Yields whether there is a lock at all: elsewhere than on POSIX, and on some file systems, there is none.
    """
    number, sure = -1, False
    try:
        import fcntl

        number = os.open(path, os.O_RDONLY)
        fcntl.flock(number, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        sure = True
    except BlockingIOError:
        os.close(number)
        raise Held(str(path)) from None
    except FileNotFoundError:
        raise
    except (ImportError, OSError):
        pass
    try:
        yield sure
    finally:
        if number >= 0:
            os.close(number)
