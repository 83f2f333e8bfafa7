"""Files as they are read: regular ones, whole, text in UTF-8."""

from __future__ import annotations

import difflib
import stat
from pathlib import Path

from ..errors import InputError

MOST_BYTES = 2**28  # of a file, 256 MB: five million rows of a run, which take some GB while they are read; a choice


def resolved(path: Path | str) -> Path:
    """Where a path leads, links followed; InputError where these go round in a circle."""
    try:
        found = Path(path).resolve()
        if not any(place.is_symlink() for place in (found, *found.parents)):  # as Python 3.13 leaves such a circle
            return found
    except (OSError, RuntimeError):
        pass
    raise InputError(f"{path}: its links go round in a circle; expected a path that leads somewhere")


def is_file(path: Path) -> bool:
    """Whether a file that can be read stands there; False for what cannot be the name of one, too."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def stem(path: Path) -> str:
    """The file's name without its ending; what is no text in it is spelled, as \\udcff."""
    return path.stem.encode(errors="backslashreplace").decode()


def run_name(path: Path) -> str:
    """The file's stem as the name of a run; InputError where the run's file would be hidden: no command reads it."""
    if path.name.startswith("."):
        raise InputError(f"{path}: makes a hidden file, which no command reads; expected a name without a dot first")
    return stem(path)


def check_file(path: Path, most: float = MOST_BYTES) -> None:
    """InputError for what is no file to read: what cannot be seen, a folder, what has no end or is too long.

    No end have pipes, devices and sockets; too long is a file of more than `most` bytes.
    """
    try:
        state = path.stat()
    except OSError as error:
        raise unread(path, error) from None
    except ValueError as error:  # a NUL in the name
        raise InputError(f"{str(path)!r}: not a path ({error})") from None
    if not stat.S_ISREG(state.st_mode):
        found = "a folder" if stat.S_ISDIR(state.st_mode) else "a pipe, a device or a socket"
        raise InputError(f"{path}: is {found}, expected a file")
    if state.st_size > most:
        found, expected = f"{state.st_size / 2**20:,.0f} MB", f"{most / 2**20:,.0f} MB"
        said = f"{path}: holds {found}, expected {expected} at most"
        raise InputError(f"{said}; split it, or record fewer samples a second")


def unread(path: Path, error: OSError) -> InputError:
    """What to say of a path that cannot be read: of one that is not there, what beside it may have been meant."""
    told = f"{path}: cannot be read ({error.strerror})"
    if not isinstance(error, FileNotFoundError):
        return InputError(told)
    at = next((place for place in (path, *path.parents) if place.parent.is_dir()), path)
    names = [each.name for each in at.parent.iterdir() if not each.name.startswith(".")]
    nearest = difflib.get_close_matches(at.name, names, 1, 0.6)
    if nearest:
        return InputError(f"{told}; did you mean '{at.with_name(nearest[0]) / path.relative_to(at)}'?")
    return InputError(told if at == path else f"{told}; there is no folder {at}")


def read_bytes(path: Path) -> bytes:
    """The whole file; InputError as of `check_file`, and for what cannot be read."""
    check_file(path)
    try:
        return path.read_bytes()
    except OSError as error:
        raise unread(path, error) from None


def read_text(path: Path) -> str:
    """As `read_bytes`, decoded, without the mark some editors put first; InputError names the line of the fault."""
    data = read_bytes(path)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        guess = "; is it UTF-16?" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else ""
        raise InputError(f"{path}, line {line}: not UTF-8 text (byte 0x{data[error.start]:02x}){guess}") from None
