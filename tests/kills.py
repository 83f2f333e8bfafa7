"""Shared by the tests of kills: a command in a child of its own, ended without mercy at a chosen change of the disk.

The child is forked from a process that has loaded everything, so that a kill costs no start. It ends as by kill -9: no
`finally` is run. Changes are counted by Python's audit events, so that each of them can be the last.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
from pathlib import Path

from campaigns import digests

from vtank.cli import main

CHANGES = {"os.rename", "os.mkdir", "os.remove", "os.rmdir", "os.truncate", "os.link", "shutil.rmtree"}
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT


def is_change(event: str, arguments: tuple[object, ...]) -> bool:
    """Whether an audit event is one of a change of the disk."""
    if event == "open":
        path, _, flags = arguments
        return isinstance(flags, int) and bool(flags & WRITING) and not str(path).startswith("/dev/")
    return event in CHANGES


def child(command: list[str], **limits: float) -> tuple[int, int]:
    """Run a command: its exit code, or the negative signal that ended it, and the number of changes it made."""
    return ended(begun(command, **limits))  # type: ignore[arg-type]


def begun(
    command: list[str], at: int | None = None, after_s: float | None = None, most_bytes: int | None = None
) -> tuple[int, int]:
    """A child that runs a command: its number, and where it tells what it did.

    at: change before which it is killed, from 0. after_s: time after which it is killed. most_bytes: of a file.
    """
    reader, writer = os.pipe()
    number = os.fork()
    if number == 0:
        code = 70
        try:
            os.close(reader)
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, 1), os.dup2(nowhere, 2)
            sys.stdout, sys.stderr = open(1, "w", closefd=False), open(2, "w", closefd=False)  # noqa: SIM115
            changes = 0

            def count(event: str, arguments: tuple[object, ...]) -> None:
                nonlocal changes
                if is_change(event, arguments):
                    if changes == at:
                        os.kill(os.getpid(), signal.SIGKILL)
                    changes += 1

            sys.addaudithook(count)
            if most_bytes is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
            if after_s is not None:
                signal.signal(signal.SIGALRM, signal.SIG_DFL)
                signal.setitimer(signal.ITIMER_REAL, after_s)
            code = main(command)
            os.write(writer, str(changes).encode())
        finally:
            os._exit(code)
    os.close(writer)
    return number, reader


def ended(one: tuple[int, int]) -> tuple[int, int]:
    """Wait for a child; as `child`."""
    number, reader = one
    with os.fdopen(reader) as said:
        told = said.read()
    return os.waitstatus_to_exitcode(os.waitpid(number, 0)[1]), int(told or -1)


def seen(folder: Path) -> dict[str, str]:
    """Digest of every file that a user sees, those in hidden folders left out."""
    found = digests(folder) if folder.is_dir() else {}
    return {name: digest for name, digest in found.items() if not any(part[0] == "." for part in Path(name).parts)}


def hidden(folder: Path) -> list[str]:
    """What a kill has left that a user does not see."""
    return [path.name for path in folder.rglob(".*")] + [path.name for path in folder.rglob("*.part")]
