"""Folders that vtank writes: they appear whole or not at all, and take the place of nothing but an earlier one.

What may be replaced is a folder that carries the marker of its kind and holds nothing but the files that the marker
lists, files whose names begin with a dot included.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path
from typing import Any

from ..errors import InputError
from .atomic import NEW, cannot_write, put_in_place, room, utf8
from .documents import json_text, read_json
from .files import resolved


@dataclass(frozen=True)
class Kind:
    """A kind of folder.

    Attributes:
        what: it holds, in a few words.
        marker, schema: the file that marks it, and that file's schema.
        listed: marker's content -> the other files, paths within the folder.
    """

    what: str
    marker: str
    schema: str
    listed: Callable[[Mapping[str, Any]], Iterable[str]] = itemgetter("files")


def refuse_loss(path: Path | str, kind: Kind | None = None) -> None:
    """InputError unless `path` is free, empty, or holds nothing but an earlier folder of this kind; None: no kind."""
    path = Path(path)
    if path.exists() and not path.is_dir():
        raise InputError(f"{path}: is a file, expected a folder")
    if kind and (path / kind.marker).is_file():
        strangers = files_in(path) - {kind.marker, *_listed(path / kind.marker, kind)}
    else:
        strangers = set(os.listdir(path)) if path.exists() else set()
    if strangers:
        named = ", ".join(sorted(strangers)[:3]) + ", ..." * (len(strangers) > 3)
        what = f", no part of {kind.what}" if kind else ""
        raise InputError(f"{path}: holds {named}{what}; vtank deletes nothing of yours: choose another folder")
    parent = next(folder for folder in resolved(path).parents if folder.exists())
    if not parent.is_dir() or not os.access(parent, os.W_OK):
        raise InputError(f"{path}: cannot be written in {parent}")
    if resolved(path) in (Path.cwd(), *Path.cwd().parents):
        raise InputError(f"{path}: is the folder you are in, or one above it, which cannot be replaced: choose another")


def files_in(path: Path) -> set[str]:
    """Everything in a folder that is not a folder, and folders that hold nothing, as paths within it."""
    found = set()
    for folder, folders, files in os.walk(path, onerror=_unreadable):
        inside = Path(folder).relative_to(path)
        links = [name for name in folders if (Path(folder) / name).is_symlink()]
        found |= {(inside / name).as_posix() for name in (*files, *links)}
        if not folders and not files and Path(folder) != path:
            found.add(inside.as_posix())
    return found


@contextmanager
def new_folder(path: Path | str, kind: Kind | None = None) -> Iterator[Path]:
    """Yield an empty folder that becomes `path`, in place of what is there, when the block ends well.

    After an exception, Ctrl-C among them, `path` is as it was. InputError, before the block and after it, where
    something would be lost, and where it cannot be written.
    """
    refuse_loss(path, kind)
    shown, path = path, resolved(path)
    with cannot_write(path), room(path) as beside:
        (beside / NEW).mkdir()
        yield beside / NEW
        refuse_loss(shown, kind)
        put_in_place(beside, path)


@contextmanager
def results_folder(path: Path | str, kind: Kind, about: Mapping[str, Any] | None = None) -> Iterator[Path]:
    """As `new_folder`; the marker is written last, with `about` and the list of all files."""
    with new_folder(path, kind) as new:
        yield new
        content = {"schema": kind.schema, **(about or {}), "files": sorted(files_in(new))}
        (new / kind.marker).write_bytes(utf8(json_text(content)))


def _listed(marker: Path, kind: Kind) -> set[str]:
    try:
        return set(kind.listed(read_json(marker, kind.schema)))
    except (KeyError, TypeError):
        raise InputError(f"{marker}: does not list the files of {kind.what}") from None


def _unreadable(error: OSError) -> None:
    raise InputError(f"{error.filename}: cannot be read ({error.strerror})")
