"""Bags of ROS 2: a folder of *.db3 (SQLite) or *.mcap files, or one such file."""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from itertools import islice
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..record.files import check_file, resolved
from . import mcap
from .log import Log
from .records import CHUNK_BYTES
from .ros import Messages

HEAD = b"SQLite format 3\0"
ROW_BYTES = 4  # of a row at least: its place on the page, its length, its number


def read_folder(path: Path, log: Log) -> None:
    """Read all parts of a bag, in the order of their names; InputError where a folder has none."""
    parts = sorted(part for part in path.iterdir() if part.suffix in (".db3", ".mcap"))
    if not parts:
        packed = " (unpack *.zstd first)" if any(path.glob("*.zstd")) else ""
        raise InputError(f"{path}: no ROS 2 bag here, expected *.db3 or *.mcap{packed}")
    for part in parts:
        check_file(part, math.inf)
        (read if part.suffix == ".db3" else mcap.read)(part, log)
    log.kind = "ROS 2 bag"


def read(path: Path, log: Log) -> None:
    """Read one SQLite file of a bag. InputError without rosbags, and where the file is no bag."""
    log.kind = "ROS 2 bag"
    taken = Messages(log, f"{path}: a ROS 2 bag")
    try:
        with closing(sqlite3.connect(f"{resolved(path).as_uri()}?mode=ro&immutable=1", uri=True)) as base:
            base.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, CHUNK_BYTES)
            _read(Base(path, base), taken)
    except sqlite3.Error as error:
        if not log.streams:
            raise InputError(f"{path}: a ROS 2 bag that cannot be read ({error})") from None
        log.cut(f"the database says: {error}")


class Base:
    """A database whose tables are read and nothing else: what a view or a virtual table makes up has no end."""

    def __init__(self, path: Path, base: sqlite3.Connection) -> None:
        """Of a file; InputError where it has no topics or messages."""
        self.base = base
        self.most = path.stat().st_size // ROW_BYTES
        found = base.execute("SELECT name FROM sqlite_master WHERE type = 'table' AND rootpage > 0")
        self.tables = {name for (name,) in islice(found, self.most)}
        absent = [name for name in ("topics", "messages") if name not in self.tables]
        if absent:
            raise InputError(f"{path}: a ROS 2 bag without a table '{absent[0]}', expected the tables topics, messages")

    def rows(self, table: str, *columns: str) -> Iterator[tuple[Any, ...]]:
        """The rows of a table, no more than its file can hold: pages that go round in a circle have no end."""
        for number, row in enumerate(self.base.execute(f"SELECT {', '.join(columns)} FROM {table}")):
            if number >= self.most:
                raise sqlite3.DatabaseError(f"more {table} than its file can hold")
            yield row


def _read(base: Base, taken: Messages) -> None:
    if "message_definitions" in base.tables:
        said = "topic_type", "encoding", "encoded_message_definition"
        for kind, language, text in base.rows("message_definitions", *said):
            if isinstance(kind, str) and isinstance(text, str):
                taken.define("cdr", kind, text, language)
    named = "id", "name", "type", "serialization_format"
    topics = {number: (name, kind, encoding) for number, name, kind, encoding in base.rows("topics", *named)}
    for number, time_ns, data in base.rows("messages", "topic_id", "timestamp", "data"):
        if number not in topics:
            continue
        about = topics[number]
        if not all(isinstance(text, str) for text in about):
            taken.log.lose(f"topic {number}", "its name, type or format is no text")
        elif not isinstance(time_ns, int):
            taken.log.lose(about[0], "its time is no whole number")
        else:
            taken.take(*about, time_ns * 1e-9, data)
