"""Bags of ROS 2: a folder of *.db3 (SQLite) or *.mcap files, or one such file."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

from ..errors import InputError
from . import mcap
from .log import Log
from .ros import Messages

HEAD = b"SQLite format 3\0"


def read_folder(path: Path, log: Log) -> None:
    """Read all parts of a bag, in the order of their names; InputError where a folder has none."""
    parts = sorted(part for part in path.iterdir() if part.suffix in (".db3", ".mcap"))
    if not parts:
        packed = " (unpack *.zstd first)" if any(path.glob("*.zstd")) else ""
        raise InputError(f"{path}: no ROS 2 bag here, expected *.db3 or *.mcap{packed}")
    for part in parts:
        (read if part.suffix == ".db3" else mcap.read)(part, log)
    log.kind = "ROS 2 bag"


def read(path: Path, log: Log) -> None:
    """Read one SQLite file of a bag. InputError without rosbags, and where the file is no bag."""
    log.kind = "ROS 2 bag"
    taken = Messages(log, f"{path}: a ROS 2 bag")
    try:
        with closing(sqlite3.connect(f"file:{path.resolve()}?mode=ro&immutable=1", uri=True)) as base:
            _read(base, taken)
    except sqlite3.Error as error:
        if not log.streams:
            raise InputError(f"{path}: a ROS 2 bag that cannot be read ({error})") from None
        log.cut(f"the database says: {error}")


def _read(base: sqlite3.Connection, taken: Messages) -> None:
    tables = {name for (name,) in base.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if "message_definitions" in tables:
        for kind, language, text in base.execute(
            "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        ):
            taken.define("cdr", kind, text, language)
    topics = {
        number: (name, kind, encoding)
        for number, name, kind, encoding in base.execute("SELECT id, name, type, serialization_format FROM topics")
    }
    for number, time_ns, data in base.execute("SELECT topic_id, timestamp, data FROM messages"):
        if number in topics:
            taken.take(*topics[number], time_ns * 1e-9, data)
