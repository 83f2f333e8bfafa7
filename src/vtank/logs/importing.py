"""A log of any kind as a run."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..plant.recorded import check_recorded
from ..plant.vehicle import Vehicle, load_vehicle
from ..record.contradictions import contradictions
from ..record.files import check_file, unread
from ..record.run import Run
from ..record.shown import preformatted
from ..record.writer import DECIMALS, write_run
from . import dataflash, mcap, rosbag1, rosbag2, table, tlog, ulog
from .convert import Columns, columns
from .decidable import Decidable, decidable
from .header import channels, settled
from .log import Log
from .map_file import read_mapping
from .mapping import HEADER, PRESETS, Mapping
from .preview import preview

LOG_BYTES = 2**32  # of a log, 4 GB: no file on the cards of autopilots (FAT) is longer
BAGS = ("rosbag1", "rosbag2", "mcap")  # which hold pictures as well, and may be longer
ULOG_HEAD = b"ULog\x01\x12\x35"
Reader = Callable[[Path, Log], None]


@dataclass(frozen=True)
class Imported:
    """A log as a run, and what is to be known of it; printed, it is the preview.

    Attributes:
        run: what was found.
        log: what the file held, the messages that were not used among it.
        columns: the channels, each with its own times and its origin.
        decidable: what the run allows to decide, and what it does not.
        mapping: by which the columns were made.
    """

    run: Run
    log: Log
    columns: Columns
    decidable: Decidable
    mapping: Mapping

    def __str__(self) -> str:
        """The preview."""
        return preview(self.run, self.log, self.columns, self.decidable, self.mapping)

    def _repr_html_(self) -> str:
        """The preview, for a notebook."""
        return preformatted(str(self))

    def write(self, path: Path | str) -> None:
        """Write the run as CSV, as `vtank.load` reads it. InputError where it breaks the rules of a run."""
        write_run(path, self.run)


def import_log(
    *paths: Path | str, mapping: Path | str | None = None, vehicle: Path | str | Vehicle | None = None
) -> Imported:
    """Read a log, or the parts of one log, as a run.

    mapping: TOML file that says which fields become which columns (logs/map_file.py); left out, a preset for ArduPilot,
        PX4 and ROS, and the header of a table. vehicle: its name or file, for the names of its thrusters.
    Times count from the first sample. InputError for what is no log, for a library that is not here, for messages or
    fields that are not in the log, and where no channel of a vehicle is found.
    """
    if not paths:
        raise InputError("no log: nothing can be imported")
    files = [Path(path) for path in paths]
    chosen = read_mapping(mapping) if mapping is not None else _preset(files[0], vehicle is not None)
    if chosen.header:
        chosen = _with_header(chosen, files[0], vehicle is not None)
    log = Log(chosen.wanted)
    for file in files:
        _reader(file, chosen)(file, log)
    if (chosen.preset or chosen.header) and table.NAME in log.streams:
        chosen = settled(chosen, log, table.NAME)
    known = load_vehicle(vehicle) if isinstance(vehicle, str | Path) else vehicle
    found = columns(log, chosen, known)
    if not found.samples:
        heard = ", ".join(f"{name} ({each.kind})" if each.kind else name for name, each in sorted(log.streams.items()))
        raise InputError(f"{files[0]}: no channel of a vehicle found by {chosen.path.name}; write a mapping file for "
                         f"--map; there are: {heard or 'no messages'}{log.lost('; ')}")  # fmt: skip
    start = min(float(time_s[0]) for time_s, _ in found.samples.values())
    channels = {name: (np.round(time_s - start, DECIMALS), values) for name, (time_s, values) in
                found.samples.items()}  # fmt: skip
    run = Run.from_channels(files[0].stem, channels)
    found.remarks += contradictions(run)
    if known:
        try:
            check_recorded(run, known)
        except InputError as error:  # a diagnosis will refuse what the vehicle file does not know; the log is not wrong
            found.remarks.append(str(error))
    return Imported(run, log, found, decidable(run, found.armed), chosen)


def _kind(path: Path) -> str:
    """What a file is, by its first bytes; "table" for all else. InputError where it cannot be read."""
    if path.is_dir():
        return "rosbag2 folder"
    check_file(path, math.inf)
    try:
        with path.open("rb") as file:
            head = file.read(16)
    except OSError as error:
        raise unread(path, error) from None
    if not head:
        raise InputError(f"{path}: the file is empty, expected a log")
    heads = {ULOG_HEAD: "ulog", mcap.HEAD: "mcap", rosbag1.HEAD: "rosbag1", rosbag2.HEAD: "rosbag2",
             dataflash.MARK: "dataflash"}  # fmt: skip
    known = next((kind for start, kind in heads.items() if head.startswith(start)), "")
    if known not in BAGS:
        check_file(path, LOG_BYTES)
    return known or ("tlog" if len(head) > 8 and head[8] in tlog.MAGIC and head[0] == 0 else "table")


def _reader(path: Path, mapping: Mapping) -> Reader:
    """What reads a file."""
    readers: dict[str, Reader] = {
        "rosbag2 folder": rosbag2.read_folder,
        "rosbag2": rosbag2.read,
        "rosbag1": rosbag1.read,
        "mcap": mcap.read,
        "ulog": ulog.read,
        "dataflash": dataflash.read,
        "tlog": tlog.read,
        "table": partial(table.read, mapping=mapping),
    }
    return readers[_kind(path)]


def _preset(path: Path, named: bool) -> Mapping:
    """The mapping that vtank brings for a kind of log; that of a table is its header. named: whether thrusters are."""
    kind = _kind(path)
    if kind == "table":
        return Mapping(PRESETS / HEADER, channels(table.dialect(path).header, table.NAME, named), preset=True)
    names = {"tlog": "ardusub-tlog", "dataflash": "ardusub-bin", "ulog": "px4"}
    return read_mapping(PRESETS / f"{names.get(kind, 'ros')}.toml")


def _with_header(mapping: Mapping, path: Path, named: bool) -> Mapping:
    """The mapping of a table with what its header means of all columns that the mapping does not take itself."""
    if (kind := _kind(path)) != "table":
        raise InputError(f"{mapping.path}: preset: 'header' is that of tables in text, and {path} is none ({kind})")
    taken = {name for channel in mapping.channels for name in channel.fields}
    left = [name for name in table.dialect(path, mapping.time).header if name not in taken]
    return replace(mapping, channels=mapping.channels + channels(left, table.NAME, named))
