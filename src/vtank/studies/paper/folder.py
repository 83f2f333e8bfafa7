"""A folder of results that appears whole or not at all, and that replaces nothing but an earlier one of its own."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...record import current_versions, new_folder, read_json

MARKER = "reproduction.json"
SCHEMA = "vtank.reproduction/1"


@contextmanager
def results_folder(path: Path, about: Mapping[str, Any]) -> Iterator[Path]:
    """Yield an empty folder that becomes `path` when the block ends well, with a list of its files and `about`.

    InputError where something else than an earlier folder of results is in the way, or where it cannot be written.
    """
    refuse_others(path)
    with new_folder(path) as new:
        yield new
        files = sorted(file.relative_to(new).as_posix() for file in new.rglob("*") if file.is_file())
        content = {"schema": SCHEMA, **about, "versions": current_versions(), "files": files}
        (new / MARKER).write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def refuse_others(path: Path) -> None:
    """InputError unless `path` is free, empty, or holds nothing but results written here."""
    if path.exists() and not path.is_dir():
        raise InputError(f"{path}: is a file, expected a folder for the results")
    present = (
        {file.relative_to(path).as_posix() for file in path.rglob("*") if file.is_file()} if path.exists() else set()
    )
    if not present:
        return
    if MARKER not in present:
        raise InputError(f"{path}: not empty and not results of 'vtank reproduce': choose another folder")
    strangers = sorted(present - set(read_json(path / MARKER, SCHEMA)["files"]) - {MARKER})
    if strangers:
        raise InputError(f"{path}: holds {', '.join(strangers[:3])}, which replacing the results would delete")
