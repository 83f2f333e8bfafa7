"""The journal of a campaign in flight: which chunks are done, so that another go does the others and nothing twice.

    DIR/journal/campaign.json    what is flown, in which form and in chunks of which size
    DIR/journal/000064.json      rows of the chunk that starts with run 64; written last, after its recordings
    DIR/journal/000064.npy       its recordings, for HDF5; as CSV they go to DIR/data at once
    DIR/campaign.json            takes the journal's place when all is done

A chunk is done when its rows are there, unchanged, and its recordings have the sizes noted with them. All files appear
whole or not at all, by renaming, so that the process may be killed at any moment.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO, Any, Self

from ...errors import InputError
from ...record import (
    CAMPAIGN,
    CAMPAIGN_RUNS,
    JOURNAL,
    Held,
    cannot_write,
    locked,
    parse_json,
    read_json,
    read_text,
    sha256,
    shown,
)
from .campaign import Campaign
from .chunk import Piece, differing, versions
from .table import Row

IDENTITY = CAMPAIGN
SCHEMA = "vtank.campaign/1"
DATA = CAMPAIGN_RUNS  # folder of the CSV runs
ROWS = "runs.csv"
HDF5 = "runs.h5"
PART = ".part"
PAGE = re.compile(r"(campaign\.json|[0-9]{6,}\.(json|npy))(\.part)?")  # names in the journal's folder
TALLY = ("runs", "done", "failed")
OURS = {JOURNAL, DATA, ROWS, HDF5, ROWS + PART, HDF5 + PART, IDENTITY + PART}


@contextmanager
def renamed(path: Path) -> Iterator[Path]:
    """Where to write a file that takes its name when the block ends well; until then it is called *.part."""
    part = path.with_name(path.name + PART)
    with cannot_write(path):
        yield part
        os.replace(part, path)


@contextmanager
def whole(path: Path) -> Iterator[IO[str]]:
    """A text file to write, as `renamed`."""
    with renamed(path) as part, open(part, "w", encoding="utf-8", errors="backslashreplace", newline="\n") as file:
        yield file


def identity(campaign: Campaign, form: str) -> dict[str, Any]:
    """All that decides the bytes of the results, apart from the processor."""
    truths = {name: {"name": truth.name, "vector": truth.vector().tolist()} for name, truth in campaign.truths.items()}
    return {
        "schema": SCHEMA,
        "campaign": campaign.text,
        "scenarios": dict(campaign.scenarios),
        "truths": truths,
        "form": form,
        "versions": versions(),
    }


class Journal:
    """One folder's journal. A context manager: one process at a time holds it."""

    def __init__(self, out: Path, campaign: Campaign, form: str, chunk: int) -> None:
        """Begin, or take up again with the chunks as they were. InputError for a folder that holds anything else."""
        self.out, self.folder, self.form = out, out / JOURNAL, form
        self.identity = identity(campaign, form)
        self.complete = _same(out / IDENTITY, self.identity)
        self.chunks: list[range] = []
        self._lock = ExitStack()
        if self.complete:
            self._remove()  # what a go left that was killed at the very end
        else:
            self._begin(len(campaign), chunk)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._lock.close()

    def _begin(self, runs: int, chunk: int) -> None:
        present = {path.name for path in self.out.iterdir()} if self.out.is_dir() else set()
        if present - OURS or (present and JOURNAL not in present) or self._strangers():
            found = ", ".join(sorted(present)[:3])
            raise InputError(f"{self.out}: not a campaign begun by vtank, holds {found}: choose another folder")
        with cannot_write(self.folder):
            self.folder.mkdir(parents=True, exist_ok=True)
        try:
            self._lock.enter_context(locked(self.folder))
        except Held:
            raise InputError(f"{self.out}: another process is flying this campaign") from None
        if not _same(self.folder / IDENTITY, self.identity, beside=("chunk",)):
            self._write(self.folder / IDENTITY, self.identity | {"chunk": chunk})
        if self.form == "csv":
            (self.out / DATA).mkdir(exist_ok=True)
        size = read_json(self.folder / IDENTITY, SCHEMA).get("chunk")
        if not isinstance(size, int) or size < 1:
            raise InputError(
                f"{self.folder / IDENTITY}: chunk: expected a whole number of at least 1, found {shown(size)}"
            )
        self.chunks = [range(start, min(start + size, runs)) for start in range(0, runs, size)]

    def left(self) -> list[range]:
        """The chunks that are still to be done."""
        return [chunk for chunk in self.chunks if not self._is_done(chunk)]

    def add(self, piece: Piece) -> None:
        """Keep the results of a chunk."""
        files = {f"{DATA}/{row['run']}.csv": data for row, data in piece.runs if data}
        if self.form == "csv":
            for name, data in files.items():
                with cannot_write(self.out / name):
                    (self.out / name).write_bytes(data)
            sizes = {name: len(data) for name, data in files.items()}
        else:
            with renamed(self.spool(piece.start)) as part:
                size = part.write_bytes(b"".join(files.values()))
            sizes = {f"{JOURNAL}/{piece.start:06d}.npy": size}
        page = {"rows": [row for row, _ in piece.runs], "sizes": sizes}
        self._write(self._page(piece.start), page | {"sha256": _digest(page)})

    def pages(self) -> Iterator[tuple[int, list[Row]]]:
        """Start of every chunk and its runs' rows, in order."""
        return ((chunk.start, self._read(chunk.start)["rows"]) for chunk in self.chunks)

    def rows(self) -> Iterator[Row]:
        """Row of every run, in order."""
        return (row for _, rows in self.pages() for row in rows)

    def spool(self, start: int) -> Path:
        """The recordings of a chunk, one .npy array after the other."""
        return self.folder / f"{start:06d}.npy"

    @property
    def failed(self) -> int:
        """Failed runs of a complete campaign."""
        failed = read_json(self.out / IDENTITY, SCHEMA).get("failed")
        if not isinstance(failed, int):
            raise InputError(f"{self.out / IDENTITY}: failed: expected a whole number, found {shown(failed)}")
        return failed

    def finish(self, runs: int, failed: int) -> None:
        """The results stand: put what was flown beside them, and remove the journal."""
        tally = dict(zip(TALLY, (runs, runs - failed, failed), strict=True))
        self._write(self.out / IDENTITY, self.identity | tally)
        self._remove()

    def _page(self, start: int) -> Path:
        return self.folder / f"{start:06d}.json"

    def _is_done(self, chunk: range) -> bool:
        try:
            sizes = self._read(chunk.start)["sizes"]
            return all((self.out / name).stat().st_size == size for name, size in sizes.items())
        except (OSError, ValueError, InputError):
            return False

    def _read(self, start: int) -> dict[str, Any]:
        """A page; InputError for what is none."""
        path = self._page(start)
        page = parse_json(read_text(path), path)
        if not isinstance(page, dict) or page.pop("sha256", None) != _digest(page):
            raise InputError(f"{path}: not a page of a journal, or changed since it was written")
        return page

    def _strangers(self) -> list[Path]:
        """What lies in the journal's folder and is not of a journal."""
        return [path for path in self.folder.glob("*") if not PAGE.fullmatch(path.name) or path.is_dir()]

    def _remove(self) -> None:
        """Remove the journal's own files, and its folder unless somebody put something there."""
        for path in {*self.folder.glob("*")} - {*self._strangers()}:
            path.unlink()
        with suppress(OSError):
            self.folder.rmdir()

    def _write(self, path: Path, content: dict[str, Any]) -> None:
        with whole(path) as file:
            file.write(json.dumps(content, ensure_ascii=False, separators=(",", ":")))  # `dump` is slow


def _digest(page: dict[str, Any]) -> str:
    return sha256(json.dumps(page).encode())


def _same(path: Path, wanted: dict[str, Any], beside: tuple[str, ...] = TALLY) -> bool:
    """Whether a file says that this very campaign is there; False for no file, InputError for another campaign."""
    if not path.is_file():
        return False
    found = {key: value for key, value in read_json(path, SCHEMA).items() if key not in beside}
    if found == wanted:
        return True
    if isinstance(found.get("versions"), dict) and found | {"versions": None} == wanted | {"versions": None}:
        pairs = differing(found["versions"], wanted["versions"])
        raise InputError(f"{path.parent}: flown with {pairs}: go on with those, or into another folder")
    raise InputError(f"{path.parent}: holds another campaign, or this one in another form: choose another folder")
