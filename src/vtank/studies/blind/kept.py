"""Cases that are made, kept until all are: the same command goes on after any interruption and makes none twice.

    .TRUTH.vtank.cases/case_0001/page.json           digest of the order, entry in the index, hashes of the files
    .TRUTH.vtank.cases/case_0001/cases, .../sealed   the case's files as they will lie in the two folders

They lie beside the folder of the truth, for they tell it, and go when both folders stand. A case takes its name when
all of it is there, by renaming, so that the process may be killed at any moment.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from ...errors import InputError
from ...record import Held, cannot_write, current_versions, locked, read_json, sha256
from ...record.files import resolved
from ...record.folder import files_in
from .answer import sources
from .seal import Entry, digest, json_bytes

T = TypeVar("T")
Write = Callable[[Path, Path, str, T], Entry]  # by both folders and the name of a case
SCHEMA = "vtank.blind-kept/1"
PAGE, CASES, SEALED, PART = "page.json", "cases", "sealed", "part-"
FREE = ("trials", "threads")  # of an order: they decide nothing about a case


def name_of(number: int) -> str:
    """Name of the case of a number, from 0."""
    return f"case_{number + 1:04d}"


@dataclass(frozen=True)
class Kept:
    """The folder of cases that are made; mark: digest of all that decides their bytes, but for the processor."""

    folder: Path
    mark: str

    def keep(self, made: Callable[[int], T], write: Write[T], number: int) -> None:
        """Make a case and write its files, in any process."""
        case, name = made(number), name_of(number)
        with cannot_write(self.folder), tempfile.TemporaryDirectory(prefix=PART, dir=self.folder) as part:
            new = Path(part) / name
            for folder in (CASES, SEALED):
                (new / folder).mkdir(parents=True)
            entry = write(new / CASES, new / SEALED, name, case)
            page = {"schema": SCHEMA, "mark": self.mark, "entry": vars(entry), "files": _hashes(new)}
            (new / PAGE).write_bytes(json_bytes(page | {"sha256": digest(page)}))
            new.rename(self.folder / name)

    def left(self, count: int) -> list[int]:
        """Numbers of the cases that are still to be made, of so many; what is no whole case is cleared away."""
        for path in [path for path in self.folder.iterdir() if not self._whole(path)]:
            shutil.rmtree(path, ignore_errors=True)
        return [number for number in range(count) if not (self.folder / name_of(number)).exists()]

    def put(self, number: int, cases: Path, sealed: Path) -> Entry:
        """Copy the files of a case into the two folders; its entry in the index."""
        folder = self.folder / name_of(number)
        for kind, place in ((CASES, cases), (SEALED, sealed)):
            shutil.copytree(folder / kind, place, dirs_exist_ok=True)
        entry = read_json(folder / PAGE, SCHEMA)["entry"]
        return Entry(**entry | {"withheld": tuple(entry["withheld"])})

    def _whole(self, folder: Path) -> bool:
        """Whether a case is there as it was written; InputError for one of another order."""
        try:
            page = read_json(folder / PAGE, SCHEMA)
            if page.pop("sha256", None) != digest(page) or page["files"] != _hashes(folder):
                return False
        except (InputError, KeyError, OSError):
            return False
        if page["mark"] != self.mark:
            raise InputError(
                f"{self.folder}: holds cases of another seed, other options or another version, whose making was "
                "interrupted: go on with those, remove the folder, or choose another --truth-out"
            )
        return True


def _hashes(folder: Path) -> dict[str, str]:
    """Hash of every file of a case but its page."""
    return {file: sha256((folder / file).read_bytes()) for file in sorted(files_in(folder) - {PAGE})}


def place_of(truth_out: Path) -> Path:
    """Where the cases are kept whose truths will lie in that folder."""
    path = resolved(truth_out)
    return path.with_name(f".{path.name}.vtank.cases")


@contextmanager
def kept(truth_out: Path, order: Mapping[str, Any]) -> Iterator[Kept]:
    """What is kept of this order, held by this process alone; InputError where another one makes cases there."""
    folder = place_of(truth_out)
    asked = {key: value for key, value in order.items() if key not in FREE}
    mark = digest({"order": asked, "versions": current_versions(), "sources": sources()})
    with cannot_write(folder):
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    try:
        with locked(folder):
            try:
                yield Kept(folder, mark)
            finally:
                with suppress(OSError):
                    folder.rmdir()  # where nothing is kept
    except Held:
        raise InputError(f"{truth_out}: another process makes cases for it; wait, or choose another folder") from None


def forget(truth_out: Path) -> None:
    """Remove what was kept, for both folders stand."""
    shutil.rmtree(place_of(truth_out), ignore_errors=True)
