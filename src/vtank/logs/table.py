"""Tables in text of any dialect: comma, semicolon, tabulator or bar; decimal comma; units in the header."""

from __future__ import annotations

import csv
import math
import re
from array import array
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import islice
from pathlib import Path
from typing import TextIO

from ..errors import InputError
from ..record.columns import column
from .header import TIME_UNIT, TIMES, parse
from .log import Log
from .mapping import Mapping
from .units import factor

NAME = "table"  # of the one stream that a table is
DELIMITERS = (";", "\t", "|", ",")
EMPTY = {"", "nan", "null", "none", "na", "n/a", "-", "--"}
CLOCK = re.compile(r"(\d{1,6}):(\d\d):(\d\d(?:[.,]\d+)?)", re.ASCII)  # a time of day, or hours from a start
LONGEST = 2**18  # characters of a line; a choice
LOOK = 50  # lines by which the dialect is found; a choice
DAY_S = 86400.0  # [s] of a clock that tells the time of day
PAUSE_S = 3600.0  # [s] without a row about midnight, up to which the clock is taken for that of the next day; a choice
SECOND_S = 1.0  # steps of whole numbers above it, without a unit, are milliseconds; a choice


@dataclass(frozen=True)
class Dialect:
    """How a table is written.

    Attributes:
        encoding, delimiter: of the text.
        comma: whether it stands for the decimal point.
        header: names of the columns, with their units as in the file.
        skip: lines above the numbers.
        time: index of the column of times.
        time_unit: "" where the header does not tell it.
    """

    encoding: str
    delimiter: str
    comma: bool
    header: tuple[str, ...]
    skip: int
    time: int
    time_unit: str


def dialect(path: Path, time: tuple[str, str] | None = None) -> Dialect:
    """How a table is written; `time` names its column of times and their unit. InputError where it is no table."""
    encoding = _encoding(path)
    with path.open(encoding=encoding, errors="replace", newline="") as file:
        lines = [line.rstrip("\r\n") for line in islice(_lines(file), LOOK)]
    delimiter = next((each for each in DELIMITERS if sum(each in line for line in lines) > len(lines) // 2), "")
    if not delimiter:
        raise InputError(
            f"{path}: no log that is known, and no table: expected columns separated by , ; | or tabulator"
        )
    comma = delimiter != "," and any(re.search(r"(^|\W)-?\d+,\d+($|\W)", line) for line in lines)
    rows = [_cells(line, delimiter) for line in lines]
    first = next((k for k, row in enumerate(rows) if len(row) > 1 and _numeric(row, comma)), len(rows))
    words = [k for k in range(first) if len(rows[k]) > 1 and len(rows[k]) == len(rows[min(first, len(rows) - 1)])]
    if first == len(rows) or not words:
        raise InputError(f"{path}: expected a header with column names above rows of numbers")
    names = [name.lstrip("#% ").strip() for name in rows[words[0]]]
    if len(words) > 1:  # a row of units below the names
        units = [unit.strip(" []()") for unit in rows[words[-1]]]
        names = [
            f"{name} [{unit}]" if unit and not column(name) else name for name, unit in zip(names, units, strict=True)
        ]
    time_column, unit = _time(path, names, time)
    return Dialect(encoding, delimiter, comma, tuple(names), first, time_column, unit)


def read(path: Path, log: Log, mapping: Mapping) -> None:
    """Read a table as one stream; cells that are no numbers are counted, empty ones are no sample."""
    log.kind = "table in text"
    how = dialect(path, mapping.time)
    stream, wanted = log.stream(NAME), []
    stream.sample = dict.fromkeys((*how.header[: how.time], *how.header[how.time + 1 :]), 0.0)
    wanted = [(how.header.index(name), values) for name, values in stream.values.items() if name in how.header]
    absent = [values for name, values in stream.values.items() if name not in how.header]
    stamps, short = array("d"), 0
    for cells in _rows(path, how, log):
        time = stamp(cells[how.time], how.comma) if len(cells) == len(how.header) else math.nan
        if not math.isfinite(time):
            short += 1
            continue
        stamps.append(time)
        for k, values in wanted:
            values.append(_number(cells[k], how, log, how.header[k]))
        for values in absent:
            values.append(math.nan)
    if short and not stamps:
        raise InputError(f"{path}: no row is complete and has a time in column '{how.header[how.time]}'; expected a "
                         "number, a date or h:m:s in each")  # fmt: skip
    if short:
        log.remarks.append(f"{short} rows are incomplete or have no time: left out")
    scale = _time_scale(how, stamps, log)
    for time_s in _past_midnight([time * scale for time in stamps], log):
        stream.tick(time_s)
        stream.time_s.append(time_s)


def _rows(path: Path, how: Dialect, log: Log) -> Iterator[list[str]]:
    """Rows of numbers; a last line without an end and with cells missing is the place where the log was cut off."""
    with path.open(encoding=how.encoding, errors="replace", newline="") as file:
        for line in islice(_lines(file), how.skip, None):
            text = line.rstrip("\r\n")
            if text.strip():
                cells = _cells(text, how.delimiter)
                if len(cells) < len(how.header) and not line.endswith("\n"):
                    log.cut("the last line is not whole")
                    return
                yield cells


def _lines(file: TextIO) -> Iterator[str]:
    """Lines, the longest in pieces, so that a file that has none fills no memory."""
    return iter(lambda: file.readline(LONGEST), "")


def _cells(line: str, delimiter: str) -> list[str]:
    """The cells of a line; quotes stay as they are about a cell that is too long for csv."""
    cells = line.split(delimiter)
    if '"' in line:
        with suppress(csv.Error):
            cells = next(csv.reader([line], delimiter=delimiter))
    return [cell.strip() for cell in cells]


def _number(cell: str, how: Dialect, log: Log, name: str) -> float:
    value = _plain(cell, how.comma)
    if math.isnan(value) and cell.lower() not in EMPTY:
        log.lose(f"cells of '{name}'")
    return value


def _plain(cell: str, comma: bool) -> float:
    """A finite number as a run may hold it, else NaN: also of 1_000 and foreign digits, which float() takes."""
    if "_" in cell or not cell.isascii():
        return math.nan
    try:
        value = float(cell.replace(",", ".") if comma else cell)
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan


def stamp(cell: str, comma: bool) -> float:
    """A time as a number, a date with time of day, or a time of day, in seconds or the file's unit; NaN for others.

    A date without a zone is one of UTC, whatever the zone of the computer that reads it.
    """
    number = _plain(cell, comma)
    if not math.isnan(number):
        return number
    with suppress(ValueError):
        date = datetime.fromisoformat(cell.replace(",", "."))
        return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()
    parts = CLOCK.fullmatch(cell)
    if not parts:
        return math.nan
    return int(parts[1]) * 3600.0 + int(parts[2]) * 60.0 + float(parts[3].replace(",", "."))


def _numeric(row: list[str], comma: bool) -> bool:
    """Whether most cells of a row are numbers, times or empty, and one at least is a number."""
    numbers = sum(not math.isnan(stamp(cell, comma)) for cell in row)
    return numbers > 0 and numbers + sum(cell.lower() in EMPTY for cell in row) > len(row) // 2


def _encoding(path: Path) -> str:
    with path.open("rb") as file:
        head = file.read(65536)
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    try:
        head.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        return "latin-1" if error.start < len(head) - 4 else "utf-8-sig"
    return "utf-8-sig"


def _time(path: Path, names: list[str], time: tuple[str, str] | None) -> tuple[int, str]:
    """Index of the column of times, and their unit."""
    if time:
        if time[0] not in names:
            raise InputError(f"{path}: no column '{time[0]}' for the time; found {', '.join(names)}")
        return names.index(time[0]), time[1]
    for k, name in enumerate(names):
        stem, unit = parse(name)
        if stem in TIMES or (stem in TIME_UNIT and not unit):
            return k, unit or TIME_UNIT.get(stem, "")
    raise InputError(f"{path}: no column of times; expected one called time_s, time, t or timestamp, or [time] in a "
                     f"mapping file; found {', '.join(names)}")  # fmt: skip


def _past_midnight(times_s: list[float], log: Log) -> list[float]:
    """Times of a clock that counts the seconds of a day and goes back by one at midnight, as if it went on."""
    if not times_s or min(times_s) < 0.0 or max(times_s) > DAY_S:
        return times_s
    nights, found = 0, times_s[:1]
    for earlier, later in zip(times_s, times_s[1:], strict=False):
        nights += later - earlier < PAUSE_S - DAY_S
        found.append(later + nights * DAY_S)
    if nights:
        log.remarks.append(f"its clock goes back by a day {nights} time{'s' * (nights > 1)}: past midnight it goes on")
    return found


def _time_scale(how: Dialect, stamps: array[float], log: Log) -> float:
    """By what the times are multiplied to be seconds; where the header does not tell, by their size and steps."""
    if how.time_unit:
        return factor(how.time_unit, "s") or 1.0
    steps = sorted(later - earlier for earlier, later in zip(stamps, stamps[1:], strict=False))
    step = steps[len(steps) // 2] if steps else 0.0
    whole = all(time == int(time) for time in stamps[:LOOK])
    if stamps and abs(stamps[0]) > 1e17:
        unit = "ns"
    elif stamps and abs(stamps[0]) > 1e14:
        unit = "us"
    elif (stamps and abs(stamps[0]) > 1e11) or (whole and step > SECOND_S):
        unit = "ms"
    else:
        return 1.0
    log.remarks.append(f"the times have no unit and are taken for {unit}")
    return factor(unit, "s") or 1.0
